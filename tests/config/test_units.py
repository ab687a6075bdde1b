# ruff: noqa: E501
"""Lengths and angles typed with their unit, wherever the configuration takes a length or an angle."""

import math

import pytest
import yaml

from linkwright.pipeline.config.plan import Plan
from linkwright.stages.robot.errors import AssemblyError, ConfigError
from tests.support.building import plan_of, robot_of
from tests.support.kit import Kit, frame
from tests.support.users import URL


def arm():
    """A hinge, with a mate named Elbow."""
    kit = Kit()
    base, forearm = kit.place("Base", fixed=True), kit.place("Forearm")
    kit.root.revolute("Elbow", (forearm, frame((0, 0, 0))), (base, frame((0, 0, 0.1))), limits=(-1, 1))
    return kit.document


def plan(**data):
    return Plan.parse({"source": {"kind": "sample"}, **data})


def problem(**data):
    with pytest.raises(ConfigError) as caught:
        plan(**data)
    (only,) = caught.value.problems
    return only


def test_a_text_with_a_unit_is_the_number_in_si():
    parsed = plan(**yaml.safe_load("""
scene: {pose: {xyz: [25 mm, 0.1, 1 in], rpy: [90 deg, 0, -1 rev]}}
mesh: {tolerance: 0.5mm, min_size: 2 cm, colliders: {"foot*": {sphere: {radius: 20 mm}}}}
frames: {add: {tool: {link: palm, xyz: [0, 0, 1e2 mm], rpy: [0, 180 deg, 0]}}}
links: {payload: {parent: palm, mass: 1, com: [1 mm, 0, 0], geometry: {box: {size: [1 ft, 1, 1]}}}}
ground: {size: [2 m, 300 cm]}
"""))  # fmt: skip
    payload = parsed.links["payload"]
    for value, expected in (
        (parsed.scene.pose.xyz, (0.025, 0.1, 0.0254)),
        (parsed.scene.pose.rpy, (math.pi / 2, 0, -math.tau)),
        (parsed.mesh.tolerance, 0.0005),
        (parsed.mesh.min_size, 0.02),
        (parsed.mesh.colliders["foot*"].sphere.radius, 0.02),
        (parsed.frames.add["tool"].xyz, (0, 0, 0.1)),
        (payload.com, (0.001, 0, 0)),
        (payload.geometry.box.size, (0.3048, 1, 1)),
        (parsed.ground.size, (2, 3)),
    ):
        assert value == pytest.approx(expected)


def test_angles_of_mujoco_and_onshape_take_units_too():
    eyes = {"eye": {"fovy": "1 rad"}, "nose": {"fovy": 60}, "ear": {"fovy": "60 deg"}}
    angles = [camera.fovy for camera in plan(scene={"cameras": eyes}).scene.cameras.values()]
    assert angles == pytest.approx([math.degrees(1), 60, 60])
    fineness = {"angle": "5 deg", "chord": "0.1 mm", "max_facet_width": "5 mm"}
    fine = plan(source={"kind": "onshape", "url": URL, "tessellation": fineness}).source.tessellation
    assert (fine.angle, fine.chord, fine.max_facet_width) == pytest.approx((math.radians(5), 1e-4, 5e-3))


LENGTH = "must be a number in m, or a length as '25 mm'"
UNITS = "units are nm, um, mm, cm, m, in, ft, ..."


@pytest.mark.parametrize(("value", "message"), [
    ("3", f"{LENGTH}: without quotes, or with a unit (given '3')"),
    ("3 parsec", f"{LENGTH}: 'parsec' is unknown; {UNITS} (given '3 parsec')"),
    ("3 deg", f"{LENGTH}: 'deg' is a unit of angle; {UNITS} (given '3 deg')"),
    ("mm", f"{LENGTH} (given 'mm')"),
    ("1e999 mm", f"{LENGTH}: it is too large (given '1e999 mm')"),
    ("-3 mm", "must be greater than 0 (given '-3 mm')"),
    (True, "must be a number (given true)"),
])  # fmt: skip
def test_a_value_that_is_no_length_is_named(value, message):
    only = problem(mesh={"tolerance": value})
    assert (only.code, only.where, only.message) == ("E-VALUE", "mesh.tolerance", message)


@pytest.mark.parametrize(("tree", "key", "hint"), [
    ("ground: {xyz: [0, 0, -.04]}", "ground.xyz[2]", "write -0.04: in YAML -.04 is text"),
    ("joints: {elbow: {damping: +.5e-1}}", "joints.elbow.damping", "write 0.5e-1: in YAML +.5e-1 is text"),
    ("joints: {elbow: {limits: [-.5, 1]}}", "joints.elbow.limits[0]", "write -0.5: in YAML -.5 is text"),
])  # fmt: skip
def test_a_number_that_yaml_takes_for_text_comes_with_its_form(tree, key, hint):
    from omegaconf._utils import get_yaml_loader  # that of the configuration's files

    only = problem(**yaml.load(tree, Loader=get_yaml_loader()))
    assert (only.code, only.where, only.hint) == ("E-VALUE", key, hint)


@pytest.mark.parametrize("limits", [["-1e999 deg", 1], [-1, "1e308 rev"]])
def test_limit_that_is_not_finite_is_an_error(limits):
    only = problem(joints={"elbow": {"limits": limits}})
    assert (only.code, only.where[:19]) == ("E-VALUE", "joints.elbow.limits")
    assert "it is too large" in only.message


def test_limits_of_a_hinge_and_its_keyframes_are_angles():
    elbow = {"limits": [-math.pi / 2, math.pi / 2], "zero": math.radians(10)}
    typed = {"limits": ["-90 deg", "0.25 rev"], "zero": "10 deg"}
    plain = robot_of(arm(), plan_of(joints={"elbow": elbow}))
    robot = robot_of(arm(), plan_of(joints={"elbow": typed}, keyframes={"bent": {"elbow": "45 deg"}}))
    (old,), (new,) = ([dof for dof in made.dofs if dof.name == "elbow"] for made in (plain, robot))
    assert new.limits.interval == pytest.approx(old.limits.interval, abs=1e-15)
    assert robot.keyframes[0].given == (("elbow", pytest.approx(math.pi / 4)),)


@pytest.mark.parametrize(("keys", "message"), [
    ({"joints": {"elbow": {"limits": [None, "25 mm"]}}}, "limits of 'elbow': '25 mm' is no angle, and elbow is a turn"),
    ({"joints": {"elbow": {"zero": "25 mm"}}}, "zero of 'elbow': '25 mm' is no angle"),
    ({"keyframes": {"bent": {"elbow": "25 mm"}}}, "'elbow': '25 mm' is no angle"),
])  # fmt: skip
def test_length_for_a_hinge_is_an_error_of_the_robot(keys, message):
    with pytest.raises(AssemblyError, match=message):
        robot_of(arm(), plan_of(**keys))


def test_an_angle_for_an_added_slide_is_an_error_at_once():
    joint = {"type": "prismatic", "limits": ["-1 deg", "1 deg"]}
    added = {"parent": "forearm", "joint": joint, "mass": 1, "geometry": {"sphere": {"radius": 1}}}
    message = problem(links={"slider": added}).message
    assert "'-1 deg' is no length, and the joint is prismatic" in message


def test_the_configuration_keeps_the_typed_text_for_a_joint():
    parsed = plan(joints={"elbow": {"limits": ["-90 deg", 1.5]}})
    assert parsed.tree()["joints"]["elbow"]["limits"] == ["-90 deg", 1.5]
    assert Plan.parse(parsed.tree()) == parsed


def test_an_offset_of_a_relation_has_the_unit_of_its_follower():
    kit = Kit()
    base, wheel, rack = kit.place("Base", fixed=True), kit.place("Wheel"), kit.place("Rack")
    turned = kit.root.revolute("Pinion", (wheel, frame((0, 0, 0))), (base, frame((0, 0, 0.1))))
    moved = kit.root.slider("Rail", (rack, frame((0, 0, 0))), (base, frame((0.1, 0, 0))))
    kit.root.rack("Gearing", turned, moved, 0.05)
    right = robot_of(kit.document, plan_of(relations={"Gearing": {"offset": "5 mm"}}))
    assert right.relations[0].offset == pytest.approx(0.005)
    with pytest.raises(AssemblyError, match="'5 deg' is no length, and rail is a slide"):
        robot_of(kit.document, plan_of(relations={"Gearing": {"offset": "5 deg"}}))
