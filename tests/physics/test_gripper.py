"""The sample's gripper closes on a cube and lifts it, and on nothing until its pads touch, with the colliders
that the ladder makes."""

import math

import mujoco
import numpy as np
import pytest

from linkwright.pipeline.config.compose import compose_plan
from linkwright.pipeline.run.build import build_files
from tests.support import kept_colliders

SIDE = 0.02
"""The side of the cube [m]."""

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


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    return build_of(tmp_path_factory.mktemp("gripper"))


@pytest.fixture(scope="module")
def by_part(tmp_path_factory):
    """With a collider for each part of the fingers."""
    return build_of(tmp_path_factory.mktemp("by_part"), 'mesh.colliders={"*finger_jaw": ladder}')


def build_of(folder, *more):
    kept_colliders.seed(folder / "cache")
    overrides = ["robot=sample", "mesh=ladder", "contact.self=auto", "actuators=none", "until=export"]
    overrides += [f"cache.dir={folder}/cache", f"output={folder}/out", *more]
    return build_files(compose_plan(overrides, cwd=folder).plan, in_memory=True)


def sample(built):
    assets = {name: data for name, data in built.files.items() if name.startswith("assets/")}
    return mujoco.MjSpec.from_string(built.files["sample.xml"].decode(), assets=assets)


def looking_down(spec):
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


def with_motors(spec):
    """Gives the robot motors, and makes it weightless."""
    for name, gain in GAINS.items():
        motor = spec.add_actuator(name=name, target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        motor.set_to_position(kp=gain, dampratio=1)
        if name == "left_finger":
            motor.forcelimited, motor.forcerange = True, [-GRIP, GRIP]
    for body in spec.bodies[1:]:
        body.gravcomp = 1


def with_cube(spec, place, axes):
    """The robot with motors and a cube of 20 g on a post where the tool is."""
    with_motors(spec)
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
def test_the_gripper_closes_on_a_cube_and_lifts_it(built):
    spec = sample(built)
    start, place, axes = looking_down(spec)
    model, data = standing(with_cube(spec, place, axes), start)

    def moves(actuator, to, seconds):
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


FINGERS = ("left_finger_jaw", "right_finger_jaw")

MEETING = math.atan2(0.0058, 0.0685) - math.asin(0.0155 / math.hypot(0.0058, 0.0685))
"""The left finger's angle at which the pads' tips meet half way between the pivots, which are 31 mm apart: in
CAD the pads' faces are 5.8 mm inwards of them and end 68.5 mm below."""


def geoms_of(built, part):
    """The names in the MJCF of the colliders of a part."""
    names = set()
    for link in FINGERS:
        first = 0
        for row in built.report.details["colliders"]:
            if row["link"] == link:
                if part in row["parts"][0]:
                    names |= {f"{link}_collision_{first + piece}" for piece in range(row["pieces"])}
                first += row["pieces"]
    return names


def between_fingers(model, data):
    """The names of the geoms of two fingers that are in contact now."""
    for contact in data.contact[: data.ncon]:
        names = [model.geom(geom).name for geom in contact.geom]
        if {name.partition("_collision")[0] for name in names} == set(FINGERS):
            yield frozenset(names)


def over_nothing(built):
    """The robot at home over nothing, whose fingers may go 0.03 rad further than where they meet."""
    spec = sample(built)
    start, _, _ = looking_down(spec)
    with_motors(spec)
    for name, limits in {"left_finger": [-0.17, 0.6], "right_finger": [-0.6, 0.17]}.items():
        spec.joint(name).range = limits
    return spec, *standing(spec.compile(), start)


def standing(model, start):
    data = mujoco.MjData(model)
    data.qpos[: len(start)] = start
    for name in GAINS:
        data.actuator(name).ctrl = data.joint(name).qpos
    return model, data


@pytest.mark.slow
def test_the_fingers_meet_when_the_gripper_closes_on_nothing(built):
    """Within the tolerance of each finger, 1.5 mm at a lever of 68 mm."""
    _, model, data = over_nothing(built)
    data.actuator("left_finger").ctrl = -0.17
    mujoco.mj_step(model, data, round(2.5 / model.opt.timestep))
    assert [*between_fingers(model, data)]
    assert float(data.joint("left_finger").qpos[0]) == pytest.approx(MEETING, abs=2 * 0.0015 / 0.0685)


@pytest.mark.slow
def test_fingers_of_a_closing_gripper_meet_and_gears_never_do(by_part):
    """The gears overlap by 1.9 mm."""
    spec, model, data = over_nothing(by_part)
    gears, pads = geoms_of(by_part, "Finger gear"), geoms_of(by_part, "Finger pad")
    assert len(pads) == 2
    met = set()
    for to in (-0.17, 0.4):
        data.actuator("left_finger").ctrl = to
        for _ in range(round(2.5 / model.opt.timestep)):
            mujoco.mj_step(model, data)
            met |= set(between_fingers(model, data))
        if to < 0:
            assert pads in between_fingers(model, data)
            assert float(data.joint("left_finger").qpos[0]) == pytest.approx(MEETING, abs=0.002)
    assert not [pair for pair in met if pair <= gears]
    # Where the fingers are not excluded, the gears touch all the way.
    for exclude in spec.excludes:
        if {exclude.bodyname1, exclude.bodyname2} == set(FINGERS):
            spec.delete(exclude)
    all_touch = spec.compile()
    there = mujoco.MjData(all_touch)
    there.qpos[:] = data.qpos
    mujoco.mj_forward(all_touch, there)
    assert [pair for pair in between_fingers(all_touch, there) if pair <= gears]
