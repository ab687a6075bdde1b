"""SDF of every kind of joint, loop and shape, as an independent reader and sdformat's own tool have it."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from linkwright.stages.formats.xml import parse
from linkwright.stages.robot.dynamics.mass_matrix import mass_matrix
from linkwright.stages.robot.model.poses import quat_from_rotation
from linkwright.stages.robot.model.robot import Dynamics, Frame, Limits, Primitive, Relation, frozen
from linkwright.stages.robot.motion.kinematics import link_poses, saved_configuration
from linkwright.stages.robot.motion.start_pose import starting_point
from tests.support.building import NO_MESHES, solid
from tests.support.engines import Pinocchio
from tests.support.exports import exported, losses_of
from tests.support.robots import (
    EVERY,
    LOOPS,
    at,
    joint,
    loop,
    pose,
    robot_around,
    robot_with,
    shut_by,
    some_values,
)
from tests.support.sdf import Sdf, axis_of, transform
from tests.support.touching import box
from tests.support.validators import ign_sdf

TOLERANCE = 1e-9


def sdf_export(robot, geometry=NO_MESHES, **keys):
    keys = {"export": {"sdf": {}, "urdf": {}}} | keys
    return exported(robot, geometry, **keys)


def sdf(robot, **keys):
    return sdf_export(robot, **keys).files["robot.sdf"]


def losses(robot, geometry=NO_MESHES, **keys):
    return losses_of(sdf_export(robot, geometry, export={"sdf": {}}, **keys), "robot.sdf")


def from_world(robot, q):
    """The values of the SDF's joints: a free link, which is one of its own, moves from where it stands."""
    free = {joint.dofs[0].name: joint.child for joint in robot.joints if joint.type == "free"}
    start, poses, out = starting_point(robot), link_poses(robot, q), {}
    stands = link_poses(robot, {name: start[name] for name in free})
    for name, value in q.items():
        if name in free:
            moved = np.linalg.inv(stands[free[name]]) @ poses[free[name]]
            value = (*map(float, moved[:3, 3]), *map(float, quat_from_rotation(moved[:3, :3])))
        out[free.get(name, name)] = value
    return out


@pytest.mark.parametrize("root", ["base", "world"])
@pytest.mark.parametrize("backwards", [False, True])
@pytest.mark.parametrize("kind", EVERY)
def test_links_are_where_kinematics_have_them_and_weigh_the_same(kind, backwards, root):
    rng = np.random.default_rng(EVERY.index(kind))
    robot = robot_around(kind, rng, root, backwards)
    files = sdf_export(robot).files
    read, by_urdf = Sdf(files["robot.sdf"]), Pinocchio(files["robot.urdf"])
    own = [dof.name for dof in robot.dofs if dof.kind != "free"]
    sdf_name = {link.name: "world_link" if link.name == "world" else link.name for link in robot.links}
    for _ in range(5):
        q = some_values(robot, rng)
        actual, expected = read.poses(from_world(robot, q)), link_poses(robot, q)
        for link in expected:
            assert np.abs(actual[sdf_name[link]] - expected[link]).max() < TOLERANCE, link
        if kind != "free":
            mass = read.mass_matrix(q, own)
            scale = max(1.0, np.abs(mass).max())
            assert np.abs(mass - mass_matrix(robot, q)).max() < TOLERANCE * scale
            assert np.abs(mass - by_urdf.mass_matrix(q, own)).max() < TOLERANCE * scale


@pytest.mark.slow
@pytest.mark.parametrize("kind", LOOPS)
def test_loop_of_any_type_is_a_joint_that_closes_it(kind):
    robot, mate, values = shut_by(kind)
    poses, (shut,) = link_poses(robot, saved_configuration(robot)), robot.loops
    read = Sdf(sdf(robot))
    (name,) = read.loops
    last = read.joints[name]
    assert last.findtext("child") == "two"
    # The SDF stands at the saved pose.
    actual = read.poses({})
    for link in poses:
        assert np.abs(actual[link] - poses[link]).max() < TOLERANCE
    # As its parent has it, through the links between, and as its child has it, the frame is the robot's.
    first, second = read.ends(name, {})
    assert np.abs(second - poses["two"] @ shut.a_from_frame).max() < TOLERANCE
    assert np.abs(first - second).max() < TOLERANCE
    # Moved along its own dofs, the tree's end stays on the chain of the joints that close the loop.
    moved, _ = read.ends(
        name, {other: 0.1 for other in read.joints if other.startswith("shut_") and other != name}
    )
    turn, axis = np.eye(4), axis_of(last)
    if last.get("type") in ("revolute", "continuous"):
        turn[:3, :3] = Rotation.from_rotvec(0.1 * axis).as_matrix()
    elif last.get("type") == "prismatic":
        turn[:3, 3] = 0.1 * axis
    if kind not in ("ball", "fixed"):
        there = link_poses(robot_with([mate]), {dof: value + 0.1 for dof, value in values.items()})["end"]
        assert np.abs(moved @ turn - shut.b_from_frame @ there).max() < TOLERANCE
    assert "one_joint_x (0.2)" in losses(robot)["I-SDF-ZERO"]


def test_limits_and_mimics_count_from_where_the_links_stand():
    first = {"limits": {"one_joint": Limits(-1, 2)}, "dynamics": Dynamics(0.1, 0.2, None, 3, 4)}
    rows = [
        joint("revolute", "base", "one", [0.5], **first),
        joint("revolute", "one", "two", [0.7], place=at(1, 0, 0)),
        joint("revolute", "base", "three", [1.5], place=at(0, 1, 0)),
    ]
    robot = robot_with(rows, relations=[Relation("Gear", "three_joint", "one_joint", 2.0, 0.5)])
    poses = link_poses(robot, {"one_joint": 0.5, "two_joint": 0.7})
    shut = loop("revolute", "two", "base", np.eye(4), poses["two"], [0.0])
    read = Sdf(sdf(replace(robot, loops=(shut,))))
    axis, mimic = read.joints["one_joint"].find("axis"), read.joints["three_joint"].find("axis/mimic")
    numbers = [float(axis.findtext(f"limit/{key}")) for key in ("lower", "upper", "effort", "velocity")]
    assert numbers == pytest.approx([-1.5, 1.5, 3, 4])
    assert [axis.findtext(f"dynamics/{key}") for key in ("damping", "friction")] == ["0.1", "0.2"]
    # three stays at its own zero, and is 2 · 0.5 + 0.5 where one stands.
    said = mimic.get("joint"), mimic.findtext("multiplier"), mimic.findtext("offset")
    assert said == ("one_joint", "2", "1.5")
    assert "three_joint" in losses(robot)["I-SDF-MIMIC"]


def test_names_are_unique_across_kinds():
    rows = [joint("revolute", "base", "arm", name="arm"), joint("fixed", "arm", "__tip__", name="a::b")]
    robot = robot_with(rows, frames=[Frame("arm", "base", frozen(at(1, 2, 3)), "Arm")])
    read = Sdf(sdf(robot))
    assert list(read.links) == ["base", "arm", "tip"]
    assert list(read.joints) == ["base_fixed", "arm_joint", "a_b"]
    assert np.abs(read.place("arm_frame") - at(1, 2, 3)).max() < TOLERANCE
    said = losses(robot)["I-SDF-NAME"]
    for text in ("joint 'arm' is 'arm_joint'", "frame 'arm' is 'arm_frame'", "link '__tip__' is 'tip'"):
        assert text in said


@pytest.mark.parametrize("fixed", [True, False])
def test_fixed_base_is_held_by_the_world(fixed):
    robot = robot_with([joint("revolute", "base", "arm")], fixed=fixed)
    read = Sdf(sdf(robot, scene={"pose": {"xyz": [1, 2, 3], "rpy": [0.1, 0.2, 0.3]}}))
    held = [node for node in read.joints.values() if node.findtext("parent") == "world"]
    assert [node.findtext("child") for node in held] == (["base"] if fixed else [])
    expected = transform("1 2 3 0.1 0.2 0.3")
    assert np.abs(transform(read.top.findtext("pose")) - expected).max() < TOLERANCE


def sensed():
    robot = robot_with(
        [
            joint("revolute", "base", "arm"),
            joint("ball", "arm", "hand", limits={"hand_joint": Limits(None, 1)}),
        ],
        shapes={
            "arm": (box(0.2, 0.1, 0.1),), "hand": (Primitive("capsule", (0.05, 0.2), frozen(at(0, 0, 0.1))),),
        },
        frames=[Frame("eye", "hand", frozen(at(0, 0, 0.2)), "Eye")],
    )  # fmt: skip
    sensors = {
        "imu": {"type": "imu", "frame": "arm", "noise": {"gyro": 0.01}},
        "wrist": {"type": "force_torque", "frame": "hand"},
        "skin": {"type": "touch", "frame": "arm"},
        "range": {"type": "rangefinder", "frame": "eye", "cutoff": 4},
        "look": {"type": "camera", "frame": "eye", "fovy": 60, "resolution": [320, 240]},
        "joints": "joint",
    }
    return robot, solid(robot), {"sensors": sensors, "actuators": {"*": {"type": "motor"}}}


def test_sensors_are_those_of_sdf_and_look_where_ours_do():
    robot, geometry, keys = sensed()
    root = parse(sdf_export(robot, geometry, **keys).files["robot.sdf"])
    sensors = {node.get("name"): node for node in root.iter("sensor")}
    types = {name: node.get("type") for name, node in sensors.items()}
    assert types == {
        "imu": "imu", "wrist": "force_torque", "skin": "contact", "range": "gpu_lidar", "look": "camera",
    }  # fmt: skip
    assert sensors["imu"].findtext("imu/angular_velocity/z/noise/stddev") == "0.01"
    assert sensors["wrist"].getparent().get("name") == "hand_joint"
    assert sensors["skin"].findtext("contact/collision") == "collision_1"
    assert sensors["range"].findtext("lidar/range/max") == "4"
    # Both look along the z axis of the frame; the image's top is where −y is.
    for name, up in (("range", None), ("look", [0, -1, 0])):
        turned = transform(sensors[name].findtext("pose"))
        assert np.allclose(turned[:3, 0], [0, 0, 1])
        assert up is None or np.allclose(turned[:3, 2], up)
    wide = 2 * math.atan(math.tan(math.radians(30)) * 320 / 240)
    assert float(sensors["look"].findtext("camera/horizontal_fov")) == pytest.approx(wide)
    said = losses(robot, geometry, **keys)
    assert "joints_arm_joint_pos" in said["I-SDF-SENSOR"]
    assert "arm_joint" in said["I-SDF-ACTUATOR"]
    assert said["W-BALL-CONE"].endswith(": hand_joint")


def test_sdformats_own_tool_accepts_the_files(tmp_path):
    rng = np.random.default_rng(0)
    rows = [joint(kind, "base", f"{kind}_link", place=pose(rng)) for kind in EVERY]
    rows.append(joint("revolute", "base", "last", name="base"))
    shut = loop("planar", "ball_link", "revolute_link", pose(rng), pose(rng))
    gear = Relation("Gear", "base", "revolute_link_joint", 2.0, 0.0)
    robot, geometry, keys = sensed()
    path = tmp_path / "robot.sdf"
    for outcome in (
        sdf_export(robot_with(rows, loops=[shut], relations=[gear])), sdf_export(robot, geometry, **keys),
    ):  # fmt: skip
        path.write_bytes(outcome.files["robot.sdf"])
        assert ign_sdf(path) == ""
