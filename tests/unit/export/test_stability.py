"""Exported models stay whole and finite: the least armature, and stiffness that the time step can hold."""

import json
import re

import mujoco
import numpy as np
import pytest

from linkwright.stages.export.mjcf.loops import stable_solref
from linkwright.stages.export.stability.armatures import with_armatures
from linkwright.stages.mujoco.trial import Trial, trial_run
from linkwright.stages.robot.dynamics.driven import with_actuation
from linkwright.stages.robot.model.actuation import Actuation, Armature
from linkwright.stages.robot.model.robot import Dynamics, Relation
from linkwright.stages.validate import validate
from tests.support.building import plan_of, robot_of, write
from tests.support.cases import mostly_slow
from tests.support.checked import checked
from tests.support.exports import compiled, exported, messages_of
from tests.support.hands import hand
from tests.support.kit import four_bar
from tests.support.robots import joint, loop, robot_with

TILTED = {"pose": {"rpy": [0.5, 0.4, 0]}}


def tilted(robot, **keys):
    return exported(robot, **{"scene": TILTED, **keys})


def bare(model):
    """The same model without armature."""
    model.dof_armature[:] = 0
    mujoco.mj_setConst(model, mujoco.MjData(model))
    return model


def opening(model, seconds):
    """The largest distance [m] between two sites that an equality connects, in a simulation from home; NaN if
    a number is none. Measured by the sites' places, at every step."""
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("home").id)
    worst = 0.0
    for _ in range(round(seconds / model.opt.timestep)):
        mujoco.mj_step1(model, data)
        ends = data.site_xpos[model.eq_obj1id] - data.site_xpos[model.eq_obj2id]
        worst = max(worst, float(np.linalg.norm(ends, axis=1).max()))
        mujoco.mj_step2(model, data)
        if data.warning.number.any():
            return float("nan")
    return worst


unstable_hands = pytest.mark.skipif(
    int(mujoco.__version__.split(".")[0]) < 4, reason="an older MuJoCo holds these light links by itself"
)

HANDS = [(seed, kind) for seed in range(6) for kind in ("revolute", "ball")]


@unstable_hands
@pytest.mark.parametrize(("seed", "kind"), mostly_slow(HANDS, 2))
def test_hand_of_light_links_gets_the_least_armature(seed, kind):
    robot = hand(seed, fingers=2 if seed == 0 else 4, closing=kind)
    outcome = tilted(robot)
    model = compiled(outcome)
    assert opening(model, 2.0) <= 1e-3
    assert not opening(bare(compiled(outcome)), 2.0) <= 1e-3
    added = {armature.dof: armature.value for armature in outcome.written.actuation.armatures}
    assert max(added.values()) < 5e-4
    (remark,) = messages_of(outcome, "W-ARMATURE")
    name, value = next(iter(added.items()))
    assert f"{name} ({value:g})" in remark
    for dof in robot.dofs:
        assert model.dof_armature[model.joint(dof.name).dofadr[0]] == pytest.approx(added.get(dof.name, 0.0))
    table = json.loads(outcome.files["robot.json"])
    marked = [dof["name"] for entry in table["joints"] for dof in entry["dofs"] if "estimated" in dof]
    assert sorted(marked) == sorted(added)


@pytest.mark.parametrize(
    "dynamics", [Dynamics(damping=1e-3), Dynamics(friction=1e-3), Dynamics(armature=1e-4)]
)
def test_hand_that_holds_by_itself_gets_no_armature(dynamics):
    outcome = tilted(hand(0, fingers=2, dynamics=dynamics))
    assert outcome.written.actuation.armatures == ()
    assert opening(compiled(outcome), 2.0) <= 1e-3


@unstable_hands
def test_trial_run_names_the_joints_that_lack_an_armature(tmp_path):
    robot, plan = hand(0, fingers=1), plan_of(scene=TILTED)
    outcome = write(robot, tmp_path, plan)
    good = {check.name: check for check in validate(tmp_path, outcome.written, plan)}
    assert good["scene.xml: trial run"].passed
    text = (tmp_path / "robot.xml").read_text()
    (tmp_path / "robot.xml").write_text(re.sub(r' armature="[^"]*"', "", text))
    (check,) = [check for check in checked(tmp_path, robot, plan) if check.fails]
    assert check.name == "scene.xml: trial run"
    assert re.search("loop[01](_axis)? opened by|infinite", check.detail)
    assert "f0" in check.detail
    fix = r"(armature|damping) would fix it: joints: \{f0\d_\w+_joint: |timestep="
    assert re.search(fix, check.detail)


def test_given_armature_stays_even_if_it_is_too_small():
    outcome = tilted(hand(0, fingers=1, dynamics=Dynamics(armature=1e-9)))
    assert outcome.written.actuation.armatures == ()
    model = compiled(outcome)
    assert set(model.dof_armature) == {1e-9}
    # Without an MJCF there is no trial, and no armature.
    assert tilted(hand(0, fingers=1), export={"urdf": {}}).written.actuation.armatures == ()


@pytest.mark.parametrize("timestep", [0.001, 0.005, 0.01])
def test_loops_are_as_stiff_as_the_time_step_can_hold(kit, timestep):
    four_bar(kit)
    robot = robot_of(kit.document)
    model = compiled(tilted(robot, scene={"option": {"timestep": timestep}}))
    assert set(model.eq_solref[:, 0]) == {max(0.005, 2 * timestep)}
    assert opening(model, 2.0) <= 1e-3


def test_given_stiffness_and_damping_stay():
    assert stable_solref((-1000.0, -10.0), 0.01) == (-1000.0, -10.0)
    assert stable_solref((0.05, 0.7), 0.01) == (0.05, 0.7)


def test_dof_of_a_carrier_can_get_an_armature():
    """With prismatic mates that close a loop: their dofs are joints of the MJCF, but not of the tree."""
    arms = [joint("revolute", "base", name, [0.0]) for name in ("one", "two")]
    slide = loop("prismatic", "one", "two", np.eye(4), np.eye(4), [0.0], name="rail")
    robot = robot_with(arms, loops=[slide])
    built = with_actuation(robot, Actuation(armatures=(Armature("rail", 0.3, "stability"),)))
    assert built.loops[0].dofs[0].dynamics.armature == 0.3


def test_armature_goes_to_others_if_the_failing_joint_has_one():
    """A pendulum that hangs on a joint with an armature may throw that joint about."""
    arm = joint("revolute", "base", "arm", [0.0], dynamics=Dynamics(armature=1.0))
    robot = robot_with([arm, joint("revolute", "arm", "bob", [0.0]), joint("revolute", "base", "far", [0.0])])
    failed = arm.dofs[0].name

    def run(_, actuation, margin):
        added = {armature.dof: armature.value for armature in actuation.armatures}
        return Trial("" if len(added) == 2 else "its speeds became infinite", margin, (failed,))

    actuation, (remark,) = with_armatures(robot, Actuation(), run)
    assert {armature.dof for armature in actuation.armatures} == {dof.name for dof in robot.dofs} - {failed}
    assert remark.code == "W-ARMATURE"


def test_armature_of_a_turn_ignores_the_mass_that_a_slide_moves():
    """Also of a slide that has an armature: [kg] and [kg m²] cannot be compared."""

    def added(dynamics):
        slide = joint("prismatic", "base", "sled", [0.0], dynamics=dynamics)
        turn = joint("revolute", "sled", "arm", [0.0])
        screw = Relation("screw", slide.dofs[0].name, turn.dofs[0].name, 0.01, 0.0)

        def run(_, actuation, margin):
            return Trial("" if actuation.armatures else "unstable", margin, (turn.dofs[0].name,))

        actuation, _ = with_armatures(robot_with([slide, turn], relations=[screw]), Actuation(), run)
        return {armature.dof: armature.value for armature in actuation.armatures}

    assert added(Dynamics(armature=0.1)).items() <= added(Dynamics()).items()


def test_armature_that_does_not_help_is_not_added():
    arm = joint("revolute", "base", "arm", [0.0])
    tries = []

    def run(_, actuation, margin):
        tries.append(sum(armature.value for armature in actuation.armatures))
        return Trial("its speeds became infinite", margin, (arm.dofs[0].name,))

    assert with_armatures(robot_with([arm]), Actuation(), run) == (Actuation(), ())
    assert tries == sorted(set(tries))


@unstable_hands
def test_trial_run_names_the_joint_and_the_loop():
    outcome = trial_run(bare(compiled(tilted(hand(0, fingers=1, dynamics=Dynamics(armature=1e-9))))))
    assert outcome.failed
    assert outcome.joints
    assert all(name.endswith("_joint") for name in outcome.joints)
    assert 0 < outcome.time <= 2.0


def test_large_robot_runs_for_a_shorter_time():
    chain, above = [], "base"
    for number in range(250):
        chain.append(joint("revolute", above, f"l{number}", [0.0]))
        above = f"l{number}"
    model = compiled(exported(robot_with(chain), export={"mjcf": {}}))
    assert trial_run(model).time == pytest.approx(2e-3 * int(1e7 / 250**2))
