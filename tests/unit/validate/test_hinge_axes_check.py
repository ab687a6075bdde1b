"""The axis of a hinge is to pass near one of the links that it joins: how far it misses, in closed form."""

import pytest

from linkwright.stages.validate.checks.mechanism import hinge_axes
from tests.support.written import compiled_of

RADIUS = 0.1


def text(axis: str, pos: str = "0 0 0", base: str = "0 0 0", kind: str = "hinge") -> str:
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


def test_an_axis_through_the_parent_is_near():
    """The arm's ball is far, the base's is where the axis is: 0.5 below the arm's origin, in the arm's frame
    at (0.48, 0, -0.14): the arm is turned by 2 atan(3/4) about y."""
    (check,) = outcome("0 1 0", "0.48 0 -0.14")
    assert check.passed
    assert check.value == 0.0


def test_of_a_slide_and_of_links_without_shapes_nothing_is_known():
    assert outcome("0 1 0", "9 9 9", kind="slide") == []
    bare = text("0 1 0", "9 9 9").replace(f'<geom size="{RADIUS}" pos="0 0 0"/>', "")
    assert list(hinge_axes.check(compiled_of(bare))) == []
