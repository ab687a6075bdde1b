"""Targets: what the configuration says of them, what they make of it, and what readers drop."""

import json
from dataclasses import replace
from typing import get_args

import mujoco
import numpy as np
import pytest

from linkwright.pipeline.config.compose import compose_plan
from linkwright.pipeline.errors import ConfigError
from linkwright.pipeline.page.readers import MAX_NAMES, readers
from linkwright.stages.export.requirements import require
from linkwright.stages.export.settled import report_changes, settle
from linkwright.stages.export.writers import WRITERS
from linkwright.stages.robot.model.actuation import Actuation, Actuator
from linkwright.stages.robot.model.geometry import Geometry, Shape
from linkwright.stages.robot.model.mjcf_extras import NO_EXTRAS
from linkwright.stages.robot.model.robot import Dynamics, Frame, Limits, Relation, frozen
from linkwright.stages.targets.engines import ENGINES, NO_LIMITS, MujocoVersion, shape_limits
from linkwright.stages.targets.options import actuation_of, flags_of, options_of
from linkwright.stages.targets.readers import READERS, rows_of
from linkwright.stages.targets.section import TargetSection
from linkwright.stages.targets.things import THINGS_OF_ROBOTS, reader_rows_of_robot
from linkwright.stages.validate.targets.model_things import MODEL_FINDERS
from linkwright.stages.validate.targets.text_things import TEXT_FINDERS
from tests.support import drake
from tests.support.building import NO_MESHES, plan_of
from tests.support.exports import exported
from tests.support.robots import at, joint, loop, robot_with

ARM = robot_with([joint("revolute", "base", "arm")])


def chosen(*arguments):
    return compose_plan(["source=sample", *arguments]).plan.tree()["target"]


def test_targets_are_chosen_as_formats_are_or_by_a_key():
    assert chosen() == chosen("target=none") == {}
    assert set(chosen("target=[mjx,newton]")) == {"mjx", "newton"}
    assert chosen("target.mjx.iterations=7")["mjx"]["iterations"] == 7
    assert chosen("target={mujoco: {version: '3.11'}, mjx: {}}")["mujoco"] == {"version": "3.11"}
    assert list(TargetSection.model_fields) == list(ENGINES)


def test_two_targets_that_exclude_each_other_are_both_named():
    with pytest.raises(ConfigError, match=r"mjx has iterations 10 and mjwarp has 9"):
        chosen("target=[mjx,mjwarp]", "target.mjwarp.iterations=9")
    assert set(chosen("target=[mjx,mjwarp]", "target.mjwarp.iterations=10")) == {"mjx", "mjwarp"}


def test_former_key_shows_the_new_line():
    with pytest.raises(ConfigError, match="target=mjx") as refused:
        chosen("mesh.target=mjx")
    assert "mesh.target" in str(refused.value)


@pytest.mark.parametrize("version", get_args(MujocoVersion))
def test_version_may_be_typed_as_a_number(version):
    assert chosen(f"target.mujoco.version={version}")["mujoco"] == {"version": version}


def test_target_that_reads_no_format_of_the_build_is_refused():
    with pytest.raises(ConfigError, match="pybullet reads urdf"):
        require(plan_of(target={"pybullet": {}}, export={"sdf": {}}))
    with pytest.raises(ConfigError, match="gazebo reads sdf"):
        require(plan_of(target={"gazebo": {}}))
    require(plan_of(target={"gazebo": {}}, export={"sdf": {}}))


def test_user_wins_over_target_over_defaults():
    robot = ARM
    option = settle(plan_of(target={"mjx": {}}), robot).scene.option
    assert (option.iterations, option.ls_iterations, option.flag.eulerdamp) == (10, 20, "disable")
    assert option.integrator == "implicitfast"
    own = {"iterations": 30, "flag": {"eulerdamp": "enable"}}
    option = settle(plan_of(target={"mjx": {}}, scene__option=own), robot).scene.option
    assert (option.iterations, option.ls_iterations, option.flag.eulerdamp) == (30, 20, "enable")
    assert settle(plan_of(), robot).scene.option.iterations is None


def test_unknown_flag_of_a_source_is_no_error():
    extras = replace(NO_EXTRAS, flag=(("energy", "enable"), ("brandnew", "enable")))
    robot = replace(ARM, mjcf=extras)
    flag = settle(plan_of(target={"mjx": {}}), robot).scene.option.flag
    assert flag.explicit() == {"eulerdamp": "disable"}
    assert settle(plan_of(), robot).scene.option.flag.explicit() == {"energy": "enable"}


def messages(robot, **tree):
    notes = report_changes(plan_of(**tree), robot)
    return [(note.message, note.hint) for note in notes if note.code == "I-TARGET"]


def test_settings_that_targets_change_are_reported():
    extras = replace(NO_EXTRAS, option=(("iterations", "50"),), flag=(("energy", "enable"),))
    robot = replace(ARM, mjcf=extras)
    targets = {name: {} for name in ("mjx", "mjwarp", "newton")}
    option = {"solver": "PGS", "ls_iterations": 9, "flag": {"fwdinv": "enable"}}
    ours = "without it this stays as it is"
    assert messages(robot, target=targets, scene__option=option) == [
        ("MuJoCo's options: iterations (50 → 10), eulerdamp (unset → disable)",
         "for mjx; target.mjx.iterations=null leaves it, and scene.option comes first"),
        ("MuJoCo's option solver: PGS → Newton, which looks for the same forces",
         "for mjx, mjwarp; without them this stays as it is"),
        ("MuJoCo's flag energy: enable → left out, which moves nothing", f"for mjx; {ours}"),
        ("MuJoCo's flag fwdinv: enable → left out, which moves nothing",
         "for mjx, mjwarp; without them this stays as it is"),
    ]  # fmt: skip
    assert messages(robot, target={"mujoco": {}, "newton": {}}, scene__option=option) == []
    assert messages(robot, scene__option=option) == []


def test_frames_have_an_inertial_for_pybullet_which_is_told():
    robot = replace(ARM, frames=(Frame("tip", "arm", frozen(np.eye(4)), ""),))
    targets = {"pybullet": {}, "drake": {}}
    none, tiny = ({"urdf": {"frame_inertia": kind}} for kind in ("none", "tiny"))
    changed = messages(robot, target=targets, export=none)
    assert [text for text, _ in changed] == ["export.urdf.frame_inertia: none → tiny"]
    assert messages(robot, target=targets, export=tiny) == messages(ARM, target=targets) == []
    for target, kind in (("pybullet", "tiny"), ("mjx", "none")):
        assert settle(plan_of(target={target: {}}), ARM).export.urdf.frame_inertia == kind


def test_limits_on_shapes_of_several_engines_add_up():
    assert shape_limits([]) == NO_LIMITS
    both = shape_limits(["mjx", "drake"])
    assert (both.excluded_kinds, both.vertices(64), both.vertices(16), both.needs_obj) == (
        ("cylinder", "ellipsoid"), 32, 16, True,
    )  # fmt: skip
    assert shape_limits(["drake"]).vertices(64) == 64


def test_options_without_effect_on_motion_are_replaced():
    warp = options_of(["mjwarp"], {"solver": "PGS", "timestep": 0.01})
    assert warp == {"solver": "Newton", "timestep": 0.01}
    assert options_of(["mujoco"], {"solver": "PGS"}) == {"solver": "PGS"}
    flags = {"energy": "enable", "fwdinv": "enable", "eulerdamp": "disable"}
    assert flags_of(["mjx"], flags) == {"eulerdamp": "disable"}
    assert flags_of(["mjwarp"], flags) == {"energy": "enable", "eulerdamp": "disable"}
    assert flags_of([], flags) == flags


def moved(actuator):
    """The motion of an arm under a control of 4, by MuJoCo."""
    gains = {"kp": actuator.kp, "kv": actuator.kv, **dict(actuator.terms)}
    text = " ".join(f'{key}="{value}"' for key, value in gains.items() if value is not None)
    model = mujoco.MjModel.from_xml_string(
        '<mujoco><option integrator="implicitfast"/><worldbody><body>'
        '<joint name="j" axis="0 1 0" armature="0.01"/>'
        '<geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.02"/></body></worldbody>'
        f'<actuator><{actuator.type} joint="j" gear="{actuator.gear}" {text}/></actuator></mujoco>'
    )
    data, path = mujoco.MjData(model), []
    data.ctrl[:] = 4.0
    for _ in range(400):
        mujoco.mj_step(model, data)
        path.append(float(data.qpos[0]))
    return np.array(path)


MOTOR = (("motorconst", "0.1 0.2"), ("resistance", "2"))
NOMINAL = (("nominal", "12 1 100"),)
PID = (("input", "pos"),)


@pytest.mark.parametrize(("before", "becomes"), [
    (Actuator("m", "j", "dcmotor", gear=3.0, terms=MOTOR), "general"),
    (Actuator("m", "j", "dcmotor", gear=3.0, terms=NOMINAL), "general"),
    (Actuator("m", "j", "pid", gear=2.0, kp=30.0, kv=2.0, terms=PID), "position"),
], ids=["constants", "nominal", "pid"])  # fmt: skip
def test_actuator_in_another_form_moves_the_robot_as_before(before, becomes):
    (after,) = actuation_of(["mjx"], Actuation(actuators=(before,))).actuators
    assert after.type == becomes
    assert np.abs(moved(before)).max() > 0.1
    assert moved(after) == pytest.approx(moved(before), abs=1e-9)


@pytest.mark.parametrize("actuator", [
    Actuator("m", "j", "dcmotor", terms=(*MOTOR, ("saturation", "1 2 3"))),
    Actuator("m", "j", "dcmotor", terms=(*MOTOR, ("inductance", "0.1 0"))),
    Actuator("m", "j", "pid", kp=1.0, terms=(*PID, ("ki", "2"))),
    Actuator("m", "j", "position", kp=1.0),
], ids=["saturation", "inductance", "integral", "position"])  # fmt: skip
def test_actuator_without_an_exact_form_stays(actuator):
    before = Actuation(actuators=(actuator,))
    assert actuation_of(["mjx", "mjwarp"], before) == before


def test_each_row_is_unique_and_was_measured_on_a_day_or_read():
    for row in READERS:
        assert row.format in WRITERS
        assert row.version
        assert row.does
        assert bool(row.measured) != bool(row.source), row
        assert not row.source or row.source.startswith("https://")
        assert row.evidence.startswith(("measured 2026-", "read in its "))
    assert len({(row.reader, row.version, row.format, row.thing) for row in READERS}) == len(READERS)
    assert {row.version for row in READERS if row.reader == "Drake"} == {drake.VERSION}, "that of the tests"


def test_row_says_in_what_it_was_read():
    read = {row.source: row.evidence for row in READERS if row.source}
    for source, place in (
        ("https://github.com/isaac-sim/IsaacSim/issues/841", "issues"),
        ("https://github.com/google-deepmind/mujoco/blob/3.17.0/mjx/mujoco/mjx/_src/mesh.py", "source"),
        ("https://docs.ros.org/en/jazzy/p/sdformat_urdf", "documentation"),
    ):
        assert read[source] == f"read in its {place}"


def test_report_says_how_a_target_meets_a_row():
    rows = reader_rows_of_robot(ARM, NO_MESHES, ["urdf"], {"pybullet": None})
    assert {row["reader"]: row.get("target") for row in rows}["PyBullet"] in ("refused", "stated", "replaced")
    assert all("target" not in row for row in reader_rows_of_robot(ARM, NO_MESHES, ["urdf"]))


def test_report_marks_the_rows_of_the_chosen_version():
    robot = robot_with([joint("revolute", "base", "arm", dynamics=Dynamics(0.1, 0.2, None, 3.0, 4.0))])

    def marked(**target):
        versions = TargetSection(**target).versions
        rows = reader_rows_of_robot(robot, NO_MESHES, ["mjcf"], versions)
        return {(row["reader"], row["version"]) for row in rows if "target" in row}

    assert (marked(mujoco={}), marked(mujoco={"version": "3.11"})) == (set(), {("MuJoCo", "3.11")})
    assert marked(mjx={}) == {("MJX", "3.17.0")}


def test_engine_has_the_words_of_its_mujoco():
    words = {name: {row.thing for row in rows_of(name, "mjcf")} for name in ("mjx", "mjwarp", "mujoco")}
    assert "words of MuJoCo 4.0" in words["mjx"]
    for name in ("mjwarp", "mujoco"):
        assert "words of MuJoCo 4.0" not in words[name]
        assert "words that MuJoCo 4.0 no longer has" in words[name]


HULL = Shape("arm", "collision", "arm_1.stl", None, 8, 12, 1.0, 1.0)


WHOLE = Shape("arm", "visual", "arm.glb", None, 8, 12, 1.0, 1.0)


SKIN = Shape("arm", "visual", "arm.obj", None, 8, 12, 1.0, 1.0)


def everything():
    dynamics = Dynamics(0.1, 0.2, None, 3.0, 4.0)
    rows = [
        joint("revolute", "base", "arm", dynamics=dynamics),
        joint("ball", "arm", "hand", limits={"hand_joint": Limits(None, 1.0)}),
        joint("revolute", "base", "gear", dynamics=dynamics),
        joint("revolute", "base", "lid", limits={"lid_joint": Limits(0.5, 1.0)}),
    ]
    relation = Relation("Gear", "gear_joint", "arm_joint", 2.0, 0.0)
    shut = loop("ball", "hand", "base", at(0, 0, 0), at(0, 0, 0), [(1.0, 0.0, 0.0, 0.0)])
    tip = Frame("tip", "hand", frozen(at(0, 0, 1)), "Tip")
    return robot_with(rows, relations=[relation], frames=[tip], loops=[shut])


def dropped(robot, geometry, *formats):
    rows = reader_rows_of_robot(robot, geometry, formats)
    return {(row["reader"], row["format"], row["thing"]): row["of"] for row in rows}


THINGS = {
    ("Drake", "sdf", "loops"): "loop", ("Isaac Sim", "urdf", "friction"): "arm_joint gear_joint",
    ("PyBullet", "sdf", "balls"): "hand_joint", ("PyBullet", "urdf", "frames"): "tip",
    ("Pinocchio", "urdf", "relations"): "gear_joint", ("Drake", "urdf", "colliders in STL"): "arm_1.stl",
    ("Drake", "urdf", "fixed base"): "base", ("Newton", "mjcf", "starts of joints"): "lid_joint",
    ("PyBullet", "urdf", "visuals in GLB"): "arm.glb",
}  # fmt: skip


def test_robot_with_everything_has_every_row():
    rows = dropped(everything(), Geometry((HULL, SKIN), {}, whole_visuals=(WHOLE,)), *WRITERS)
    assert set(rows) == {
        (row.reader, row.format, row.thing) for row in READERS if row.thing in THINGS_OF_ROBOTS
    }
    of_files = [row for row in READERS if row.thing not in THINGS_OF_ROBOTS]
    assert all(row.thing in MODEL_FINDERS or (row.format, row.thing) in TEXT_FINDERS for row in of_files)
    assert {row: " ".join(rows[row]) for row in THINGS} == THINGS


def test_rows_are_of_the_robots_things_in_written_formats():
    robot = robot_with([joint("revolute", "base", "arm")], fixed=False)
    geometry = Geometry((replace(HULL, file="arm_1.obj"), SKIN), {})
    assert set(dropped(robot, geometry, "urdf")) == {("PyBullet", "urdf", "inertia")}
    lost = ("PyBullet", "sdf", "everything")
    assert set(dropped(robot, geometry, "sdf")) == {lost}
    assert set(dropped(robot, Geometry((HULL,), {}), "sdf")) == {lost, ("Drake", "sdf", "colliders in STL")}


def test_report_has_the_dropped_things():
    made = exported(everything(), export={"sdf": {}})
    rows = json.loads(json.dumps(made.details))["readers"]
    assert {row["format"] for row in rows} == {"sdf"}
    page = readers(rows).replace("<wbr>", "")
    for text in ("What other readers drop", "bullet-featherstone", "gz-physics/issues/25", "measured"):
        assert text in page


def test_page_shows_some_names_and_counts_the_rest():
    names = [f"joint_{index}" for index in range(MAX_NAMES + 3)]
    row = {
        "reader": "R", "version": "1", "format": "urdf", "thing": "friction", "does": "x", "of": names,
        "source": "s",
    }  # fmt: skip
    page = readers([row])
    assert f"joint_{MAX_NAMES - 1} and 3 more" in page
    assert f"joint_{MAX_NAMES}," not in page
    assert readers([]) == ""
