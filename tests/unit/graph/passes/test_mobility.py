"""Mobility by rank: textbook mechanisms, and a numeric count as the second opinion."""

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest

from linkwright.stages.graph.passes.mobility import with_mobility
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.poses import from_parts, inverse, motion, rotation_from_quat, turn
from linkwright.stages.robot.model.robot import Relation, Robot
from linkwright.stages.robot.motion.kinematics import chain, link_poses, saved_configuration
from tests.support.robots import CHAINS, LOOPS, Z, at, joint, loop, pose, robot_with, some_value


def drawn(joints, loops=(), relations=()) -> Robot:
    """A robot from frames in the world at its saved pose, where every value is 0: joints as
    (kind, parent, child, world_from_frame), loops as (kind, link_a, link_b, world_from_frame)."""
    world: dict[str, np.ndarray] = {"base": np.eye(4)}
    made = []
    for kind, parent, child, frame in joints:
        world[child] = frame
        made.append(joint(kind, parent, child, place=inverse(world[parent]) @ frame, name=f"{child}_joint"))
    closing = [
        loop(kind, a, b, inverse(world[a]) @ frame, inverse(world[b]) @ frame, name=f"loop_{number}")
        for number, (kind, a, b, frame) in enumerate(loops)
    ]
    return robot_with(made, loops=closing, relations=relations)


def along(axis, point) -> np.ndarray:
    """A frame at `point` with its z along `axis`."""
    z = np.array(axis, dtype=float) / np.linalg.norm(axis)
    x = np.cross(z, [0.3, -0.5, 0.8])
    x /= np.linalg.norm(x)
    return from_parts(np.column_stack([x, np.cross(z, x), z]), np.array(point, dtype=float))


def counts(robot: Robot) -> tuple[tuple, Diagnostics]:
    log = Diagnostics()
    found = with_mobility(robot, log).mobility
    return (found.coordinates, found.gruebler, found.dof, dict(found.redundant)), log


def told(log: Diagnostics) -> list[str]:
    return [one.code for one in log.found]


def polygon(*points, size: float = 1.0) -> Robot:
    """Bars between parallel pins at these points of a plane, the first and last on the base."""
    pins = [at(size * x, size * y, 0) for x, y in points]
    links = ["base", *(f"bar_{number}" for number in range(len(pins) - 1))]
    joints = [("revolute", links[n], links[n + 1], pin) for n, pin in enumerate(pins[:-1])]
    return drawn(joints, [("revolute", links[-1], "base", pins[-1])])


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_planar_linkages_of_parallel_pins(size: float) -> None:
    four = polygon((0, 0), (0.1, 0.3), (0.5, 0.4), (0.6, 0), size=size)
    assert counts(four)[0] == (3, -2, 1, {"loop_0": 3})
    five = polygon((0, 0), (0.1, 0.3), (0.3, 0.5), (0.5, 0.4), (0.6, 0), size=size)
    assert counts(five)[0] == (4, -1, 2, {"loop_0": 3})


def test_a_triangle_of_pins_is_rigid_and_says_so() -> None:
    found, log = counts(polygon((0, 0), (0.1, 0.3), (0.6, 0)))
    assert found == (2, -3, 0, {"loop_0": 3})
    assert told(log) == ["W-RIGID-LOOP"]
    assert log.found[0].where == "loop_0"
    assert log.found[0].message.endswith("bar_0_joint, bar_1_joint")


def test_a_parallelogram_that_lies_flat_counts_the_motion_of_its_fork() -> None:
    """There its rank is that of another linkage too (the antiparallelogram): one less than beside it."""
    assert counts(polygon((0, 0), (0.1, 0), (0.5, 0), (0.4, 0)))[0] == (3, -2, 2, {"loop_0": 4})
    up = polygon((0, 0), (0.06, 0.08), (0.46, 0.08), (0.4, 0))
    assert counts(up)[0] == (3, -2, 1, {"loop_0": 3})


def test_a_slider_crank() -> None:
    robot = drawn(
        [
            ("revolute", "base", "crank", at(0, 0, 0)),
            ("revolute", "crank", "rod", at(0.1, 0.2, 0)),
            ("prismatic", "base", "piston", along((1, 0, 0), (0.7, 0, 0))),
        ],
        [("revolute", "rod", "piston", at(0.7, 0, 0))],
    )
    assert counts(robot)[0] == (3, -2, 1, {"loop_0": 3})


def test_a_bennett_linkage_moves_though_its_axes_are_skew() -> None:
    """a / sin α = b / sin β; tan θ₁/2 tan θ₂/2 = sin ½(β + α) / sin ½(β − α) (Bennett 1903)."""
    a, alpha, beta = 0.3, 0.5, 1.1
    b = a * math.sin(beta) / math.sin(alpha)
    one = 0.8
    ratio = math.sin((beta + alpha) / 2) / math.sin((beta - alpha) / 2)
    two = 2 * math.atan(ratio / math.tan(one / 2))
    frames = [np.eye(4)]
    for angle, length, twist in ((one, a, alpha), (two, b, beta), (-one, a, alpha), (-two, b, beta)):
        step = motion("turn", np.array(Z), angle) @ at(length, 0, 0)
        frames.append(frames[-1] @ step @ from_parts(turn(np.array([1.0, 0, 0]), twist), np.zeros(3)))
    assert np.abs(frames[4] - np.eye(4)).max() < 1e-12
    links = ["base", "bar_0", "bar_1", "bar_2"]
    joints = [("revolute", links[n], links[n + 1], frames[n]) for n in range(3)]
    robot = drawn(joints, [("revolute", "bar_2", "base", frames[3])])
    assert counts(robot)[0] == (3, -2, 1, {"loop_0": 1 + 2})
    skewed = [*joints[:2], ("revolute", "bar_1", "bar_2", frames[2] @ along((0, 0.3, 1), (0, 0, 0)))]
    assert counts(drawn(skewed, [("revolute", "bar_2", "base", frames[3])]))[0][2] == 0


def test_an_rssr_has_its_input_and_the_spin_of_its_rod() -> None:
    robot = drawn(
        [
            ("revolute", "base", "crank", along((0, 0, 1), (0, 0, 0))),
            ("ball", "crank", "rod", at(0.1, 0.05, 0)),
            ("revolute", "base", "rocker", along((1, 0.2, 0), (0.5, 0.1, -0.1))),
        ],
        [("ball", "rod", "rocker", at(0.5, 0.3, 0.2))],
    )
    found, log = counts(robot)
    assert found == (5, 2, 2, {})
    assert not told(log)


def test_a_stewart_platform_has_six() -> None:
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


def test_gears_take_one_each_and_lock_what_they_contradict() -> None:
    gear = Relation("gear", "bar_1_joint", "bar_0_joint", -2.0, 0.0)
    pins = [("revolute", "base", f"bar_{n}", at(n, 0, 0)) for n in range(3)]
    assert counts(drawn(pins, relations=[gear]))[0] == (3, 2, 2, {})
    robot = polygon((0, 0), (0.1, 0.3), (0.5, 0.4), (0.6, 0))
    found, log = counts(drawn_with(robot, [gear]))
    assert found == (3, -3, 0, {"loop_0": 3})
    assert told(log) == ["W-RIGID-LOOP"]


@pytest.mark.parametrize(("sign", "dof"), [(1, 1), (-1, 0)])
def test_a_relation_that_the_loop_implies_takes_nothing(sign: int, dof: int) -> None:
    """Crank and rocker of a parallelogram turn alike; both hang on the base, on two sides of the loop."""
    pins = [at(0, 0, 0), at(0.06, 0.08, 0), at(0.46, 0.08, 0), at(0.4, 0, 0)]
    robot = drawn(
        [
            ("revolute", "base", "crank", pins[0]),
            ("revolute", "crank", "rod", pins[1]),
            ("revolute", "base", "rocker", pins[3]),
        ],
        [("revolute", "rod", "rocker", pins[2])],
        [Relation("alike", "rocker_joint", "crank_joint", sign, 0.0)],
    )
    assert counts(robot)[0] == (3, -3, dof, {"loop_0": 3 + dof})


def test_a_train_of_gears_has_one_whatever_its_length_and_ratio() -> None:
    joints = [("revolute", "base", f"wheel_{n}", at(0.1 * n, 0, 0)) for n in range(80)]
    relations = [
        Relation(f"gear_{n}", f"wheel_{n}_joint", "wheel_0_joint", (-1.5) ** n, 0.0) for n in range(1, 80)
    ]
    found, _ = counts(drawn(joints, relations=relations))
    assert found == (80, 1, 1, {})


def test_two_linkages_that_a_steep_gear_ties_move_as_one() -> None:
    """Where the one moves a millionth of the other it moves all the same: no loop is rigid."""
    pins = [at(x, y, 0) for x, y in ((0, 0), (0, 1), (2, 1.5), (2, 0))]
    joints, loops = [], []
    for side in "ab":
        links = ["base", *(f"{side}{number}" for number in range(3))]
        joints += [("revolute", links[n], links[n + 1], pin) for n, pin in enumerate(pins[:-1])]
        loops.append(("revolute", links[-1], "base", pins[-1]))
    found, log = counts(drawn(joints, loops, [Relation("gear", "b0_joint", "a0_joint", 1e8, 0.0)]))
    assert found == (6, -5, 1, {"loop_0": 3, "loop_1": 3})
    assert not told(log)


@pytest.mark.parametrize("sign", [1, -1])
def test_a_rack_that_the_loop_implies_takes_nothing(sign: int) -> None:
    """Crank pin at (x, y), rod to a piston at (d, 0): the piston's rate is −y − x y / (d − x) of the
    crank's, as the rod keeps its length."""
    x, y, d = 0.1, 0.2, 0.7
    rate = -y - x * y / (d - x)
    robot = drawn(
        [
            ("revolute", "base", "crank", at(0, 0, 0)),
            ("revolute", "crank", "rod", at(x, y, 0)),
            ("prismatic", "base", "piston", along((1, 0, 0), (d, 0, 0))),
        ],
        [("revolute", "rod", "piston", at(d, 0, 0))],
        [Relation("rack", "piston_joint", "crank_joint", sign * rate, 0.0)],
    )
    dof = 1 if sign == 1 else 0
    assert counts(robot)[0] == (3, -3, dof, {"loop_0": 3 + dof})


@pytest.mark.parametrize(("tilt", "dof"), [(0.0, 2), (0.4, 1)])
def test_a_dof_moves_about_its_axis_where_the_one_before_it_leaves_it(tilt: float, dof: int) -> None:
    """A slide along z and a turn about an axis tilted from it, in a guide along and about z."""
    tilted = from_parts(turn(np.array([1.0, 0, 0]), tilt), np.zeros(3))
    arm = joint("cylindrical", "base", "arm", origins=[tilted])
    guide = loop("cylindrical", "arm", "base", inverse(tilted), np.eye(4))
    assert counts(robot_with([arm], loops=[guide]))[0] == (2, -2, dof, {"loop": 2 + dof})


def drawn_with(robot: Robot, relations) -> Robot:
    return robot_with(robot.joints, loops=robot.loops, relations=relations)


def test_redundancy_is_reported_the_later_loop_by_name() -> None:
    """Two equal mates close one ring: the second says nothing at all."""
    four = polygon((0, 0), (0.1, 0.3), (0.5, 0.4), (0.6, 0))
    (one,) = four.loops
    for loops in ([one, replace(one, name="again")], [replace(one, name="again"), one]):
        found, log = counts(robot_with(four.joints, loops=loops))
        assert found == (3, -7, 1, {"again": 3, "loop_0": 5})
        assert told(log) == []


def test_a_loop_between_links_that_do_not_move_is_redundant_alone() -> None:
    robot = drawn([("fixed", "base", "arm", at(1, 0, 0))], [("revolute", "arm", "base", at(0, 0, 0))])
    found, log = counts(robot)
    assert found == (0, -5, 0, {"loop_0": 5})
    assert told(log) == []


def extended_nullity(robot: Robot) -> int:
    """Motions by central differences: with the loops' own dofs as unknowns beside the tree's, each loop
    has six rows, the twist of frame a in frame b at the end of the loop's chain."""
    saved: dict = {**saved_configuration(robot), **{d.name: d.saved for one in robot.loops for d in one.dofs}}
    dofs = [*robot.dofs, *(dof for one in robot.loops for dof in one.dofs)]

    def gaps(q: Mapping) -> list[np.ndarray]:
        poses = link_poses(robot, q)
        return [
            inverse(poses[one.link_b] @ one.b_from_frame @ chain(one.dofs, q))
            @ poses[one.link_a]
            @ one.a_from_frame
            for one in robot.loops
        ]

    at_rest = gaps(saved)
    columns, h = [], 1e-5
    for dof in dofs:
        for changed in nudged(dof, saved[dof.name], h):
            ahead, behind = (gaps({**saved, dof.name: value}) for value in changed)
            twists = []
            for gap, one, other in zip(at_rest, ahead, behind, strict=True):
                rate = inverse(gap) @ (one - other) / (2 * h)
                twists += [rate[2, 1], rate[0, 2], rate[1, 0], *rate[:3, 3]]
            columns.append(twists)
    sizes = np.linalg.svd(np.column_stack(columns), compute_uv=False)
    return len(columns) - int((sizes > 1e-7 * sizes[0]).sum())


def nudged(dof, value, h):
    if isinstance(value, float):
        return [(value + h, value - h)]
    pairs = []
    for axis in np.eye(3):
        turned = [rotation_of(value) @ turn(axis, sign * h) for sign in (1, -1)]
        quats = [tuple(float(x) for x in quat_of(rotation)) for rotation in turned]
        pairs.append(tuple((*value[:-4], *quat) for quat in quats))
    for axis in np.eye(3) if dof.kind == "free" else ():
        place = np.array(value[:3])
        pairs.append(tuple((*map(float, place + sign * h * axis), *value[3:]) for sign in (1, -1)))
    return pairs


def rotation_of(value):
    return rotation_from_quat(np.array(value[-4:]))


def quat_of(rotation):
    from scipy.spatial.transform import Rotation

    x, y, z, w = Rotation.from_matrix(rotation).as_quat()
    return w, x, y, z


@pytest.mark.parametrize("parallel", [False, True])
@pytest.mark.parametrize("kind", LOOPS)
def test_random_rings_of_every_type_against_numeric_differences(kind, parallel) -> None:
    """Links saved anywhere, chains either way round, frames skew or with all their axes parallel."""
    rng = np.random.default_rng(LOOPS.index(kind) + 20 * parallel)

    def place():
        return at(*rng.uniform(-0.3, 0.3, 3)) if parallel else pose(rng)

    kinds = ["cylindrical", "revolute", "planar", "pin_slot", "prismatic", "revolute"]
    kinds = kinds[:4] if parallel else [*kinds[:2], "ball", kinds[3]]
    joints, parent = [], "base"
    for number, what in enumerate(kinds):
        values = [some_value(each, rng) for _, each, _ in CHAINS[what]]
        way = {"backwards": number % 2 == 1, "origins": [place() for _ in values[1:]]}
        joints.append(joint(what, parent, f"link_{number}", values, place=place(), **way))
        parent = "base" if number == 1 else f"link_{number}"
    values = [some_value(each, rng) for _, each, _ in CHAINS[kind]]
    own = loop(kind, "link_1", parent, np.eye(4), place(), values)
    poses = link_poses(robot_with(joints), saved_configuration(robot_with(joints)))
    closed = (
        inverse(poses["link_1"])
        @ poses[parent]
        @ own.b_from_frame
        @ chain(own.dofs, {dof.name: dof.saved for dof in own.dofs})
    )
    robot = robot_with(joints, loops=[replace(own, a_from_frame=closed)])
    coordinates, gruebler, dof, redundant = counts(robot)[0]
    assert dof == extended_nullity(robot)
    assert dof == gruebler + sum(redundant.values())
    assert coordinates == sum({"ball": 3}.get(one.kind, 1) for one in robot.dofs)
