"""Lengths and angles typed with their unit, wherever the configuration takes one."""

import math

import pytest
import yaml

from linkwright.pipeline.config.plan import Plan
from linkwright.stages.robot.errors import AssemblyError, ConfigError
from tests.support.building import plan_of, robot_of
from tests.support.kit import Kit, frame


def arm():
    """A hinge, with a mate named Elbow."""
    kit = Kit()
    base, forearm = kit.place("Base", fixed=True), kit.place("Forearm")
    kit.root.revolute("Elbow", (forearm, frame((0, 0, 0))), (base, frame((0, 0, 0.1))), limits=(-1, 1))
    return kit.document


def plan(**data):
    return Plan.parse({"source": {"kind": "sample"}, **data})


def told(**data):
    with pytest.raises(ConfigError) as caught:
        plan(**data)
    return [(one.code, one.where, one.message) for one in caught.value.problems]


def hinted(**data):
    with pytest.raises(ConfigError) as caught:
        plan(**data)
    return [(one.code, one.where, one.hint) for one in caught.value.problems]


def test_a_text_with_a_unit_is_the_number_in_si():
    found = plan(
        scene={"pose": {"xyz": ["25 mm", 0.1, "1 in"], "rpy": ["90 deg", 0, "-1 rev"]}},
        mesh={
            "tolerance": "0.5mm",
            "min_size": "2 cm",
            "colliders": {"foot*": {"sphere": {"radius": "20 mm"}}},
        },
        frames={"add": {"tool": {"link": "palm", "xyz": [0, 0, "1e2 mm"], "rpy": [0, "180 deg", 0]}}},
        links={
            "payload": {
                "parent": "palm",
                "mass": 1,
                "com": ["1 mm", 0, 0],
                "geometry": {"box": {"size": ["1 ft", 1, 1]}},
            }
        },
        ground={"size": ["2 m", "300 cm"]},
    )
    assert found.scene.pose.xyz == pytest.approx((0.025, 0.1, 0.0254))
    assert found.scene.pose.rpy == pytest.approx((math.pi / 2, 0, -math.tau))
    assert (found.mesh.tolerance, found.mesh.min_size) == pytest.approx((0.0005, 0.02))
    assert found.mesh.colliders["foot*"].sphere.radius == pytest.approx(0.02)
    assert found.frames.add["tool"].xyz == pytest.approx((0, 0, 0.1))
    assert found.links["payload"].com == pytest.approx((0.001, 0, 0))
    assert found.links["payload"].geometry.box.size == pytest.approx((0.3048, 1, 1))
    assert found.ground.size == pytest.approx((2, 3))


def test_what_mujoco_has_in_degrees_takes_radians_too():
    found = plan(
        scene={"cameras": {"eye": {"fovy": "1 rad"}, "nose": {"fovy": 60}, "ear": {"fovy": "60 deg"}}}
    )
    cameras = found.scene.cameras
    assert cameras["eye"].fovy == pytest.approx(math.degrees(1))
    assert cameras["nose"].fovy == cameras["ear"].fovy == 60


def test_onshape_takes_units_too():
    keys = {
        "kind": "onshape",
        "url": "https://cad.onshape.com/documents/" + "a" * 24 + "/w/" + "b" * 24 + "/e/" + "c" * 24,
    }
    keys["tessellation"] = {"angle": "5 deg", "chord": "0.1 mm", "max_facet_width": "5 mm"}
    fine = Plan.parse({"source": keys}).source.tessellation
    assert (fine.angle, fine.chord, fine.max_facet_width) == pytest.approx((math.radians(5), 1e-4, 5e-3))


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ("3", "must be a number in m, or a length as '25 mm': without quotes, or with a unit (given '3')"),
        (
            "3 parsec",
            "must be a number in m, or a length as '25 mm': 'parsec' is unknown; "
            "units are nm, um, mm, cm, m, in, ft, ... (given '3 parsec')",
        ),
        (
            "3 deg",
            "must be a number in m, or a length as '25 mm': 'deg' is a unit of angle; "
            "units are nm, um, mm, cm, m, in, ft, ... (given '3 deg')",
        ),
        ("mm", "must be a number in m, or a length as '25 mm' (given 'mm')"),
        ("-3 mm", "must be greater than 0 (given '-3 mm')"),
        (True, "must be a number (given true)"),
    ],
)
def test_what_is_no_length_is_named(value, message):
    assert told(mesh={"tolerance": value}) == [("E-VALUE", "mesh.tolerance", message)]


@pytest.mark.parametrize(
    ("tree", "key", "hint"),
    [
        ("ground: {xyz: [0, 0, -.04]}", "ground.xyz[2]", "write -0.04: in YAML -.04 is text"),
        (
            "joints: {elbow: {damping: +.5e-1}}",
            "joints.elbow.damping",
            "write 0.5e-1: in YAML +.5e-1 is text",
        ),
        ("joints: {elbow: {limits: [-.5, 1]}}", "joints.elbow.limits[0]", "write -0.5: in YAML -.5 is text"),
    ],
)
def test_a_number_that_yaml_takes_for_text_comes_with_its_form(tree, key, hint):
    from omegaconf._utils import get_yaml_loader  # that of the configuration's files

    ((code, where, found),) = hinted(**yaml.load(tree, Loader=get_yaml_loader()))
    assert (code, where, found) == ("E-VALUE", key, hint)


def test_limits_are_as_their_joint_has_them():
    """The kind of a joint is known when the robot is: a length for a hinge is an error then."""
    joints = {"elbow": {"limits": ["-90 deg", "0.25 rev"], "zero": "10 deg"}}
    plain = robot_of(
        arm(), plan_of(joints={"elbow": {"limits": [-math.pi / 2, math.pi / 2], "zero": math.radians(10)}})
    )
    typed = robot_of(arm(), plan_of(joints=joints, keyframes={"bent": {"elbow": "45 deg"}}))
    (old,) = (dof for dof in plain.dofs if dof.name == "elbow")
    (new,) = (dof for dof in typed.dofs if dof.name == "elbow")
    assert new.limits.interval == pytest.approx(old.limits.interval, abs=1e-15)
    assert typed.keyframes[0].given == (("elbow", pytest.approx(math.pi / 4)),)
    with pytest.raises(AssemblyError, match="limits of 'elbow': '25 mm' is no angle, and elbow is a turn"):
        robot_of(arm(), plan_of(joints={"elbow": {"limits": [None, "25 mm"]}}))
    with pytest.raises(AssemblyError, match="zero of 'elbow': '25 mm' is no angle"):
        robot_of(arm(), plan_of(joints={"elbow": {"zero": "25 mm"}}))
    with pytest.raises(AssemblyError, match="'elbow': '25 mm' is no angle"):
        robot_of(arm(), plan_of(keyframes={"bent": {"elbow": "25 mm"}}))
    joint = {"type": "prismatic", "limits": ["-1 deg", "1 deg"]}
    added = {"parent": "forearm", "joint": joint, "mass": 1, "geometry": {"sphere": {"radius": 1}}}
    ((_, _, message),) = told(links={"slider": added})
    assert "'-1 deg' is no length, and the joint is prismatic" in message


def test_the_configuration_keeps_what_was_typed_for_a_joint():
    joints = {"elbow": {"limits": ["-90 deg", 1.5]}}
    found = plan(joints=joints)
    assert found.tree()["joints"]["elbow"]["limits"] == ["-90 deg", 1.5]
    assert Plan.parse(found.tree()) == found


def test_an_offset_of_a_relation_is_of_its_follower():
    kit = Kit()
    base, wheel, rack = kit.place("Base", fixed=True), kit.place("Wheel"), kit.place("Rack")
    turned = kit.root.revolute("Pinion", (wheel, frame((0, 0, 0))), (base, frame((0, 0, 0.1))))
    moved = kit.root.slider("Rail", (rack, frame((0, 0, 0))), (base, frame((0.1, 0, 0))))
    kit.root.rack("Gearing", turned, moved, 0.05)
    right = robot_of(kit.document, plan_of(relations={"Gearing": {"offset": "5 mm"}}))
    assert right.relations[0].offset == pytest.approx(0.005)
    with pytest.raises(AssemblyError, match="'5 deg' is no length, and rail is a slide"):
        robot_of(kit.document, plan_of(relations={"Gearing": {"offset": "5 deg"}}))
