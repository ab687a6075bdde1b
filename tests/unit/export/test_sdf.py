"""SDF of every kind of joint, loop and shape, as an independent reader and sdformat's own tool have it; what
robot.json says of it."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
import trimesh

from linkwright.stages.formats.written import Written
from linkwright.stages.formats.xml import parse
from linkwright.stages.robot.dynamics.mass_matrix import mass_matrix
from linkwright.stages.robot.errors import ConfigError
from linkwright.stages.robot.model.geom_form import ContactProperties
from linkwright.stages.robot.model.geometry import Geometry, Shape
from linkwright.stages.robot.model.poses import quat_from_rotation
from linkwright.stages.robot.model.robot import Dynamics, Frame, Limits, Primitive, Relation, frozen
from linkwright.stages.robot.motion.kinematics import link_poses
from linkwright.stages.robot.motion.start_pose import starting_point
from linkwright.stages.validate.read.sdf import check_file
from tests.support.building import NO_MESHES, plan_of, solid
from tests.support.engines import Pinocchio
from tests.support.exports import exported, losses_of, messages_of
from tests.support.robots import (
    EVERY,
    at,
    joint,
    loop,
    pose,
    robot_around,
    robot_with,
    some_values,
)
from tests.support.sdf import Sdf, transform
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


SKIN = Shape("arm", "visual", "skin.obj", (0.7, 0.7, 0.7, 1.0), 8, 12, 1.0, 1.0, texture="skin.png")


RED = Shape("arm", "visual", "arm.stl", (0.9, 0.1, 0.2, 1.0), 8, 12, 1.0, 1.0)


GLASS = Shape("arm", "visual", "pane.stl", (0.1, 0.2, 0.3, 0.25), 8, 12, 1.0, 1.0)


HULL = Shape("arm", "collision", "arm_1.stl", None, 8, 12, 1.0, 1.0)


BOX = trimesh.creation.box((1, 1, 1))


FILES = {mesh.file: BOX.export(file_type=mesh.file[-3:]) for mesh in (RED, GLASS, HULL)}
FILES |= {"skin.obj": BOX.export(file_type="obj").encode(), "skin.png": b""}


def arm():
    return robot_with([joint("revolute", "base", "arm")])


def link(outcome, name="arm"):
    (node,) = parse(outcome.files["robot.sdf"]).xpath(f"//link[@name='{name}']")
    return node


@pytest.mark.parametrize(("meshes", "before"), [("relative", "assets/"), ("model", "model://robot/assets/")])
def test_meshes_are_named_by_the_paths_that_were_chosen(meshes, before):
    geometry = Geometry((RED, SKIN, HULL), FILES)
    made = sdf_export(arm(), geometry, export={"sdf": {"meshes": meshes}})
    uris = [node.text for node in link(made, "arm").iter("uri")]
    assert uris == [f"{before}{name}" for name in ("arm.stl", "skin.obj", "arm_1.stl")]
    assert {f"assets/{uri.removeprefix(before)}" for uri in uris} <= set(made.files)


def test_mesh_has_its_colour_unless_it_has_an_image():
    node = link(sdf_export(arm(), Geometry((RED, GLASS, SKIN, HULL), FILES)), "arm")
    red, glass, skin = node.findall("visual")
    assert red.findtext("material/diffuse") == red.findtext("material/ambient") == "0.9 0.1 0.2 1"
    assert red.find("transparency") is None
    assert glass.findtext("material/diffuse") == "0.1 0.2 0.3 0.25"
    assert glass.findtext("transparency") == "0.75"
    assert skin.find("material") is None
    assert node.find("collision/material") is None


def test_shapes_have_the_sizes_and_places_of_the_robot():
    sizes = {"box": (0.1, 0.2, 0.3), "sphere": (0.1,), "cylinder": (0.1, 0.4), "capsule": (0.05, 0.2)}
    shapes = tuple(Primitive(kind, size, frozen(at(0.1, 0, 0.2))) for kind, size in sizes.items())
    robot = robot_with([joint("revolute", "base", "arm")], shapes={"arm": shapes})
    node = link(sdf_export(robot, solid(robot)))
    for tag in ("visual", "collision"):
        for shape, (kind, size) in zip(node.findall(tag), sizes.items(), strict=True):
            (made,) = shape.find("geometry")
            numbers = [float(text) for field in made for text in field.text.split()]
            assert (made.tag, numbers) == (kind, list(size))
            assert np.allclose(transform(shape.findtext("pose")), at(0.1, 0, 0.2))


def test_friction_is_that_of_sliding_and_the_rest_is_reported():
    contact = ContactProperties(friction=(0.8, 0.005, 0.0001), priority=2)
    slides = ContactProperties(friction=(1.5, 0.0, 0.0))
    shapes = replace(HULL, contact=contact), replace(HULL, contact=slides), HULL
    made = sdf_export(arm(), Geometry(shapes, FILES))
    rough, slick, plain = link(made, "arm").findall("collision")
    for node, mu in ((rough, "0.8"), (slick, "1.5")):
        assert [node.findtext(f"surface/friction/ode/{key}") for key in ("mu", "mu2")] == [mu, mu]
    assert plain.find("surface") is None
    (said,) = messages_of(made, "I-SDF-CONTACT")
    assert said.endswith("arm: friction (torsional, rolling), priority")


def test_lost_contact_properties_are_those_of_all_colliders_of_a_link():
    contacts = ContactProperties(priority=2, condim=4), ContactProperties(margin=0.001, condim=6)
    shapes = tuple(replace(HULL, contact=contact) for contact in contacts)
    (lost,) = messages_of(sdf_export(arm(), Geometry(shapes, FILES)), "I-SDF-CONTACT")
    assert lost.endswith("arm: condim, priority, margin")


@pytest.mark.parametrize(("self_contact", "collides"), [(True, "true"), (False, None)])
def test_links_collide_with_each_other_as_the_robots_do(self_contact, collides):
    robot = robot_with([joint("revolute", "base", "arm"), joint("revolute", "arm", "hand")])
    made = sdf_export(robot, replace(NO_MESHES, self_contact=self_contact))
    assert Sdf(made.files["robot.sdf"]).top.findtext("self_collide") == collides


def test_robot_json_has_the_names_and_zeros_of_the_sdf():
    turned = (math.cos(0.2), 0.0, 0.0, math.sin(0.2))
    rows = [
        joint("revolute", "base", "arm", [0.5], name="arm"),
        joint("ball", "arm", "hand", [turned], place=at(1, 0, 0)),
        joint("revolute", "base", "lid", [0.7]),
    ]
    robot = robot_with(rows, frames=[Frame("hand", "arm", frozen(np.eye(4)), "Hand")])
    poses = link_poses(robot, {"arm": 0.5, "hand_joint": turned})
    shut = loop("revolute", "hand", "base", np.eye(4), poses["hand"], [0.0], name="shut")
    made = sdf_export(replace(robot, loops=(shut,)))
    names = json.loads(made.files["robot.json"])["sdf"]
    assert names["renamed"] == {"links": {}, "joints": {"arm": "arm_joint"}, "frames": {"hand": "hand_frame"}}
    # lid is on no loop, and so at its own zero; shut is closed at its own.
    assert names["zeros"] == {"arm": 0.5, "hand_joint": pytest.approx(turned)}
    (zeros,) = messages_of(made, "I-SDF-ZERO")
    assert "arm (0.5)" in zeros
    assert "sdf" not in json.loads(exported(arm(), export={"urdf": {}}).files["robot.json"])


@pytest.mark.parametrize(("frame", "reported"), [("arm", False), ("turned", False), ("tip", True)])
@pytest.mark.parametrize("type_", ["force_torque", "torque", "force"])
def test_torque_that_is_not_measured_at_its_joint_is_reported(frame, reported, type_):
    frames = [
        Frame("turned", "arm", frozen(transform("0 0 0 1 2 3")), "Turned"),
        Frame("tip", "arm", frozen(at(0, 0, 0.1)), "Tip"),
    ]
    robot = robot_with([joint("revolute", "base", "arm")], frames=frames)
    made = sdf_export(robot, sensors={"load": {"type": type_, "frame": frame}})
    said = messages_of(made, "I-SDF-TORQUE")
    assert [text.endswith(": load") for text in said] == [True] * (reported and type_ != "force")


@pytest.mark.parametrize("keys", [
    {"elements": {"mine": {"into": {"tag": "link"}, "xml": "<a/>", "formats": ["urdf", "sdf"]}}},
    {"attributes": {"arm": {"name": "b", "formats": ["sdf"]}}},
])  # fmt: skip
def test_elements_and_attributes_for_the_sdf_are_refused_by_name(keys):
    with pytest.raises(ConfigError, match="sdf is written without XML of your own"):
        plan_of(**keys)


HOSTILE = (
    "upper arm", "größe", "手", "a::b", "__reserved__", "<&>\"'", "model", "a.b-c", " edge ", "::", "____",
)  # fmt: skip


def test_hostile_names_are_legal_and_listed_in_robot_json(tmp_path):
    rows = [joint("revolute", "base", name, name=name) for name in HOSTILE]
    robot = robot_with(rows, frames=[Frame(name, "base", frozen(np.eye(4)), name) for name in HOSTILE])
    made = sdf_export(robot)
    text = made.files["robot.sdf"]
    read, renamed = Sdf(text), json.loads(made.files["robot.json"])["sdf"]["renamed"]
    for kind, things in (("links", read.links), ("joints", read.joints), ("frames", read.frames)):
        names = [renamed[kind].get(name, name) for name in HOSTILE]
        assert len(set(names)) == len(HOSTILE)
        assert set(names) <= set(things)
    (tmp_path / "robot.sdf").write_bytes(text)
    assert all(check.passed for check in check_file(tmp_path / "robot.sdf", Written(robot), quick=False))
    assert ign_sdf(tmp_path / "robot.sdf") == ""
