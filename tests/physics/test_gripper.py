"""The sample's gripper closes on a cube and lifts it, with the colliders that the ladder makes."""

from pathlib import Path

import mujoco
import numpy as np
import pytest

from pipeline.build import build_files
from pipeline.config.compose import compose_plan

SIDE = 0.02
"""Of the cube [m]."""

GAINS = {
    "lift": 5000,
    "shoulder_yaw": 100,
    "shoulder": 100,
    "elbow": 50,
    "wrist_pitch": 50,
    "wrist_roll": 20,
    "left_finger": 10,
}
GRIP = 0.1
"""The most that the finger's motor gives [N·m], 2 N at the pad."""

TOUCHING = 0.006
"""The finger's angle at which the pads are 20 mm apart in CAD: 19.4 mm at 0, and 53 mm below the pivot."""


def sample(folder: Path) -> mujoco.MjSpec:
    told = ["robot=sample", "mesh=ladder", "contact.self=auto", "until=export"]
    told += [f"cache.dir={folder}/cache", f"output={folder}/out"]
    files = build_files(compose_plan(told, cwd=folder).plan, in_memory=True).files
    assets = {name: data for name, data in files.items() if name.startswith("assets/")}
    return mujoco.MjSpec.from_string(files["sample.xml"].decode(), assets=assets)


def looking_down(spec: mujoco.MjSpec) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The home pose with the gripper turned straight down and open: qpos, and the tool's place and axes."""
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("home").id)
    data.joint("wrist_pitch").qpos = data.joint("elbow").qpos - np.pi / 2
    data.joint("left_finger").qpos, data.joint("right_finger").qpos = 0.25, -0.25
    mujoco.mj_forward(model, data)
    tool = data.site("tool")
    assert tool.xmat[8] == pytest.approx(-1)
    assert data.ncon == 0
    return data.qpos.copy(), tool.xpos.copy(), tool.xmat.copy()


def with_cube(spec: mujoco.MjSpec, place: np.ndarray, axes: np.ndarray) -> mujoco.MjModel:
    """The robot with motors, weightless, and a cube of 20 g on a post where the tool is."""
    for name, gain in GAINS.items():
        motor = spec.add_actuator(name=name, target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        motor.set_to_position(kp=gain, dampratio=1)
        if name == "left_finger":
            motor.forcelimited, motor.forcerange = True, [-GRIP, GRIP]
    for body in spec.bodies[1:]:
        body.gravcomp = 1
    # Against the creep of MuJoCo's soft friction.
    spec.option.cone, spec.option.impratio = mujoco.mjtCone.mjCONE_ELLIPTIC, 10
    for key in list(spec.keys):
        spec.delete(key)
    quat = np.zeros(4)
    mujoco.mju_mat2Quat(quat, axes)
    box = mujoco.mjtGeom.mjGEOM_BOX
    spec.worldbody.add_geom(type=box, size=[0.005, 0.005, 0.01], pos=place - [0, 0, 0.02], quat=quat)
    cube = spec.worldbody.add_body(name="cube", pos=place, quat=quat)
    cube.add_freejoint()
    cube.add_geom(type=box, size=[SIDE / 2] * 3, mass=0.02)
    return spec.compile()


@pytest.mark.slow
def test_the_gripper_closes_on_a_cube_and_lifts_it(tmp_path: Path) -> None:
    spec = sample(tmp_path)
    start, place, axes = looking_down(spec)
    model = with_cube(spec, place, axes)
    data = mujoco.MjData(model)
    data.qpos[: len(start)] = start
    for name in GAINS:
        data.actuator(name).ctrl = data.joint(name).qpos

    def moves(actuator: str, to: float, seconds: float) -> None:
        data.actuator(actuator).ctrl = to
        mujoco.mj_step(model, data, round(seconds / model.opt.timestep))

    moves("left_finger", -0.17, 1.5)
    fingers = {int(model.body(f"{side}_finger_jaw").id) for side in ("left", "right")}
    cube = int(model.body("cube").id)
    pairs = {frozenset(model.geom_bodyid[contact.geom].tolist()) for contact in data.contact}
    assert {frozenset({cube, finger}) for finger in fingers} <= pairs
    # A tolerance of 1 mm in each pad, at a lever of 53 mm.
    assert float(data.joint("left_finger").qpos[0]) == pytest.approx(TOUCHING, abs=0.02)
    before = data.joint("lift").qpos[0]
    moves("lift", 0.05, 1.0)
    moves("lift", 0.05, 1.0)
    risen = data.joint("lift").qpos[0] - before
    assert risen > 0.025
    off = data.body("cube").xpos - place - [0, 0, risen]
    assert np.abs(off).max() < 0.002
    assert data.body("cube").xmat.reshape(3, 3)[:, 2] @ axes.reshape(3, 3)[:, 2] > 0.99
