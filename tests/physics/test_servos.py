"""Robots with `actuators=position`: they stand, they follow, and no control can make them explode."""

import shutil

import mujoco
import numpy as np
import pytest

from tests.fake_onshape.gallery import DOCUMENTS
from tests.support.command import environment, linkwright
from tests.support.other_robots import AS_IT_IS
from tests.support.places import SHARED

ROBOTS = SHARED / "data" / "robots"
REAL = {
    "so101": ("so101/Simulation/SO101/so101_new_calib.urdf", "fixed"),
    "reachy2": ("reachy2/reachy2_mujoco/description/modified_urdf/reachy2.urdf", "fixed"),
    "open_duck": ("open_duck_mini_bdx/mini_bdx/robots/bdx/robot.urdf", "free"),
}
"""Robot → its URDF, and how its base stands."""

TURN, SLIDE, BASE = 0.002, 0.0005, 0.005
"""How far [rad, m] a joint, and a free base [m], may move from home in 5 s."""

CREEP, TREMBLE = 1e-4, 1e-2
"""How fast [rad/s, m/s] anything may go on moving after that: over a second, and at one moment."""

SOLES = {"open_duck": (1e-3, 0.1)}
"""Robot → the same, of a robot of 1 kg on soft servos: the contacts of its flat soles come and go in MuJoCo
(with `impratio` 10 it is still)."""

DEEPEST = 5e-4
"""The deepest contact [m] at home."""


def build(name, folder, cache):
    environ = environment(folder, seeded=False, LINKWRIGHT_CACHE=str(cache))
    if name in DOCUMENTS:
        done = linkwright(folder, f"robot={name}", "mesh=hull", "output=out", environ=environ)
    else:
        path, base = REAL[name]
        if not (ROBOTS / path).exists():
            pytest.skip("there are no shared data")
        source = ("source=urdf", f"source.path={ROBOTS / path}", f"root={base}", "actuators=position")
        done = linkwright(folder, *source, "mesh=hull", *AS_IT_IS, "output=out", environ=environ)
    assert done.returncode == 0, done.stdout + done.stderr
    model = mujoco.MjModel.from_xml_path(str(folder / "out" / "scene.xml"))
    shutil.rmtree(folder / "out")
    return model


@pytest.fixture(
    scope="module",
    params=["sample", "quadruped", *(pytest.param(name, marks=pytest.mark.slow) for name in REAL)],
)
def model(request, tmp_path_factory, shared_cache):
    return build(request.param, tmp_path_factory.mktemp(request.param), shared_cache)


def at_home(model):
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("home").id)
    mujoco.mj_forward(model, data)
    return data


def warnings(data):
    return [number for number in data.warning.number.tolist() if number]


def test_robot_without_overlaps_holds_home_for_five_seconds(model, request):
    data = at_home(model)
    assert [contact for contact in data.contact if contact.dist < -DEEPEST] == []
    home = data.qpos.copy()
    mujoco.mj_step(model, data, round(4.0 / model.opt.timestep))
    before = data.qpos.copy()
    mujoco.mj_step(model, data, round(1.0 / model.opt.timestep))
    assert warnings(data) == []
    off = {}
    for joint in range(model.njnt):
        at, kind = model.jnt_qposadr[joint], model.jnt_type[joint]
        if kind == mujoco.mjtJoint.mjJNT_FREE:
            off["the base"] = float(np.linalg.norm(data.qpos[:3] - home[:3])) / BASE
        else:
            bound = TURN if kind == mujoco.mjtJoint.mjJNT_HINGE else SLIDE
            off[model.joint(joint).name] = abs(float(data.qpos[at] - home[at])) / bound
    assert {name: share for name, share in off.items() if share > 1} == {}
    crept = np.zeros(model.nv)
    mujoco.mj_differentiatePos(model, crept, 1.0, before, data.qpos)
    creep, tremble = SOLES.get(request.node.callspec.params["model"], (CREEP, TREMBLE))
    assert np.abs(crept).max() < creep
    assert np.abs(data.qvel).max() < tremble


@pytest.mark.parametrize("hold", [1, 25])
def test_ten_seconds_of_control_noise_over_the_full_range_are_stable(model, hold):
    """A new control for each actuator every `hold` steps."""
    data = at_home(model)
    random = np.random.default_rng(5)
    low, high = model.actuator_ctrlrange.T
    assert model.actuator_ctrllimited.all()
    for step in range(round(10.0 / model.opt.timestep)):
        if step % hold == 0:
            data.ctrl[:] = random.uniform(low, high)
        mujoco.mj_step(model, data)
        assert warnings(data) == [], f"at {data.time:.3f} s"
    assert np.isfinite(data.qpos).all()


@pytest.mark.parametrize("model", ["sample"], indirect=True)
def test_the_samples_arm_follows_a_trajectory_of_five_seconds(model):
    """From home to another pose and on to a third, with speeds that begin and end at 0 (minimum jerk). A
    slide's load is the same everywhere: above its end it follows at the distance by which it sags at home."""
    data = at_home(model)
    joints = model.actuator_trnid[:, 0]
    turns = model.jnt_type[joints] == mujoco.mjtJoint.mjJNT_HINGE
    at = model.jnt_qposadr[joints]
    start = data.ctrl.copy()
    sag = np.where(turns, 0.0, start - data.qpos[at])
    low, high = model.actuator_ctrlrange.T + np.array([[1], [0]]) * sag
    random = np.random.default_rng(11)
    ways = [start, *(np.clip(start + random.uniform(-0.5, 0.5, model.nu), low, high) for _ in range(2))]
    worst = np.zeros(model.nu)
    for _ in range(round(5.0 / model.opt.timestep)):
        leg, share = divmod(data.time / 2.5, 1.0)
        smooth = share**3 * (10 - 15 * share + 6 * share**2)
        begin, other = ways[int(leg)], ways[min(int(leg) + 1, 2)]
        data.ctrl[:] = begin + smooth * (other - begin)
        mujoco.mj_step(model, data)
        worst = np.maximum(worst, np.abs(data.qpos[at] + sag - data.ctrl))
    assert np.abs(ways[1] - start).max() > 0.3
    assert np.degrees(worst[turns]).max() < 2.0
    assert worst[~turns].max() < 2e-3
    assert warnings(data) == []
