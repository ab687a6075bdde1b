"""Joints swept over their ranges: which links meet, where, and how deep, in closed form."""

import math
import re
from itertools import pairwise

import mujoco
import numpy as np
import pytest

from linkwright.stages.validate.checks.contact import reach
from linkwright.stages.validate.model.equality_solver import EqualitySolver, swept_joints
from tests.support.compiled import compiled_of
from tests.support.robots import joint, robot_with

LONG, RADIUS, END = 0.5, 0.05, 1.2

TWO = robot_with([joint("revolute", "base", "arm", [0.0]), joint("revolute", "base", "post", [0.0])])


def ball_and_post(angle, more="", ball="", post='range="0 .0001"'):
    """An arm that turns from -1.2 to 1.2, with a ball at its end; and a ball on the circle of that, at an
    angle."""
    x, y = LONG * math.cos(angle), LONG * math.sin(angle)
    inertia = '<inertial mass="1" pos="0 0 0" diaginertia="1 1 1"/>'
    return f"""<mujoco><compiler angle="radian"/><worldbody><body name="base">
    <body name="arm"><joint name="arm" range="-{END} {END}"/>{inertia}
    <geom size="{RADIUS}" pos="{LONG} 0 0" {ball}/></body>
    <body name="post"><joint name="post" {post}/>{inertia}<geom size="{RADIUS}" pos="{x} {y} 0"/></body>
    </body></worldbody>{more}</mujoco>"""


def meetings(text, robot=TWO):
    (check,) = reach.check(compiled_of(text, robot))
    assert check.level == "warning"
    assert check.passed == (check.table is None)
    assert len(check.findings) == len(check.table.rows if check.table else ())
    return [row for row in (check.table.rows if check.table else ()) if row[0] == "arm"], check


def test_pair_the_angle_and_the_depth():
    """Balls on one circle meet where their chord is as long as two radii, and are deepest where they are one:
    at the end of the range, which is one of the angles that are tried."""
    ((joint_name, body, other, first, deepest, depth),), check = meetings(ball_and_post(END))
    assert (joint_name, body, other) == ("arm", "arm", "post")
    begins = END - 2 * math.asin((2 * RADIUS - reach.MIN_DEPTH) / (2 * LONG))
    step = 2 * END / reach.STEPS
    assert begins <= first < begins + step
    assert deepest == pytest.approx(END)
    assert depth == pytest.approx(2e3 * RADIUS, abs=1e-3)
    assert check.findings[0].element == 'joint "arm"'
    assert check.findings[0].attribute == "range"


@pytest.mark.parametrize(
    "text",
    [
        ball_and_post(END + 2 * math.asin(RADIUS / LONG) + 0.01),
        ball_and_post(END, '<contact><exclude body1="arm" body2="post"/></contact>'),
        ball_and_post(0.01),
    ],
    ids=["they do not meet", "they do not collide", "they touch at home"],
)
def test_links_that_do_not_meet_pass(text):
    assert meetings(text)[0] == []


def test_joint_without_a_range_turns_once():
    text = ball_and_post(3.0).replace(f'range="-{END} {END}"', "")
    rows, _ = meetings(text)
    there, back = sorted(row[3] for row in rows)
    assert there < -(math.pi - (3.0 + 2 * math.asin(RADIUS / LONG) - math.pi)) + 2 * math.pi / reach.STEPS
    assert back > 3.0 - 2 * math.asin(RADIUS / LONG)


def test_side_without_a_limit_is_one_turn():
    """As a file says that a joint is limited on one side: by a number that nothing reaches."""
    rows, _ = meetings(ball_and_post(END).replace(f'range="-{END} {END}"', 'range="-1e6 1.5"'))
    assert len(rows) == 2
    assert {-2 * math.pi < row[4] <= 1.5 for row in rows} == {True}


GEAR = '<equality><joint joint1="post" joint2="arm" polycoef="0 -1 0 0 0"/></equality>'


def test_what_follows_by_a_relation_moves_too():
    """Two fingers half a radian apart, each of which turns towards the other: they meet in the middle."""
    free = 'range="-3 3"'
    assert meetings(ball_and_post(1.3, post=free))[0] != []
    rows, check = meetings(ball_and_post(2.0, GEAR, post=free))
    assert {row[0] for row in check.table.rows} == {"arm"}
    ((_, _, _, first, deepest, depth),) = rows
    assert 1.0 - math.asin(RADIUS / LONG) <= first <= 1.0
    assert deepest == pytest.approx(1.0, abs=END / reach.STEPS)
    assert depth < 2e3 * RADIUS + 1e-3


FOUR_BAR = """<mujoco><compiler angle="radian"/><worldbody>
<body name="crank"><joint name="crank" range="-1 1"/><geom size=".01" pos="0 .3 0"/>
<body name="rod" pos="0 .3 0"><joint name="rod"/><geom size=".01" pos=".5 0 0"/>
<site name="a" pos=".5 0 0"/></body></body>
<body name="rocker" pos=".5 0 0"><joint name="rocker" range="-2 2"/><geom size=".01"/>
<site name="b" pos="0 .3 0"/></body>
</worldbody><equality><connect site1="a" site2="b"/></equality>
<actuator><position joint="crank"/></actuator></mujoco>"""


def test_parallelogram_is_closed_by_equal_angles():
    model = mujoco.MjModel.from_xml_string(FOUR_BAR)
    pose = model.qpos0.copy()
    solver = EqualitySolver(model)
    for value in np.linspace(0, 1, 10):
        pose = solver.solve(model.joint("crank").id, float(value), pose)
        assert pose == pytest.approx([value, -value, value], abs=1e-4)


def test_angle_that_no_loop_reaches():
    """A rod that is too short to let the crank turn all the way."""
    model = mujoco.MjModel.from_xml_string(
        FOUR_BAR.replace('pos="0 .3 0"/></body>\n</w', 'pos="0 .05 0"/></body>\n</w')
    )
    start = model.qpos0.copy()
    assert EqualitySolver(model).solve(model.joint("crank").id, math.pi / 2, start) is None


def test_of_a_loop_the_driven_joints_are_swept_else_all():
    def names(text):
        model = mujoco.MjModel.from_xml_string(text)
        return [model.joint(joint).name for joint in swept_joints(model, model.qpos0)]

    assert names(FOUR_BAR) == ["crank"]
    undriven = FOUR_BAR[: FOUR_BAR.index("<actuator>")] + "</mujoco>"
    assert names(undriven) == ["crank", "rod", "rocker"]
    tendon = '<tendon><fixed name="cable"><joint joint="rocker" coef="1"/></fixed></tendon>'
    by_tendon = f'{tendon}<actuator><position tendon="cable"/></actuator></mujoco>'
    assert names(undriven.replace("</mujoco>", by_tendon)) == ["crank", "rod", "rocker"]
    assert names(ball_and_post(1.0)) == ["arm", "post"]
    assert names(ball_and_post(1.0, GEAR)) == ["arm"]


def test_robot_that_collides_with_nothing_is_not_looked_at():
    text = ball_and_post(END).replace("<geom", '<geom contype="0" conaffinity="0"')
    assert list(reach.check(compiled_of(text, TWO))) == []


def test_values_increase_from_home_outwards():
    rows, _ = meetings(ball_and_post(0.5))
    ((_, _, _, first, deepest, _),) = rows
    assert all(angle <= other for angle, other in pairwise([0.0, first, deepest]))


def test_value_outside_a_narrow_range_takes_no_more_steps():
    """The file's range is not the robot's; else the steps would be as many as the range is narrow."""
    ranged = 'range="0.1 0.1001" limited="true"'
    apart = ball_and_post(END + 2 * math.asin(RADIUS / LONG) + 0.2, post=ranged)
    (check,) = reach.check(compiled_of(apart, TWO))
    (poses,) = map(int, re.findall(r"(\d+) poses", check.detail))
    assert poses <= 4 * reach.STEPS
