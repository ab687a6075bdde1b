"""Contacts of boxes and balls that slide towards each other: which are false or missed, in closed form."""

import math
from dataclasses import replace

import mujoco
import numpy as np
import pytest

from linkwright.stages.robot.model.amendments import Amendment, Amendments
from linkwright.stages.robot.model.geometry import ColliderFigures, Exclude, Geometry
from linkwright.stages.robot.model.robot import Limits
from linkwright.stages.robot.motion.pose_samples import sampled_poses
from linkwright.stages.robot.motion.start_pose import home
from linkwright.stages.validate.checks.contact import false_contact
from linkwright.stages.validate.contact_errors import MIN_FALSE_DEPTH, POSES_SALT, SLIDE_TRAVEL
from linkwright.stages.validate.model.seen_surfaces import MAX_MEASURED_POSES, SeenSurfaces, surface, winding
from tests.support.compiled import compiled_of
from tests.support.robots import joint, robot_with

ROOM = 0.2
"""How far the slider slides, from 0, towards what stands on the base [m]."""

ROBOT = robot_with(
    [
        joint("prismatic", "base", "slider", limits={"slider_joint": Limits(0.0, ROOM)}),
        joint("revolute", "base", "post", limits={"post_joint": Limits(0.0, 1e-6)}),
    ]
)

SEEN = 'contype="0" conaffinity="0" group="2"'


def geoms(shapes, kind):
    return "".join(f"<geom {shape} {kind}/>" for shape in shapes)


def text(seen, solid, more=""):
    """A slider along z, and a post; of each its shapes that are seen, and those that collide."""
    slider, post = (geoms(a, SEEN) + geoms(b, 'group="3"') for a, b in zip(seen, solid, strict=True))
    inertia = '<inertial mass="1" pos="0 0 0" diaginertia="1 1 1"/>'
    return f"""<mujoco><compiler angle="radian"/><worldbody><body name="base">
    <body name="slider"><joint name="slider_joint" type="slide" axis="0 0 1"/>{inertia}{slider}</body>
    <body name="post"><joint name="post_joint" axis="0 0 1"/>{inertia}{post}</body>
    </body></worldbody>{more}</mujoco>"""


def judged(mjcf, *excludes, maker="ladder"):
    figures = ColliderFigures("slider", (), maker, "hull", 1, 8, True, None, None)
    both = figures, replace(figures, link="post")
    geometry = Geometry((), {}, self_contact=True, excludes=excludes, colliders=both)
    (check,) = false_contact.check(compiled_of(mjcf, ROBOT, geometry))
    return check


def values():
    """Where the slider is at the poses of the check."""
    samples = sampled_poses(ROBOT, false_contact.MAX_POSES, SLIDE_TRAVEL, home(ROBOT), POSES_SALT)
    return samples["slider_joint"]


def row_of(check):
    """false [%], then apart [mm], missed [%], at home [mm]."""
    assert check.table is not None
    ((body, other, *figures, _),) = check.table.rows
    assert (body, other) == ("slider", "post")
    return tuple(map(float, figures))


def percent(where):
    return round(100.0 * float(where.mean()), 1)


def cube(half, height=0.0):
    return f'type="box" size="{half} {half} {half}" pos="0 0 {height}"'


def ball(radius, height=0.0):
    return f'type="sphere" size="{radius}" pos="0 0 {height}"'


def box_depth():
    """How deep [m] two boxes are in each other, by MuJoCo, that are so by 20 mm."""
    boxes = "".join(
        f'<body pos="0 0 {height}"><freejoint/><geom type="box" size=".05 .05 .05"/></body>'
        for height in (0, 0.08)
    )
    model = mujoco.MjModel.from_xml_string(f"<mujoco><worldbody>{boxes}</worldbody></mujoco>")
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return float(-data.contact.dist.min())


NEEDS_DEPTHS = pytest.mark.skipif(box_depth() < 0.019, reason="this MuJoCo (3.3) halves the depths of boxes")

AT = 0.25
"""How high the post stands above the slider at 0 [m]."""


def test_colliders_that_are_what_is_seen_are_right():
    for shape in (cube, ball):
        both = [[shape(0.04)], [shape(0.06, AT)]]
        check = judged(text(both, both))
        assert (check.passed, check.value, check.table) == (True, 0.0, None)


@pytest.mark.parametrize(("shape", "exact"), [pytest.param(cube, 1e-9, marks=NEEDS_DEPTHS), (ball, 2e-4)])
def test_large_colliders_are_false_where_visuals_are_apart(shape, exact):
    """By 10 mm each: where they are in each other, and what is seen is not yet within 2 mm."""
    check = judged(text([[shape(0.04)], [shape(0.06, AT)]], [[shape(0.05)], [shape(0.07, AT)]]))
    gap = AT - values() - 0.10
    wrong = (gap - 0.02 < -MIN_FALSE_DEPTH) & (gap > MIN_FALSE_DEPTH)
    share, apart, missed, at_home = row_of(check)
    assert wrong.sum() > 5
    assert share == percent(wrong)
    some = gap[wrong][np.linspace(0, wrong.sum() - 1, MAX_MEASURED_POSES).astype(int)]
    assert apart == pytest.approx(1e3 * some.max(), abs=0.01 + 1e3 * exact)
    assert (missed, at_home) == (0.0, 0.0)
    assert (check.passed, check.level) == (False, "warning")
    (finding,) = check.findings
    assert (finding.element, finding.attribute) == ('body "slider"', "geom")
    assert f"in {wrong.sum()} of {len(gap)} poses" in finding.message


@pytest.mark.parametrize("shape", [cube, ball])
def test_colliders_that_are_too_small_miss_what_cuts(shape):
    check = judged(text([[shape(0.04)], [shape(0.06, AT)]], [[shape(0.03)], [shape(0.05, AT)]]))
    gap = AT - values() - 0.10
    wrong = (gap < 0.0) & (gap + 0.02 > 1e-4)
    assert row_of(check) == (0.0, 0.0, percent(wrong), 0.0)
    assert "pass through each other" in check.findings[0].message


def test_link_without_a_collider_passes_through_the_others():
    seen = [[cube(0.04)], [cube(0.06, AT)]]
    check = judged(text(seen, [[cube(0.04)], []]))
    assert row_of(check) == (0.0, 0.0, percent(values() > AT - 0.10), 0.0)
    assert (check.passed, check.level) == (False, "error")
    assert judged(text(seen, [[cube(0.04)], []]), maker="none").passed


WALL, DEPTH, FINGER = 0.01, 0.08, 0.01
"""A U of this wall and this depth inside, open towards the finger, which is so thick [m]."""

OPENS = 0.12
"""How far above the finger's tip at 0 the U opens [m]."""


def u():
    half, middle = (DEPTH + WALL) / 2, OPENS + (DEPTH + WALL) / 2
    legs = [f'type="box" size="{WALL / 2} 0.02 {half}" pos="{x} 0 {middle}"' for x in (-0.035, 0.035)]
    return [*legs, f'type="box" size="0.04 0.02 {WALL / 2}" pos="0 0 {OPENS + DEPTH + WALL / 2}"']


def finger():
    return [f'type="box" size="{FINGER / 2} 0.01 0.1" pos="0 0 -0.1"']


def hull_of_u():
    half = (DEPTH + WALL) / 2
    return [f'type="box" size="0.04 0.02 {half}" pos="0 0 {OPENS + half}"']


def test_pieces_of_a_u_let_a_finger_in():
    assert judged(text([finger(), u()], [finger(), u()])).passed


@NEEDS_DEPTHS
def test_hull_of_a_u_holds_a_finger_out():
    """It is false as soon as the finger's tip is in the U, but where that is near the bottom; the finger is
    nearer to the bottom than to the legs only there."""
    check = judged(text([finger(), u()], [finger(), hull_of_u()]))
    tip = values() - OPENS
    wrong = (tip > MIN_FALSE_DEPTH) & (tip < DEPTH - MIN_FALSE_DEPTH)
    share, apart, missed, _ = row_of(check)
    assert (share, missed) == (percent(wrong), 0.0)
    assert apart == pytest.approx(1e3 * (0.03 - FINGER / 2), abs=0.01)
    assert (check.passed, check.level) == (False, "error")


@pytest.mark.parametrize("maker", ["hull", "raw", "given"])
def test_what_the_user_chose_is_a_warning(maker):
    check = judged(text([finger(), u()], [finger(), hull_of_u()]), maker=maker)
    assert (check.passed, check.level) == (False, "warning")


CROSSING = text([[cube(0.04)], [cube(0.06, AT)]], [[cube(0.04)], [cube(0.06, AT)]])
OUT = '<contact><exclude body1="slider" body2="post"/></contact>'


def excluded(mjcf, reason, **more):
    return judged(
        mjcf.replace("</mujoco>", f"{OUT}</mujoco>"), Exclude("slider", "post", reason, 0.0, **more)
    )


@pytest.mark.parametrize("reason", ["Source", "User"])
def test_pairs_excluded_by_choice_are_in_the_table_alone(reason):
    check = excluded(CROSSING, reason)
    assert check.passed
    assert check.table.rows[0][-1] == reason
    assert check.table.rows[0][4] == percent(values() > AT - 0.10)


def test_pairs_next_to_each_other_are_not_judged():
    assert excluded(CROSSING, "Adjacent").table is None
    child = CROSSING.replace('<body name="post">', '<body name="between"/><body name="post">')
    nested = CROSSING.replace('</body>\n    <body name="post">', '<body name="post">').replace(
        "</body>\n    </body>", "</body></body></body>"
    )
    assert judged(nested).table is None
    assert judged(child).table is None


def test_pairs_excluded_since_they_always_cut_must_do_so():
    assert excluded(CROSSING, "Always").table.rows[0][4] == percent(values() > AT - 0.10)
    assert not excluded(CROSSING, "Always").passed
    always = CROSSING.replace(cube(0.06, AT), cube(0.06, 0.1)).replace(cube(0.04), cube(0.11))
    assert excluded(always, "Always").table is None
    # Which of the shapes that are seen cut is not known where only some do not collide.
    assert excluded(CROSSING, "Always", geoms=((0, 0),)).table is None


@NEEDS_DEPTHS
def test_body_within_a_solid_touches_it_and_within_a_shell_not():
    """The slider ends in the middle of a large post, further than 2 mm from all of its surface."""
    large = [[cube(0.02)], [cube(0.1, 0.2)]]
    assert judged(text(large, large)).passed
    sides = [
        f'type="box" size="{x} {y} 0.1" pos="{px} {py} 0.2"'
        for x, y, px, py in (
            (0.002, 0.1, 0.098, 0),
            (0.002, 0.1, -0.098, 0),
            (0.1, 0.002, 0, 0.098),
            (0.1, 0.002, 0, -0.098),
        )
    ]
    tube = judged(text([large[0], sides], large))
    assert row_of(tube)[0] == percent(values() > 0.08 + MIN_FALSE_DEPTH)


@NEEDS_DEPTHS
def test_at_home_nothing_touches_that_stands_apart():
    start = float(home(ROBOT)["slider_joint"])
    for gap, deep, named in [(0.001, 5e-4, True), (0.001, -1e-4, False), (1e-4, 5e-4, False)]:
        top = start + 0.10 + gap
        seen = [[cube(0.04)], [cube(0.06, top)]]
        check = judged(text(seen, [[cube(0.04)], [cube(0.06 + gap + deep, top)]]))
        assert check.passed != named
        if named:
            assert row_of(check)[3] == pytest.approx(1e3 * deep, abs=0.01)
            assert "at home, where their visual shapes are apart" in check.findings[0].message


def test_check_needs_contact_of_the_robot_with_itself():
    for geometry in (None, Geometry((), {})):
        assert list(false_contact.check(compiled_of(CROSSING, ROBOT, geometry))) == []


def test_what_the_users_own_xml_says_of_contact_is_not_judged():
    compiled = compiled_of(CROSSING, ROBOT, Geometry((), {}, self_contact=True))
    change = Amendment("elements", "robot.xml", "contact", ("exclude",))
    changed = replace(compiled.written, amendments=Amendments((change,)))
    assert list(false_contact.check(replace(compiled, written=changed))) == []


KINDS = {
    "box": ("0.1 0.2 0.3", 0.2 * 0.4 * 0.6),
    "sphere": ("0.1", 4 / 3 * math.pi * 1e-3),
    "cylinder": ("0.1 0.2", math.pi * 0.01 * 0.4),
    "capsule": ("0.1 0.2", math.pi * 0.01 * 0.4 + 4 / 3 * math.pi * 1e-3),
    "ellipsoid": ("0.1 0.2 0.3", 4 / 3 * math.pi * 6e-3),
}


@pytest.mark.parametrize("kind", KINDS)
def test_primitive_is_a_closed_surface_around_its_volume(kind):
    size, volume = KINDS[kind]
    place = 'pos="1 2 3" quat="0.6 0 0.8 0"'
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><worldbody><body><geom type="{kind}" size="{size}" {place}/></body></worldbody></mujoco>'
    )
    points, faces = surface(model, 0)
    a, b, c = (points[faces] - points.mean(axis=0)).swapaxes(0, 1)
    held = float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum()) / 6.0
    assert held == pytest.approx(volume, rel=1e-9 if kind == "box" else 0.01)
    assert winding(points, faces, np.array([1.0, 2.0, 3.0])) == pytest.approx(1.0, abs=1e-9)
    assert winding(points, faces, np.array([1.0, 2.0, 3.5])) == pytest.approx(0.0, abs=1e-9)
    low, high = SeenSurfaces(model, {1: [0]}).box(1)
    assert (low + high) / 2 == pytest.approx([1, 2, 3], abs=1e-9)
