"""What an SDF has beside links and joints: meshes, colours, friction, self-collision; and what robot.json
says of it."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
import trimesh

from linkwright.stages.formats.written import Written
from linkwright.stages.formats.xml import parse
from linkwright.stages.robot.errors import ConfigError
from linkwright.stages.robot.model.geom_form import ContactProperties
from linkwright.stages.robot.model.geometry import Geometry, Shape
from linkwright.stages.robot.model.robot import Frame, Primitive, frozen
from linkwright.stages.robot.motion.kinematics import link_poses
from linkwright.stages.validate.read.sdf import check_file
from tests.support.building import NO_MESHES, plan_of, solid
from tests.support.exports import exported, messages_of
from tests.support.robots import at, joint, loop, robot_with
from tests.support.sdf import Sdf, transform
from tests.support.validators import ign_sdf

SKIN = Shape("arm", "visual", "skin.obj", (0.7, 0.7, 0.7, 1.0), 8, 12, 1.0, 1.0, texture="skin.png")
RED = Shape("arm", "visual", "arm.stl", (0.9, 0.1, 0.2, 1.0), 8, 12, 1.0, 1.0)
GLASS = Shape("arm", "visual", "pane.stl", (0.1, 0.2, 0.3, 0.25), 8, 12, 1.0, 1.0)
HULL = Shape("arm", "collision", "arm_1.stl", None, 8, 12, 1.0, 1.0)
BOX = trimesh.creation.box((1, 1, 1))
FILES = {mesh.file: BOX.export(file_type=mesh.file[-3:]) for mesh in (RED, GLASS, HULL)}
FILES |= {"skin.obj": BOX.export(file_type="obj").encode(), "skin.png": b""}


def sdf_export(robot, geometry=NO_MESHES, **keys):
    section = keys.pop("sdf", {})
    return exported(robot, geometry, export={"sdf": section}, **keys)


def arm():
    return robot_with([joint("revolute", "base", "arm")])


def link(outcome, name="arm"):
    (node,) = parse(outcome.files["robot.sdf"]).xpath(f"//link[@name='{name}']")
    return node


@pytest.mark.parametrize(("meshes", "before"), [("relative", "assets/"), ("model", "model://robot/assets/")])
def test_meshes_are_named_by_the_paths_that_were_chosen(meshes, before):
    geometry = Geometry((RED, SKIN, HULL), FILES)
    made = sdf_export(arm(), geometry, sdf={"meshes": meshes})
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
