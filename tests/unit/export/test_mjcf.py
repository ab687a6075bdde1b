"""The MJCF, read back by MuJoCo: joints, loops and shapes of every type, and its default classes."""

import math

import mujoco
import numpy as np
import pytest
from lxml import etree

from linkwright.stages.export.ground.standing import stand
from linkwright.stages.export.mjcf import model as mjcf_model
from linkwright.stages.export.settled import settle
from linkwright.stages.export.writer import WriterInput
from linkwright.stages.export.writers import WRITERS
from linkwright.stages.formats.written import Written
from linkwright.stages.mesh import make_geometry
from linkwright.stages.robot.model.poses import (
    inverse,
    motion,
    quat_from_rotation,
    rotation_from_quat,
    rotation_from_rpy,
)
from linkwright.stages.robot.model.robot import Dynamics, Frame, Inertial, Limits, Primitive, Relation, frozen
from linkwright.stages.robot.motion.kinematics import link_poses, saved_configuration
from linkwright.stages.robot.motion.start_pose import starting_point
from tests.support import robots
from tests.support.building import NO_MESHES, plan_of, solid, write
from tests.support.exports import exported, losses_of
from tests.support.robots import EVERY, at, joint, loop, robot_with, some_value, some_values
from tests.support.states import pose_of, state
from tests.support.touching import NO_FILES, ball, box, no_memo

NUMBERS = 1e-10
"""What the formatter's 1e-12 of every number adds up to along a chain of nine joints."""


def model_of(robot, geometry=NO_MESHES, **keys):
    """The model of the writer's file alone, without what a whole export adds to the robot."""
    plan = settle(plan_of(**keys), robot)
    inputs = WriterInput(Written(robot, geometry=geometry), plan, stand(robot, geometry, plan))
    files = WRITERS["mjcf"].write(inputs).files
    return mujoco.MjModel.from_xml_string(files[f"{robot.name}.xml"].decode())


def set_values(model, robot, q):
    """The tree's joints at `q`; the robot stands at the world's origin."""
    data = mujoco.MjData(model)
    start = starting_point(robot)
    for placed in robot.joints:
        for dof in placed.dofs:
            numbers = q[dof.name]
            pose = motion(dof.kind, dof.axis, q[dof.name])
            if dof.kind == "ball":
                zero = motion(dof.kind, dof.axis, start[dof.name])
                numbers = quat_from_rotation((inverse(zero) @ pose)[:3, :3])
            if dof.kind == "free":
                pose = placed.parent_from_joint @ pose
                numbers = [*pose[:3, 3], *quat_from_rotation(pose[:3, :3])]
            first = model.joint(dof.name).qposadr[0]
            data.qpos[first : first + np.size(numbers)] = numbers
    mujoco.mj_kinematics(model, data)
    return data


def chain_of_all(rng, backwards):
    """One joint of each type in a row, at odd places, with odd origins between the dofs."""
    made, above = [], "base"
    for kind in [kind for kind in EVERY if kind != "free"]:
        chain = robots.CHAINS[kind]
        values = [some_value(freedom, rng) for _, freedom, _ in chain]
        origins = [robots.pose(rng) for _ in chain[1:]]
        place = {"place": robots.pose(rng), "backwards": backwards, "origins": origins}
        made.append(joint(kind, above, kind, values, **place))
        above = kind
    made.append(joint("free", "base", "loose", [some_value("free", rng)], place=robots.pose(rng)))
    made.append(joint("revolute", "loose", "flap", [0.4], place=robots.pose(rng)))
    return made


def tied(robot):
    """A relation that holds at the saved pose alone, and so moves qpos0 there."""
    follower, driver = [dof for dof in robot.dofs if dof.kind in ("turn", "slide")][:2]
    return Relation("tie", follower.name, driver.name, 0.3, follower.saved - 0.3 * driver.saved)


@pytest.mark.parametrize("backwards", [False, True])
@pytest.mark.parametrize("from_saved", [False, True])
def test_every_joint_moves_as_the_robots_own_kinematics(backwards, from_saved):
    rng = np.random.default_rng(7)
    joints = chain_of_all(rng, backwards)
    relations = [tied(robot_with(joints))] if from_saved else []
    robot = robot_with(
        joints, relations=relations, frames=[Frame("tip", "parallel", robots.pose(rng), "Tip")]
    )
    start = starting_point(robot)
    assert (start == saved_configuration(robot)) == from_saved
    model = model_of(robot)
    for _ in range(5):
        q = some_values(robot, rng)
        data = set_values(model, robot, q)
        expected = link_poses(robot, q)
        for name, pose in expected.items():
            assert np.abs(pose_of(data.body(name)) - pose).max() < NUMBERS, name
        tip = expected["parallel"] @ robot.frames[0].link_from_frame
        assert np.abs(pose_of(data.site("tip")) - tip).max() < NUMBERS


def test_root_called_world_is_the_worldbody():
    rng = np.random.default_rng(5)
    tip = Frame("tip", "world", robots.pose(rng), "Tip")
    joints = [
        joint("ball", "world", "arm", [(0.6, 0.0, 0.8, 0.0)], place=robots.pose(rng)),
        joint("free", "world", "loose", [some_value("free", rng)], place=robots.pose(rng)),
    ]
    robot = robot_with(joints, root="world", frames=[tip])
    scene = robots.from_parts(rotation_from_rpy((0.1, 0.2, 0.3)), np.array([1.0, 2.0, 3.0]))
    model = model_of(robot, scene__pose={"xyz": [1, 2, 3], "rpy": [0.1, 0.2, 0.3]})
    assert [model.body(index).name for index in range(model.nbody)] == ["world", "arm", "loose"]
    data = state(model, "cad")
    for name, pose in link_poses(robot, saved_configuration(robot)).items():
        if name != "world":
            assert np.abs(pose_of(data.body(name)) - scene @ pose).max() < NUMBERS
    assert np.abs(pose_of(data.site("tip")) - scene @ tip.link_from_frame).max() < NUMBERS
    assert np.abs(pose_of(data.site("world")) - scene).max() < NUMBERS


def test_keyframes_are_in_mujocos_order():
    """Links breadth first; MuJoCo numbers them depth first."""
    joints = [
        joint("cylindrical", "base", "one", (0.1, 0.2)),
        joint("ball", "base", "two", [some_value("ball", np.random.default_rng(2))]),
        joint("planar", "one", "three", (0.3, 0.4, 0.5), backwards=True),
        joint("revolute", "two", "four", (0.6,), limits={"four_joint": Limits(-0.5, 0.5)}),
    ]
    robot = robot_with(joints, fixed=False)
    model = model_of(robot)
    for key, last in (("cad", 0.6), ("home", 0.5)):
        data = state(model, key)
        for name, pose in link_poses(robot, dict(saved_configuration(robot), four_joint=last)).items():
            assert np.abs(pose_of(data.body(name)) - pose).max() < NUMBERS


def test_limits_and_dynamics_belong_to_each_dof():
    limits = {"arm_joint_slide": Limits(-0.1, 0.2), "tip_joint": Limits(upper=0.5)}
    more = {"limits": limits, "dynamics": Dynamics(damping=0.1, friction=0.2, armature=0.3, effort=4.0)}
    robot = robot_with([joint("cylindrical", "base", "arm", **more), joint("ball", "arm", "tip", **more)])
    model = model_of(robot)
    assert list(model.joint("arm_joint_slide").range) == [-0.1, 0.2]
    assert not any(model.jnt_limited[model.joint(name).id] for name in ("arm_joint_turn", "tip_joint"))
    assert list(model.dof_damping) == [0.1] * 5
    lost = losses_of(exported(robot, export={"mjcf": {}}), "robot.xml")
    assert {"W-BALL-CONE", "W-BALL-EFFORT", "I-BALL-ZERO"} == lost.keys() - {"I-BALL-START"}
    assert all("tip_joint" in message for message in lost.values())


def tensor_of(model):
    """The inertia of the arm (3, 3) in the axes of its body, as MuJoCo moves it."""
    data, arm = state(model), model.body("arm").id
    turned = data.xmat[arm].reshape(3, 3).T @ data.ximat[arm].reshape(3, 3)
    return turned @ np.diag(model.body_inertia[arm]) @ turned.T


@pytest.mark.parametrize("size", [1.0, 1e-7, 1e-10])
def test_inertias_are_written_about_principal_axes(size):
    """Every MuJoCo takes these as they are; of whole tensors those up to 3.13 lose the sixth digit, and
    of small ones more."""
    turned = rotation_from_quat(np.array([0.2, 0.3, -0.7, 0.4]))
    tensor = frozen(size * turned @ np.diag([1.0, 0.8, 0.5]) @ turned.T)
    arm = Inertial(size, frozen(np.zeros(3)), tensor)
    model = model_of(robot_with([joint("revolute", "base", "arm")], inertials={"arm": arm}))
    assert np.abs(tensor_of(model) - tensor).max() < 1e-11 * size


@pytest.mark.parametrize("angle", [1e-9, 1.1e-8, 3e-7, 2e-6, 1e-4])
def test_inertia_that_is_turned_a_little_stays_turned(angle):
    """MuJoCo moves an inertial that is turned by less than 1e-6 rad with the body's own axes."""
    turned = rotation_from_rpy((0.0, angle, 0.0))
    tensor = frozen(turned @ np.diag([1.0, 0.8, 0.5]) @ turned.T)
    arm = Inertial(1.0, frozen(np.zeros(3)), tensor)
    model = model_of(robot_with([joint("ball", "base", "arm")], inertials={"arm": arm}))
    assert np.abs(tensor_of(model) - tensor).max() < 2e-12


def test_primitives_have_mujocos_half_sizes():
    place = robots.pose(np.random.default_rng(4))
    sizes = {"box": (0.2, 0.4, 0.6), "sphere": (0.1,), "cylinder": (0.1, 0.4), "capsule": (0.1, 0.4)}
    halves = {"box": (0.1, 0.2, 0.3), "sphere": (0.1,), "cylinder": (0.1, 0.2), "capsule": (0.1, 0.2)}
    shapes = tuple(Primitive(kind, size, frozen(place), (1.0, 0.0, 0.0, 1.0)) for kind, size in sizes.items())
    robot = robot_with([joint("revolute", "base", "arm")], shapes={"arm": shapes})
    model = model_of(robot, solid(robot))
    assert model.ngeom == 8
    for index, (kind, half) in enumerate(halves.items()):
        geom = model.geom(f"arm_collision_{index}")
        assert geom.type == getattr(mujoco.mjtGeom, f"mjGEOM_{kind.upper()}")
        assert np.allclose(geom.size[: len(half)], half)
        assert np.allclose(geom.pos, place[:3, 3])
    assert model.body_mass.sum() == pytest.approx(sum(link.inertial.mass for link in robot.links))


def test_floating_base_has_a_free_joint(tmp_path):
    robot = robot_with([joint("revolute", "base", "arm")], fixed=False)
    write(robot, tmp_path, plan_of(scene={"pose": {"xyz": [1, 2, 3], "rpy": [0, 0, math.pi / 2]}}))
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "scene.xml"))
    assert (model.nq, model.nv) == (8, 7)
    assert model.joint("base_free").type == mujoco.mjtJoint.mjJNT_FREE
    assert np.allclose(model.qpos0[:7], [1, 2, 3, math.sqrt(0.5), 0, 0, math.sqrt(0.5)], atol=1e-12)
    assert np.allclose(model.key("cad").qpos[:7], model.qpos0[:7])


SOFT = {"friction": [0.8, 0.02, 0.001], "condim": 6, "priority": 1}


def crawler():
    """Joints of two motors, a slider, a ball, a loop and a relation; feet and a body that collide."""
    strong = Dynamics(damping=0.1, friction=0.02, armature=0.01, effort=20)
    weak = Dynamics(damping=0.05, armature=0.001, effort=3)
    joints = []
    for side, x in (("a", 0.1), ("b", 0.2), ("c", 0.3)):
        hip = {"name": f"hip_{side}", "limits": {f"hip_{side}": Limits(-1, 1)}, "place": at(x, 0, 0)}
        joints.append(joint("revolute", "base", f"leg_{side}", dynamics=strong, **hip))
    for side in "ab":
        ankle = {"name": f"ankle_{side}", "place": at(0, 0, -0.2)}
        joints.append(joint("revolute", f"leg_{side}", f"foot_{side}", dynamics=weak, **ankle))
    joints.append(joint("prismatic", "base", "mast", name="mast"))
    joints.append(joint("ball", "mast", "head", name="neck"))
    joints.append(joint("revolute", "base", "bare", name="bare"))
    return robot_with(
        joints,
        loops=[loop("revolute", "leg_c", "bare", at(0, 0.1, 0), at(0.3, 0.1, 0))],
        relations=[Relation("gear", "hip_b", "hip_a", -1.0, 0.0)],
        shapes={"base": (box(0.4, 0.1, 0.1),), "foot_a": (ball(0.02),), "foot_b": (ball(0.02),)},
    )


KEYS = {
    "actuators": {"hip_*": {"type": "position", "kp": 20}, "ankle_*": {"type": "motor"}},
    "geoms": {"foot_*": {"collision": SOFT}},
}


def written(folder, keys=KEYS):
    """The elements of the crawler's MJCF, and the model that MuJoCo compiles."""
    robot = crawler()
    geometry = make_geometry(robot, NO_FILES, plan_of(contact={"self": "auto"}, **KEYS), no_memo)
    write(robot, folder, plan_of(**keys), geometry)
    path = str(folder / "robot.xml")
    return etree.parse(path).getroot(), mujoco.MjModel.from_xml_path(path)


def arrays(model):
    values = {name: getattr(model, name) for name in dir(model) if not name.startswith("_")}
    return {name: v.copy() for name, v in values.items() if isinstance(v, np.ndarray) and name != "names"}


def test_classes_change_no_number(tmp_path, monkeypatch):
    first = arrays(written(tmp_path / "with")[1])
    monkeypatch.setattr(mjcf_model, "write_classes", lambda *_: None)
    second = arrays(written(tmp_path / "without")[1])
    assert "geom_friction" in first
    assert first.keys() == second.keys()
    assert [key for key in first if not np.array_equal(first[key], second[key], equal_nan=True)] == []


def test_attributes_of_a_class_are_not_repeated(tmp_path):
    root, _ = written(tmp_path)
    held = {}
    for default in root.iter("default"):
        elements = [element for element in default if element.tag != "default"]
        attributes = {key: value for element in elements for key, value in element.items()}
        above = held.get(default.getparent().get("class"), {})
        if default.get("class"):
            held[default.get("class")] = {**above, **attributes}
    assert {"hip", "ankle", "slide", "ball", "closure", "motor", "foot"} <= set(held)
    used = [element for element in root.iter() if element.get("class") and element.tag != "default"]
    assert {element.get("class") for element in used} <= set(held)
    for element in used:
        again = {key for key, value in element.items() if held[element.get("class")].get(key) == value}
        assert not again, etree.tostring(element)
    world = root.find("worldbody")
    joints = {element.get("name"): element.get("class") for element in world.iter("joint")}
    assert joints["hip_a"] == joints["hip_b"] == joints["hip_c"] == "hip"
    assert joints["ankle_a"] == joints["ankle_b"] == "ankle"
    assert all(element.get("class") for element in world.iter("geom", "joint"))
    assert not [geom for geom in world.iter("geom") if {"contype", "conaffinity", "group"} & set(geom.keys())]


def test_class_is_named_after_its_motor_or_its_joints(tmp_path):
    root, _ = written(tmp_path, {"actuators": {"hip_[ab]": {"motor": "sts3215"}, "ankle_*": "position"}})
    classes = {element.get("name"): element.get("class") for element in root.find("worldbody").iter("joint")}
    assert (classes["hip_a"], classes["ankle_a"]) == ("sts3215", "ankle")
    # Not `hip`: others are called so, too.
    assert classes["hip_c"] == "hinge"
