"""What has other units than its shape is found, and named; what is only odd is a warning."""

import math
from dataclasses import replace

import pytest

from linkwright.stages.validate.checks.mechanism.inertial import check
from linkwright.stages.validate.checks.mechanism.mass_ratio import check as ratios
from tests.support.compiled import compiled_of, only
from tests.support.robots import joint, robot_with

SIDES = (0.1, 0.2, 0.3)
MASS = 6.0  # a kilogram per litre
MOMENTS = tuple(MASS / 12 * (sum(side**2 for side in SIDES) - side**2) for side in SIDES)


def box(mass: float = MASS, inertia: float = 1.0, com: tuple[float, ...] = (0.3, 0.4, 0.5)) -> list:
    """The results of a solid box at an odd place in its body, with changes to its inertial."""
    words = {
        "pos": com,
        "diaginertia": [inertia * moment for moment in MOMENTS],
        "size": [side / 2 for side in SIDES],
    }
    text = {name: " ".join(map(repr, values)) for name, values in words.items()}
    return list(
        check(
            compiled_of(
                f'<body name="base"><freejoint/><inertial mass="{mass!r}" pos="{text["pos"]}" '
                f'diaginertia="{text["diaginertia"]}"/>'
                f'<geom type="box" size="{text["size"]}" pos=".3 .4 .5"/></body>'
            )
        )
    )


def test_a_solid_box_has_its_radius_of_gyration_and_its_density():
    checks = box()
    assert [check.passed for check in checks] == [True] * 3
    # √((a² + b²) / 12) of the half diagonal ½ √(a² + b²), about each axis.
    assert only(checks, "inertia fits the shape").value == pytest.approx(1 / math.sqrt(3), rel=1e-9)
    assert only(checks, "density of matter").value == pytest.approx(1000.0, rel=1e-9)
    assert only(checks, "centre of mass in the shape").value == 0.0


@pytest.mark.parametrize(
    ("factor", "unit"),
    [(1e3, "g m² read as kg m²"), (1e6, "kg mm² read as kg m²"), (1e9, "g mm² read as kg m²")],
)
def test_an_inertia_in_other_units_is_an_error_that_names_them(factor, unit):
    (wrong,) = [check for check in box(inertia=factor) if not check.passed]
    assert wrong.fails
    assert wrong.value == pytest.approx(math.sqrt(factor / 3), rel=1e-9)
    (finding,) = wrong.findings
    assert (finding.element, finding.attribute) == ('body "base"', "inertial diaginertia")
    assert unit in finding.message


def test_a_mass_in_grams_is_an_error_that_names_them():
    checks = box(mass=1e3 * MASS)
    wrong = only(checks, "density of matter")
    assert wrong.fails
    assert wrong.value == pytest.approx(1e6, rel=1e-9)
    assert wrong.findings[0].attribute == "inertial mass"
    assert "g read as kg" in wrong.findings[0].message
    # The inertia was not scaled with it: a warning, since a heavy spot in a light shape has it too.
    assert only(checks, "inertia fits the shape").warns


def test_a_centre_of_mass_in_millimetres_is_an_error_that_names_them():
    wrong = only(box(com=(300.0, 400.0, 500.0)), "centre of mass in the shape")
    assert wrong.fails
    assert wrong.findings[0].attribute == "inertial pos"
    assert "mm read as m" in wrong.findings[0].message


def test_a_shape_in_millimetres_is_an_error():
    text = '<body name="b"><freejoint/><inertial mass="1" pos="0 0 0" diaginertia=".01 .01 .01"/>{}</body>'
    wrong = only(
        check(compiled_of(text.format('<geom type="box" size="100 100 100"/>'))), "density of matter"
    )
    assert wrong.fails
    assert "in mm" in wrong.findings[0].message


@pytest.mark.parametrize(
    ("change", "name"),
    [
        ({"inertia": 4.0}, "inertia fits the shape"),
        ({"inertia": 1e-3}, "inertia fits the shape"),
        ({"com": (0.3, 0.4, 0.8)}, "centre of mass in the shape"),
    ],
)
def test_what_a_hidden_part_may_do_is_a_warning(change, name):
    assert only(box(**change), name).warns


def test_a_mesh_is_measured_by_its_vertices():
    """A tetrahedron with its corners at the origin and on the axes, and its mass at its centroid: the corner
    farthest from the axis along z through the centroid (¼, ¼, ¼) is (1, 0, 0)."""
    more = '<asset><mesh name="t" vertex="0 0 0 1 0 0 0 1 0 0 0 1"/></asset>'
    inside = '<geom type="mesh" mesh="t"/>'
    text = (
        '<body name="b"><freejoint/><inertial mass="1" pos="{0} {0} {0}" diaginertia=".1 .1 .1"/>{1}</body>'
    )
    checks = list(check(compiled_of(text.format(0.25, inside), more=more)))
    assert only(checks, "inertia fits the shape").value == pytest.approx(math.sqrt(0.1 / 0.625), rel=1e-6)
    assert only(checks, "centre of mass in the shape").value == 0.0
    far = only(check(compiled_of(text.format(0.6, inside), more=more)), "centre of mass in the shape")
    # From (0.6, 0.6, 0.6) to the face x + y + z = 1, as nearly as the directions that are looked at allow.
    exact = 0.8 / math.sqrt(3) / math.sqrt(3)
    assert far.warns
    assert 0.9 * exact < far.value <= exact


def test_what_has_no_shape_or_no_end_is_not_judged():
    text = '<body name="b"><freejoint/><inertial mass="1" pos="9 9 9" diaginertia="9 9 9"/></body>'
    assert list(check(compiled_of(text))) == []
    plane = '<geom type="plane" size="1 1 1" contype="0" conaffinity="0"/>'
    assert list(check(compiled_of(plane + text))) == []


ARM = (
    '<body name="base"><freejoint/><inertial mass="{}" pos="0 0 0" diaginertia="1 1 1"/><body name="arm">'
    '<joint type="hinge"/><inertial mass="{}" pos="0 0 0" diaginertia="1e-3 1e-3 1e-3"/></body></body>'
)


def test_neighbours_may_differ_by_less_than_a_thousand():
    assert only(ratios(compiled_of(ARM.format(1.0, 0.0011))), "mass ratio").passed
    wrong = only(ratios(compiled_of(ARM.format(2.0, 0.001))), "mass ratio")
    assert wrong.warns
    assert wrong.value == pytest.approx(2000.0)
    assert wrong.findings[0].element == 'body "arm"'


def test_next_to_no_mass_must_be_what_cad_says():
    light = compiled_of(ARM.format(0.01, 5e-5))
    assert only(ratios(light), "light bodies").warns
    robot = robot_with([joint("revolute", "base", "arm")], root="base")
    own = next(link.inertial.mass for link in robot.links if link.name == "arm")
    links = tuple(replace(link, inertial=replace(link.inertial, mass=5e-5)) for link in robot.links)
    said = compiled_of(ARM.format(0.01, 5e-5), replace(robot, links=links))
    assert own > 1e-4
    assert only(ratios(said), "light bodies").passed
