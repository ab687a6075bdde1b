"""The checks of colliders find those that are gone, elsewhere, of another size or turned: by how much, in
closed form."""

import math
from dataclasses import replace

import numpy as np
import pytest

from linkwright.stages.robot.model.geometry import ColliderFigures, Geometry, Measures
from linkwright.stages.robot.model.robot import Primitive
from linkwright.stages.validate.checks.contact import bare_links, colliders
from tests.support.written import ONE_HINGE, compiled_of

SEEN = 'group="2" contype="0" conaffinity="0"'
SIDES = (0.2, 0.1, 0.06)
SIZE = math.hypot(*SIDES)
LENGTHS = " ".join(str(side / 2) for side in SIDES)


def arm(collider: str = f'type="box" size="{LENGTHS}"', visual: str = f'type="box" size="{LENGTHS}"') -> str:
    """A box that is seen, and its collider; the base has both as well."""
    own = f'<geom name="arm_collision" {collider}/>' if collider else ""
    return f"""<mujoco><worldbody><body name="base"><geom type="sphere" size=".05" {SEEN}/>
    <geom name="base_collision" size=".05"/>
    <body name="arm" pos="0 0 1"><joint name="arm"/><inertial mass="1" pos="0 0 0" diaginertia="1 1 1"/>
    <geom {visual} {SEEN}/>{own}</body></body></worldbody></mujoco>"""


def moved(x: float) -> str:
    return arm(f'type="box" size="{LENGTHS}" pos="{x} 0 0"')


def results(text, geometry=None):
    """Whether there are errors and warnings, and the elements of both."""
    wrong, doubtful = colliders.check(compiled_of(text, geometry=geometry))
    assert (wrong.level, doubtful.level) == ("error", "warning")
    elements = [finding.element for check in (wrong, doubtful) for finding in check.findings]
    return (not wrong.passed, not doubtful.passed), elements


def judged(beyond=0.002, bare=0.001, rung="hull") -> Geometry:
    """A geometry whose colliders were judged to be off by so much."""
    measures = Measures(0.0, 0.0, "boolean", beyond, beyond, bare, bare)
    figures = ColliderFigures("arm", ("arm_part",), "ladder", rung, 1, 8, True, 0.001, measures)
    return Geometry((), {}, colliders=(figures, replace(figures, link="base")))


def test_a_collider_that_is_the_shape_itself_passes():
    assert results(arm()) == ((False, False), [])


@pytest.mark.parametrize("x", [0.03, 0.1, 0.2])
def test_how_far_a_moved_collider_is_off(x):
    """A box that moves along its x axis by less than its length leaves as much bare as it reaches beyond."""
    compiled = compiled_of(moved(x))
    own = [index for index in range(compiled.model.ngeom) if compiled.model.geom_bodyid[index] == 2]
    seen, solid = own[:1], own[1:]
    fit = colliders.fit(compiled.model, seen, solid)
    assert (fit.size, fit.solid) == pytest.approx((SIZE, SIZE))
    assert fit.beyond == pytest.approx(x, abs=1e-9)
    assert fit.bare == pytest.approx(x, abs=1e-9)


@pytest.mark.parametrize(
    ("x", "expected"),
    [
        (0.5 * colliders.MOVED_SHARE * SIZE, (False, False)),
        (1.1 * colliders.MOVED_SHARE * SIZE, (False, True)),
        (0.9 * colliders.MAX_SHARE * SIZE, (False, True)),
        (colliders.MAX_SHARE * SIZE + colliders.UNJUDGED_SHARE * SIZE + 0.01, (True, False)),
    ],
)
def test_a_moved_collider_of_which_nothing_is_known(x, expected):
    said, elements = results(moved(x))
    assert said == expected
    assert all("arm" in element for element in elements)


@pytest.mark.parametrize(("visual", "wrong"), [(True, False), (False, True)])
def test_what_collides_and_is_seen_is_beside_nothing(visual, wrong):
    """A geom that is both, and a ring that is only seen: the first is no collider of the second."""
    compiled = compiled_of(moved(3 * SIZE))
    link = next(candidate for candidate in compiled.robot.links if candidate.name == "arm")
    box = Primitive("box", SIDES, np.eye(4))
    shapes = (replace(box, collision=False), replace(box, visual=visual))
    links = tuple(
        replace(candidate, shapes=shapes) if candidate is link else candidate
        for candidate in compiled.robot.links
    )
    other = replace(compiled.written, robot=replace(compiled.robot, links=links))
    outcome, _ = colliders.check(replace(compiled, written=other))
    assert outcome.fails is wrong


@pytest.mark.parametrize(
    ("x", "expected"), [(0.002, (False, False)), (0.006, (False, True)), (0.02, (True, False))]
)
def test_a_moved_collider_that_was_judged(x, expected):
    """To be off by 2 mm and 1 mm, besides 1 % of the size, 2.3 mm."""
    assert 0.0023 < colliders.SPARE_SHARE * SIZE < 0.0024
    assert seen_robot_is_whole()
    said, _ = results(moved(x), judged())
    assert said == expected


def seen_robot_is_whole() -> bool:
    """Whether each link of the robot has one part that is seen and collides, as its figures say."""
    return all(len(link.parts) == 1 and link.parts[0].seen for link in ONE_HINGE.links)


def test_a_collider_in_millimetres_is_an_error_and_named():
    big = " ".join(str(1000 * side / 2) for side in SIDES)
    said, elements = results(arm(f'type="box" size="{big}"'))
    assert said[0]
    assert elements[0] == 'geom "arm_collision"'


@pytest.mark.parametrize("times", [1 / 1000, 1000])
def test_a_visual_shape_of_other_units_is_an_error(times):
    other = " ".join(str(times * side / 2) for side in SIDES)
    assert results(arm(visual=f'type="box" size="{other}"'))[0][0]


def test_a_collider_that_is_turned_is_found():
    """By a quarter turn about z: it reaches beyond, and leaves bare, half the difference of the sides."""
    turned = arm(f'type="box" size="{LENGTHS}" quat=".70710678 0 0 .70710678"')
    wrong, doubtful = colliders.check(compiled_of(turned))
    assert wrong.passed
    assert not doubtful.passed
    (finding,) = doubtful.findings
    assert "50 mm beyond" in finding.message
    assert "50 mm of them bare" in finding.message
    assert finding.message.endswith(": both, as if it had been moved, turned or mirrored")


def test_a_mirrored_collider_is_found():
    """An L of two boxes, and the same on the other side."""
    visual = f'type="box" size="{LENGTHS}"/><geom type="box" size=".02 .05 .03" pos=".08 .1 0"'
    collider = f'type="box" size="{LENGTHS}"/><geom type="box" size=".02 .05 .03" pos="-.08 .1 0"'
    text = arm(collider, f"{visual} {SEEN}".replace("/><geom", f" {SEEN}/><geom", 1).removesuffix(SEEN))
    said, _ = results(text)
    assert said == (False, True)


def test_a_robot_without_colliders_or_without_visual_shapes_has_nothing_to_compare():
    assert list(colliders.check(compiled_of(without_any()))) == []


def without_any() -> str:
    return arm("").replace('<geom name="base_collision" size=".05"/>', "")


def no_collider(text, geometry=None):
    (check,) = bare_links.check(compiled_of(text, geometry=geometry))
    assert check.level == "warning"
    return [finding.element for finding in check.findings]


def test_a_link_without_a_collider_is_named():
    assert no_collider(arm()) == []
    assert no_collider(arm("")) == ['body "arm"']


def test_a_link_without_a_collider_that_was_asked_for_is_none():
    figures = ColliderFigures("arm", ("arm_part",), "none", "none", 0, 0, True, None, None)
    assert no_collider(arm(""), Geometry((), {}, colliders=(figures,))) == []
    tried = replace(figures, maker="ladder")
    assert no_collider(arm(""), Geometry((), {}, colliders=(tried,))) == ['body "arm"']


def test_a_robot_of_which_nothing_collides_is_no_finding():
    assert list(bare_links.check(compiled_of(without_any()))) == []
