"""Random trees of boxes and balls: the exported MJCF has the contacts of a search in closed form, less the
excludes."""

from itertools import combinations

import numpy as np
import pytest

from linkwright.stages.mesh.contacts.analysis import POSES
from linkwright.stages.mesh.contacts.colliders import measures_overlaps
from linkwright.stages.robot.contact.left_out import FilteredPairs
from linkwright.stages.robot.model.geometry import Geometry, Shape
from linkwright.stages.robot.model.robot import Limits
from linkwright.stages.robot.motion.pose_samples import sampled_poses
from linkwright.stages.robot.motion.start_pose import home
from tests.support.exports import compiled, exported
from tests.support.robots import EVERY, joint, pose, robot_with
from tests.support.touching import (
    apart,
    ball,
    box,
    excluded,
    geometry_of,
    geoms_apart,
    geoms_in_mujoco,
    in_mujoco,
)

SEEDS = [*range(2), *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(2, 30))]
NARROW = {1, 4, 5, 10, 16, 20}
"""Seeds of a crowd with links of which only some shapes always touch."""

CLEAR = 1e-5
"""Links that are nearer than this [m] to just touching may count as either."""


def some_shapes(rng, count, sizes, radii, reach):
    """Boxes, or balls in three of ten cases."""
    return tuple(
        box(*rng.uniform(*sizes, 3), pose(rng, reach))
        if rng.random() < 0.7
        else ball(rng.uniform(*radii), pose(rng, reach))
        for _ in range(count)
    )


def random_robot(seed):
    """A tree of up to eight links with shapes near their joints; some have none."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(4, 9))
    kinds = [kind for kind in EVERY if kind != "free"]
    names = [f"l{index}" for index in range(count)]
    joints = []
    for index, name in enumerate(names[1:], 1):
        suffixes = ("", "_turn", "_slide", "_x", "_y", "_z")
        limits = {f"{name}_joint{suffix}": Limits(-0.4, 0.5) for suffix in suffixes}
        above = names[int(rng.integers(max(0, index - 3), index))]
        kind, more = str(rng.choice(kinds)), {"place": pose(rng, 0.12), "limits": limits}
        joints.append(joint(kind, above, name, backwards=bool(rng.integers(2)), **more))
    shapes = dict.fromkeys(names, ())
    for name in names:
        if rng.random() < 0.8:
            shapes[name] = some_shapes(rng, int(rng.integers(1, 3)), (0.03, 0.2), (0.03, 0.08), 0.05)
    where = {"fixed": bool(rng.integers(2)), "world_from_root": pose(rng)}
    return robot_with(joints, shapes=shapes, root=names[0], **where)


def crowd(seed):
    """A base with links that hardly move, so that some of their shapes always touch."""
    rng = np.random.default_rng(1000 + seed)
    names = [f"l{index}" for index in range(int(rng.integers(3, 6)))]
    limits = {f"{name}_joint": Limits(-0.3, 0.3) for name in names}
    joints = [joint("revolute", "base", name, place=pose(rng, 0.06), limits=limits) for name in names]
    sizes = (0.02, 0.1), (0.02, 0.06), 0.12
    shapes = {name: some_shapes(rng, int(rng.integers(2, 5)), *sizes) for name in names}
    return robot_with(joints, shapes=shapes, root="base")


def row(values, index):
    return {n: float(v[index]) if v.ndim == 1 else tuple(v[index]) for n, v in values.items()}


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("made", [random_robot, crowd])
def test_contacts_are_those_of_all_that_touch_less_the_excludes(made, seed):
    robot = made(seed)
    geometry = geometry_of(robot)
    if made is crowd and seed in NARROW:
        assert any(exclude.geoms for exclude in geometry.excludes)
    reasons = {(exclude.link_a, exclude.link_b): exclude for exclude in geometry.excludes}
    model = compiled(exported(robot, geometry))
    values = sampled_poses(robot, POSES, 1.0, home(robot))
    every = [home(robot), *(row(values, index) for index in range(POSES))]
    distances = [geoms_apart(robot, q) for q in every]
    never = excluded(robot, geometry.excludes)
    for q, distance in list(zip(every, distances, strict=True))[:40]:
        touching = {pair for pair, off in distance.items() if off < -CLEAR}
        unclear = {pair for pair, off in distance.items() if abs(off) <= CLEAR}
        touching_pairs = geoms_in_mujoco(model, robot, q)
        assert touching_pairs - unclear == touching - never
    start = distances[0]
    for pair in apart(robot, home(robot)):
        shapes = [shape for shape in start if (shape[0][0], shape[1][0]) == pair]
        exclude = reasons.get(pair)
        if exclude is None:
            assert not touch_always(shapes, distances), pair
            continue
        left_out = [shape for shape in shapes if shape in never]
        off = min(start[shape] for shape in left_out)
        accurate = 2e-5 if measures_overlaps() else max(2e-5, -0.6 * off)
        assert exclude.depth == pytest.approx(max(0.0, -off), abs=accurate), pair
        if exclude.reason == "Adjacent":
            assert not exclude.geoms
            continue
        assert touch_always(shapes, distances), pair
        always_meet = [shape for shape in shapes if touch_always([shape], distances)]
        rest = [shape for shape in shapes if shape not in always_meet]
        # As few as will do: each shape is a collider of its own here.
        assert left_out == (shapes if touch_always(rest, distances) else always_meet), pair
    messages = [
        diagnostic.message for diagnostic in geometry.diagnostics if diagnostic.code == "W-SELF-CONTACT"
    ]
    free = {(shape[0][0], shape[1][0]) for shape, off in start.items() if off < -CLEAR and shape not in never}
    assert all(f"{first} and {other} (" in messages[0] for first, other in free)
    assert free <= {(touching.link_a, touching.link_b) for touching in geometry.touching}
    assert bool(free) == bool(messages)


def touch_always(shapes, distances):
    """Whether some of these pairs of shapes touch in every pose."""
    return all(any(distance[shape] < 0 for shape in shapes) for distance in distances)


@pytest.mark.parametrize("seed", SEEDS)
def test_contacts_that_mujoco_leaves_out_are_known(seed):
    """All links in one place: pairs without a contact are those for which no exclude is written."""
    bare = random_robot(100 + seed)
    names = [link.name for link in bare.links]
    shapes = tuple(Shape(name, "collision", None, None, 0, 0, 1.0, 1.0, ball(50.0)) for name in names)
    model = compiled(exported(bare, Geometry(shapes, {}, (), True)))
    touching_pairs = in_mujoco(model, bare, home(bare))
    left_out = FilteredPairs(bare)
    assert touching_pairs == {pair for pair in combinations(names, 2) if not left_out.contains(*pair)}
