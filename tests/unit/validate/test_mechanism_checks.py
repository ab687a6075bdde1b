"""Inertials in other units than their shapes, and hinges whose axes miss their links, by closed forms."""

import math
from dataclasses import replace

import numpy as np
import pytest

from linkwright.stages.robot.model.amendments import Amendment, Amendments
from linkwright.stages.validate.checks.mechanism import hinge_axes, placement
from linkwright.stages.validate.checks.mechanism.inertial import check
from linkwright.stages.validate.checks.mechanism.mass_ratio import check as ratios
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.engines import mujoco_engine
from linkwright.stages.validate.model.coordinates import distance
from tests.support.building import write
from tests.support.compiled import compiled_of, only, world_of
from tests.support.robots import joint, robot_with

SIDES = (0.1, 0.2, 0.3)
MASS = 6.0  # a kilogram per litre
MOMENTS = tuple(MASS / 12 * (sum(side**2 for side in SIDES) - side**2) for side in SIDES)


def body(mass, pos, inertia, inside=""):
    """A free body with an inertial, and what is in it."""
    inertial = f'<inertial mass="{mass!r}" pos="{pos}" diaginertia="{inertia}"/>'
    return f'<body name="base"><freejoint/>{inertial}{inside}</body>'


def box(mass=MASS, inertia=1.0, com=(0.3, 0.4, 0.5)):
    """The results of a solid box at an odd place in its body, with changes to its inertial."""
    place, moments, size = (
        " ".join(map(repr, values))
        for values in (com, [inertia * moment for moment in MOMENTS], [side / 2 for side in SIDES])
    )
    geom = f'<geom type="box" size="{size}" pos=".3 .4 .5"/>'
    return list(check(world_of(body(mass, place, moments, geom))))


def test_nan_of_a_rotation_is_no_small_distance():
    turned = np.eye(4)
    turned[0, 0] = np.nan
    assert distance(turned, np.eye(4)) == math.inf


@pytest.mark.parametrize(("attribute", "value"), [("quat", 0.25), ("pos", math.pi / 2)])
def test_placement_is_measured_without_what_the_user_sets(tmp_path, attribute, value):
    """The root is 0.25 m aside and a quarter turn about z: the user set one, the other is wrong."""
    written = write(robot_with([joint("revolute", "base", "arm")]), tmp_path).written
    change = Amendment("elements", "robot.xml", "body base", sets=(attribute,))
    path = tmp_path / "robot.xml"
    model = mujoco_engine.load(path).model
    body = model.body("base").id
    model.body_pos[body] += (0.25, 0.0, 0.0)
    model.body_quat[body] = (math.cos(math.pi / 4), 0.0, 0.0, math.sin(math.pi / 4))
    compiled = CompiledModel(path, model, replace(written, amendments=Amendments((change,))))
    (result,) = placement.check(compiled)
    assert [finding.attribute for finding in result.findings] == [{"quat": "pos", "pos": "quat"}[attribute]]
    assert result.value == pytest.approx(value, rel=1e-9)


FIT, DENSITY, CENTRE = "inertia fits the shape", "density of matter", "centre of mass in the shape"


def test_solid_box_has_its_radius_of_gyration_and_its_density():
    checks = box()
    assert [check.passed for check in checks] == [True] * 3
    # √((a² + b²) / 12) of the half diagonal ½ √(a² + b²), about each axis.
    assert only(checks, FIT).value == pytest.approx(1 / math.sqrt(3), rel=1e-9)
    assert only(checks, DENSITY).value == pytest.approx(1000.0, rel=1e-9)
    assert only(checks, CENTRE).value == 0.0


@pytest.mark.parametrize(
    ("change", "name", "attribute", "value", "unit"),
    [
        ({"inertia": 1e3}, FIT, "inertial diaginertia", math.sqrt(1e3 / 3), "g m² read as kg m²"),
        ({"inertia": 1e6}, FIT, "inertial diaginertia", math.sqrt(1e6 / 3), "kg mm² read as kg m²"),
        ({"inertia": 1e9}, FIT, "inertial diaginertia", math.sqrt(1e9 / 3), "g mm² read as kg m²"),
        ({"mass": 1e3 * MASS}, DENSITY, "inertial mass", 1e6, "g read as kg"),
        ({"com": (300.0, 400.0, 500.0)}, CENTRE, "inertial pos", None, "mm read as m"),
    ],
)
def test_other_units_are_an_error_that_names_them(change, name, attribute, value, unit):
    checks = box(**change)
    wrong = only(checks, name)
    assert wrong.fails
    assert value is None or wrong.value == pytest.approx(value, rel=1e-9)
    (finding,) = wrong.findings
    assert (finding.element, finding.attribute) == ('body "base"', attribute)
    assert unit in finding.message
    if "inertia" in change:
        assert [check for check in checks if not check.passed] == [wrong]
    if "mass" in change:
        # The inertia was not scaled with it: a warning, since a heavy spot in a light shape has it too.
        assert only(checks, FIT).warns


def test_shape_in_millimetres_is_an_error():
    large = body(1, "0 0 0", ".01 .01 .01", '<geom type="box" size="100 100 100"/>')
    wrong = only(check(world_of(large)), DENSITY)
    assert wrong.fails
    assert "in mm" in wrong.findings[0].message


@pytest.mark.parametrize(
    ("change", "name"),
    [
        ({"inertia": 4.0}, FIT),
        ({"inertia": 1e-3}, FIT),
        ({"com": (0.3, 0.4, 0.8)}, "centre of mass in the shape"),
    ],
)
def test_what_a_hidden_part_may_do_is_a_warning(change, name):
    assert only(box(**change), name).warns


def test_mesh_is_measured_by_its_vertices():
    """A tetrahedron with its corners at the origin and on the axes, and its mass at its centroid: the corner
    farthest from the axis along z through the centroid (¼, ¼, ¼) is (1, 0, 0)."""
    more = '<asset><mesh name="t" vertex="0 0 0 1 0 0 0 1 0 0 0 1"/></asset>'

    def checks(place):
        text = body(1, f"{place} {place} {place}", ".1 .1 .1", '<geom type="mesh" mesh="t"/>')
        return list(check(world_of(text, more=more)))

    assert only(checks(0.25), FIT).value == pytest.approx(math.sqrt(0.1 / 0.625), rel=1e-6)
    assert only(checks(0.25), CENTRE).value == 0.0
    far = only(checks(0.6), CENTRE)
    # From (0.6, 0.6, 0.6) to the face x + y + z = 1, as nearly as the directions that are looked at allow.
    exact = 0.8 / math.sqrt(3) / math.sqrt(3)
    assert far.warns
    assert 0.9 * exact < far.value <= exact


def test_what_has_no_shape_or_no_end_is_not_judged():
    text = body(1, "9 9 9", "9 9 9")
    assert list(check(world_of(text))) == []
    plane = '<geom type="plane" size="1 1 1" contype="0" conaffinity="0"/>'
    assert list(check(world_of(plane + text))) == []


ARM = (
    '<body name="base"><freejoint/><inertial mass="{}" pos="0 0 0" diaginertia="1 1 1"/><body name="arm">'
    '<joint type="hinge"/><inertial mass="{}" pos="0 0 0" diaginertia="1e-3 1e-3 1e-3"/></body></body>'
)


def test_neighbours_may_differ_by_less_than_a_thousand():
    assert only(ratios(world_of(ARM.format(1.0, 0.0011))), "mass ratio").passed
    wrong = only(ratios(world_of(ARM.format(2.0, 0.001))), "mass ratio")
    assert wrong.warns
    assert wrong.value == pytest.approx(2000.0)
    assert wrong.findings[0].element == 'body "arm"'


def test_next_to_no_mass_must_be_what_cad_says():
    light = world_of(ARM.format(0.01, 5e-5))
    assert only(ratios(light), "light bodies").warns
    robot = robot_with([joint("revolute", "base", "arm")], root="base")
    own = next(link.inertial.mass for link in robot.links if link.name == "arm")
    links = tuple(replace(link, inertial=replace(link.inertial, mass=5e-5)) for link in robot.links)
    said = world_of(ARM.format(0.01, 5e-5), replace(robot, links=links))
    assert own > 1e-4
    assert only(ratios(said), "light bodies").passed


RADIUS = 0.1


def text(axis, pos="0 0 0", base="0 0 0", kind="hinge"):
    """A ball on each link; the arm's is at (1, 0, 0) of its frame."""
    return f"""<mujoco><worldbody><body name="base"><geom size="{RADIUS}" pos="{base}"/>
    <body name="arm" pos="0 0 .5" quat=".8 0 .6 0"><joint name="arm" type="{kind}" axis="{axis}" pos="{pos}"/>
    <geom size="{RADIUS}" pos="1 0 0"/></body></body></worldbody></mujoco>"""


def outcome(*args, **more):
    return list(hinge_axes.check(compiled_of(text(*args, **more))))


EXTENT = 2 * RADIUS * 3**0.5


@pytest.mark.parametrize(("off", "passed"), [(0.0, True), (0.09, True), (0.5, False), (3.0, False)])
def test_how_far_an_axis_misses(off, passed):
    """Along y, which the turn of the arm leaves as it is, at a distance from its ball; the base is far."""
    (check,) = outcome("0 1 0", f"1 0 {off}", base="9 9 9")
    assert check.level == "warning"
    assert check.passed == passed
    assert check.value == pytest.approx(max(0.0, off - RADIUS) / EXTENT, abs=0.01)
    assert check.limit == 0.5
    assert [finding.element for finding in check.findings] == ([] if passed else ['joint "arm"'])


def test_axis_through_the_parent_is_near():
    """The arm's ball is far, the base's is where the axis is: 0.5 below the arm's origin, in the arm's frame
    at (0.48, 0, -0.14): the arm is turned by 2 atan(3/4) about y."""
    (check,) = outcome("0 1 0", "0.48 0 -0.14")
    assert check.passed
    assert check.value == 0.0


def test_of_a_slide_and_of_links_without_shapes_nothing_is_known():
    assert outcome("0 1 0", "9 9 9", kind="slide") == []
    bare = text("0 1 0", "9 9 9").replace(f'<geom size="{RADIUS}" pos="0 0 0"/>', "")
    assert list(hinge_axes.check(compiled_of(bare))) == []
