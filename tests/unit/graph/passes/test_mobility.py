"""Mobility by rank: textbook mechanisms, and a numeric count as the second opinion."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from linkwright.stages.graph.passes.mobility import with_mobility
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.poses import from_parts, inverse, motion, turn
from linkwright.stages.robot.model.robot import Relation
from linkwright.stages.robot.motion.kinematics import chain, link_poses, saved_configuration
from tests.support.reported import codes
from tests.support.robots import CHAINS, LOOPS, Z, at, joint, loop, pose, robot_with, some_value


def drawn(joints, loops=(), relations=()):
    """A robot from frames in the world at its saved pose, where every value is 0: joints as
    (kind, parent, child, world_from_frame), loops as (kind, link_a, link_b, world_from_frame)."""
    world = {"base": np.eye(4)}
    made = []
    for kind, parent, child, frame in joints:
        world[child] = frame
        made.append(joint(kind, parent, child, place=inverse(world[parent]) @ frame, name=f"{child}_joint"))
    closing = [
        loop(kind, a, b, inverse(world[a]) @ frame, inverse(world[b]) @ frame, name=f"loop_{number}")
        for number, (kind, a, b, frame) in enumerate(loops)
    ]
    return robot_with(made, loops=closing, relations=relations)


def along(axis, point):
    """A frame at `point` with its z along `axis`."""
    z = np.array(axis, dtype=float) / np.linalg.norm(axis)
    x = np.cross(z, [0.3, -0.5, 0.8])
    x /= np.linalg.norm(x)
    return from_parts(np.column_stack([x, np.cross(z, x), z]), np.array(point, dtype=float))


def counts(robot):
    log = Diagnostics()
    mobility = with_mobility(robot, log).mobility
    return (mobility.coordinates, mobility.gruebler, mobility.dof, dict(mobility.redundant)), log


def counted(robot):
    """The counts of a robot of which nothing is reported."""
    mobility, log = counts(robot)
    assert codes(log) == []
    return mobility


def polygon(*points, size=1.0):
    """Bars between parallel pins at these points of a plane, the first and last on the base."""
    pins = [at(size * x, size * y, 0) for x, y in points]
    links = ["base", *(f"bar_{number}" for number in range(len(pins) - 1))]
    joints = [("revolute", links[n], links[n + 1], pin) for n, pin in enumerate(pins[:-1])]
    return drawn(joints, [("revolute", links[-1], "base", pins[-1])])


FOUR = ((0, 0), (0.1, 0.3), (0.5, 0.4), (0.6, 0))
FIVE = ((0, 0), (0.1, 0.3), (0.3, 0.5), (0.5, 0.4), (0.6, 0))
FLAT, UP = ((0, 0), (0.1, 0), (0.5, 0), (0.4, 0)), ((0, 0), (0.06, 0.08), (0.46, 0.08), (0.4, 0))


@pytest.mark.parametrize(
    ("points", "size", "mobility"),
    [
        *((FOUR, size, (3, -2, 1, {"loop_0": 3})) for size in (1e-3, 1.0, 1e3)),
        *((FIVE, size, (4, -1, 2, {"loop_0": 3})) for size in (1e-3, 1.0, 1e3)),
        (FLAT, 1.0, (3, -2, 2, {"loop_0": 4})),
        (UP, 1.0, (3, -2, 1, {"loop_0": 3})),
    ],
)
def test_planar_linkages_of_parallel_pins(points, size, mobility):
    """A parallelogram that lies flat counts the motion of its fork: there its rank is that of another
    linkage too (the antiparallelogram), one less than beside it."""
    assert counted(polygon(*points, size=size)) == mobility


def test_a_triangle_of_pins_is_rigid_and_says_so():
    mobility, log = counts(polygon((0, 0), (0.1, 0.3), (0.6, 0)))
    assert mobility == (2, -3, 0, {"loop_0": 3})
    assert [(note.code, note.where) for note in log.notes] == [("W-RIGID-LOOP", "loop_0")]
    assert log.notes[0].message.endswith("bar_0_joint, bar_1_joint")


def slider_crank(x, y, d, relations=()):
    """A crank with its pin at (x, y), a rod, and a piston at (d, 0)."""
    joints = [
        ("revolute", "base", "crank", at(0, 0, 0)),
        ("revolute", "crank", "rod", at(x, y, 0)),
        ("prismatic", "base", "piston", along((1, 0, 0), (d, 0, 0))),
    ]
    return drawn(joints, [("revolute", "rod", "piston", at(d, 0, 0))], relations)


def test_a_slider_crank():
    assert counted(slider_crank(0.1, 0.2, 0.7)) == (3, -2, 1, {"loop_0": 3})


def test_a_bennett_linkage_moves_though_its_axes_are_skew():
    """a / sin α = b / sin β; tan θ₁/2 tan θ₂/2 = sin ½(β + α) / sin ½(β − α) (Bennett 1903)."""
    a, alpha, beta = 0.3, 0.5, 1.1
    b = a * math.sin(beta) / math.sin(alpha)
    ratio = math.sin((beta + alpha) / 2) / math.sin((beta - alpha) / 2)
    first, second = 0.8, 2 * math.atan(ratio / math.tan(0.4))
    frames = [np.eye(4)]
    for angle, length, twist in (
        (first, a, alpha),
        (second, b, beta),
        (-first, a, alpha),
        (-second, b, beta),
    ):
        step = motion("turn", np.array(Z), angle) @ at(length, 0, 0)
        frames.append(frames[-1] @ step @ from_parts(turn(np.array([1.0, 0, 0]), twist), np.zeros(3)))
    assert np.abs(frames[4] - np.eye(4)).max() < 1e-12
    links, loops = ["base", "bar_0", "bar_1", "bar_2"], [("revolute", "bar_2", "base", frames[3])]
    joints = [("revolute", links[n], links[n + 1], frames[n]) for n in range(3)]
    assert counts(drawn(joints, loops))[0] == (3, -2, 1, {"loop_0": 1 + 2})
    skewed = [*joints[:2], ("revolute", "bar_1", "bar_2", frames[2] @ along((0, 0.3, 1), (0, 0, 0)))]
    assert counts(drawn(skewed, loops))[0][2] == 0


def test_an_rssr_has_its_input_and_the_spin_of_its_rod():
    joints = [
        ("revolute", "base", "crank", along((0, 0, 1), (0, 0, 0))),
        ("ball", "crank", "rod", at(0.1, 0.05, 0)),
        ("revolute", "base", "rocker", along((1, 0.2, 0), (0.5, 0.1, -0.1))),
    ]
    assert counted(drawn(joints, [("ball", "rod", "rocker", at(0.5, 0.3, 0.2))])) == (5, 2, 2, {})


def test_a_stewart_platform_has_six():
    joints, loops = [], []
    for leg in range(6):
        foot = np.array([math.cos(leg * math.pi / 3), math.sin(leg * math.pi / 3), 0.0])
        angle = (leg + (0.7 if leg % 2 else 0.3)) * math.pi / 3
        top = np.array([0.6 * math.cos(angle), 0.6 * math.sin(angle), 0.9])
        joints += [
            ("revolute", "base", f"cross_{leg}", along((1, 0, 0), foot)),
            ("revolute", f"cross_{leg}", f"lower_{leg}", along(np.cross(top - foot, [1, 0, 0]), foot)),
            ("prismatic", f"lower_{leg}", f"upper_{leg}", along(top - foot, foot)),
        ]
        if leg == 0:
            joints.append(("ball", "upper_0", "platform", at(*top)))
        else:
            loops.append(("ball", f"upper_{leg}", "platform", at(*top)))
    assert counts(drawn(joints, loops))[0] == (21, 6, 6, {})


def test_gears_take_one_each_and_lock_what_they_contradict():
    gear = Relation("gear", "bar_1_joint", "bar_0_joint", -2.0, 0.0)
    pins = [("revolute", "base", f"bar_{n}", at(n, 0, 0)) for n in range(3)]
    assert counted(drawn(pins, relations=[gear])) == (3, 2, 2, {})
    four = polygon(*FOUR)
    mobility, log = counts(robot_with(four.joints, loops=four.loops, relations=[gear]))
    assert (mobility, codes(log)) == ((3, -3, 0, {"loop_0": 3}), ["W-RIGID-LOOP"])


@pytest.mark.parametrize("sign", [1, -1])
def test_a_relation_that_the_loop_implies_takes_nothing(sign):
    """Crank and rocker of a parallelogram turn alike; both hang on the base, on two sides of the loop. A
    piston's rate is −y − x y / (d − x) of the crank's with its pin at (x, y), as the rod keeps its length."""
    pins, dof = [at(x, y, 0) for x, y in UP], sign == 1
    joints = [
        ("revolute", "base", "crank", pins[0]),
        ("revolute", "crank", "rod", pins[1]),
        ("revolute", "base", "rocker", pins[3]),
    ]
    alike = [Relation("alike", "rocker_joint", "crank_joint", sign, 0.0)]
    robot = drawn(joints, [("revolute", "rod", "rocker", pins[2])], alike)
    assert counts(robot)[0] == (3, -3, dof, {"loop_0": 3 + dof})
    x, y, d = 0.1, 0.2, 0.7
    rack = Relation("rack", "piston_joint", "crank_joint", sign * (-y - x * y / (d - x)), 0.0)
    assert counts(slider_crank(x, y, d, [rack]))[0] == (3, -3, dof, {"loop_0": 3 + dof})


def test_a_train_of_gears_has_one_whatever_its_length_and_ratio():
    joints = [("revolute", "base", f"wheel_{n}", at(0.1 * n, 0, 0)) for n in range(80)]
    gears = [Relation(f"g{n}", f"wheel_{n}_joint", "wheel_0_joint", (-1.5) ** n, 0.0) for n in range(1, 80)]
    assert counted(drawn(joints, relations=gears)) == (80, 1, 1, {})


def test_two_linkages_that_a_steep_gear_ties_move_as_one():
    """Where the one moves a millionth of the other it moves all the same: no loop is rigid."""
    pins = [at(x, y, 0) for x, y in ((0, 0), (0, 1), (2, 1.5), (2, 0))]
    joints, loops = [], []
    for side in "ab":
        links = ["base", *(f"{side}{number}" for number in range(3))]
        joints += [("revolute", links[n], links[n + 1], pin) for n, pin in enumerate(pins[:-1])]
        loops.append(("revolute", links[-1], "base", pins[-1]))
    gear = Relation("gear", "b0_joint", "a0_joint", 1e8, 0.0)
    assert counted(drawn(joints, loops, [gear])) == (6, -5, 1, {"loop_0": 3, "loop_1": 3})


@pytest.mark.parametrize(("tilt", "dof"), [(0.0, 2), (0.4, 1)])
def test_a_dof_moves_about_its_axis_as_the_dof_before_leaves_it(tilt, dof):
    """A slide along z and a turn about an axis tilted from it, in a guide along and about z."""
    tilted = from_parts(turn(np.array([1.0, 0, 0]), tilt), np.zeros(3))
    arm = joint("cylindrical", "base", "arm", origins=[tilted])
    guide = loop("cylindrical", "arm", "base", inverse(tilted), np.eye(4))
    assert counts(robot_with([arm], loops=[guide]))[0] == (2, -2, dof, {"loop": 2 + dof})


def test_redundancy_is_reported_the_later_loop_by_name():
    """Two equal mates close one ring: the second says nothing at all."""
    four = polygon(*FOUR)
    (loop,) = four.loops
    for loops in ([loop, replace(loop, name="again")], [replace(loop, name="again"), loop]):
        assert counted(robot_with(four.joints, loops=loops)) == (3, -7, 1, {"again": 3, "loop_0": 5})


def test_a_loop_between_links_that_do_not_move_is_redundant():
    robot = drawn([("fixed", "base", "arm", at(1, 0, 0))], [("revolute", "arm", "base", at(0, 0, 0))])
    assert counted(robot) == (0, -5, 0, {"loop_0": 5})


def extended_nullity(robot):
    """Motions by central differences: with the loops' own dofs as unknowns beside the tree's, each loop
    has six rows, the twist of frame a in frame b at the end of the loop's chain."""
    of_loops = [dof for loop in robot.loops for dof in loop.dofs]
    saved = {**saved_configuration(robot), **{dof.name: dof.saved for dof in of_loops}}

    def gaps(q):
        poses = link_poses(robot, q)
        return [
            inverse(poses[loop.link_b] @ loop.b_from_frame @ chain(loop.dofs, q))
            @ poses[loop.link_a]
            @ loop.a_from_frame
            for loop in robot.loops
        ]

    at_rest = gaps(saved)
    columns, h = [], 1e-5
    for dof in (*robot.dofs, *of_loops):
        for changed in nudged(dof, saved[dof.name], h):
            ahead, behind = (gaps({**saved, dof.name: value}) for value in changed)
            twists = []
            for gap, after, before in zip(at_rest, ahead, behind, strict=True):
                rate = inverse(gap) @ (after - before) / (2 * h)
                twists += [rate[2, 1], rate[0, 2], rate[1, 0], *rate[:3, 3]]
            columns.append(twists)
    sizes = np.linalg.svd(np.column_stack(columns), compute_uv=False)
    return len(columns) - int((sizes > 1e-7 * sizes[0]).sum())


def nudged(dof, value, h):
    """Pairs of values a little ahead and behind, one pair for each way that a turn, slide or ball moves."""
    if isinstance(value, float):
        return [(value + h, value - h)]
    turns = [[Rotation.from_rotvec(sign * h * axis) for sign in (1, -1)] for axis in np.eye(3)]
    start = Rotation.from_quat(np.roll(value, -1))
    return [[tuple(np.roll((start * step).as_quat(), 1).tolist()) for step in pair] for pair in turns]


@pytest.mark.parametrize("parallel", [False, True])
@pytest.mark.parametrize("kind", LOOPS)
def test_random_rings_of_every_type_against_numeric_differences(kind, parallel):
    """Links saved anywhere, chains either way round, frames skew or with all their axes parallel."""
    rng = np.random.default_rng(LOOPS.index(kind) + 20 * parallel)

    def place():
        return at(*rng.uniform(-0.3, 0.3, 3)) if parallel else pose(rng)

    kinds = ["cylindrical", "revolute", "planar" if parallel else "ball", "pin_slot"]
    joints, parent = [], "base"
    for number, joint_type in enumerate(kinds):
        values = [some_value(each, rng) for _, each, _ in CHAINS[joint_type]]
        way = {"backwards": number % 2 == 1, "origins": [place() for _ in values[1:]]}
        joints.append(joint(joint_type, parent, f"link_{number}", values, place=place(), **way))
        parent = "base" if number == 1 else f"link_{number}"
    values = [some_value(each, rng) for _, each, _ in CHAINS[kind]]
    closing = loop(kind, "link_1", parent, np.eye(4), place(), values)
    poses = link_poses(robot_with(joints), saved_configuration(robot_with(joints)))
    ends = chain(closing.dofs, {dof.name: dof.saved for dof in closing.dofs})
    frame = inverse(poses["link_1"]) @ poses[parent] @ closing.b_from_frame @ ends
    robot = robot_with(joints, loops=[replace(closing, a_from_frame=frame)])
    coordinates, gruebler, dof, redundant = counts(robot)[0]
    assert dof == extended_nullity(robot) == gruebler + sum(redundant.values())
    assert coordinates == sum({"ball": 3}.get(dof.kind, 1) for dof in robot.dofs)
