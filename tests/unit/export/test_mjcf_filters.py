"""Geoms that do not collide, in MuJoCo: whatever the excludes, it has all other contacts."""

import itertools

import mujoco
import numpy as np
import pytest

from stages.export.mjcf.filters import CLASSES, filters
from stages.export.mjcf.left_out import LeftOut
from stages.robot.geometry import Exclude, Geometry, Shape
from stages.robot.start_pose import home
from tests.support.robots import joint, robot_with
from tests.support.touching import ball, compiled, exported, geoms_in_mujoco, model_of


def robot_of(counts, fixed=True):
    """A base with so many links on it, each of so many balls, all in one place."""
    names = [f"l{index}" for index in range(len(counts))]
    robot = robot_with([joint("revolute", "base", name) for name in names], root="base", fixed=fixed)
    shapes = [
        Shape(name, "collision", None, None, 0, 0, 1.0, 1.0, ball(5.0))
        for name, count in zip(["base", *names], [1, *counts], strict=True)
        for _ in range(count)
    ]
    return robot, shapes


def every_pair(robot, geometry):
    """The pairs of shapes that collide, one by one."""
    left_out = LeftOut(robot)
    excludes = {(one.link_a, one.link_b): one for one in geometry.excludes}
    found = set()
    for one, other in itertools.combinations([link.name for link in robot.links], 2):
        if left_out.contains(one, other):
            continue
        exclude = excludes.get((one, other))
        sizes = [range(len(geometry.of(link, "collision"))) for link in (one, other)]
        for i, j in itertools.product(*sizes):
            if exclude is None or (exclude.geoms and (i, j) not in exclude.geoms):
                found.add(((one, i), (other, j)))
    return found


def random_excludes(rng, counts):
    names = [f"l{index}" for index in range(len(counts))]
    for (a, one), (b, other) in itertools.combinations(zip(names, counts, strict=True), 2):
        if rng.random() < 0.5:
            mask = rng.random((one, other)) < 0.3
            geoms = () if mask.all() or rng.random() < 0.2 else np.argwhere(mask).tolist()
            yield Exclude(a, b, "Always", 0.0, tuple((i, j) for i, j in geoms))


@pytest.mark.parametrize("seed", range(20))
def test_any_excludes_of_geoms_are_kept_exactly(seed, tmp_path):
    rng = np.random.default_rng(seed)
    counts = rng.integers(1, 6, rng.integers(2, 6)).tolist()
    robot, shapes = robot_of(counts, fixed=bool(rng.integers(2)))
    excludes = tuple(random_excludes(rng, counts))
    geometry = Geometry(tuple(shapes), {}, (), True, excludes)
    assert not filters(robot, geometry).wide
    model = model_of(robot, geometry, tmp_path)
    assert geoms_in_mujoco(model, robot, home(robot)) == every_pair(robot, geometry)


def cliques(number):
    """So many pairs of links, of each of which the first balls do not collide."""
    robot, shapes = robot_of([2] * (2 * number))
    pairs = [(f"l{2 * index}", f"l{2 * index + 1}") for index in range(number)]
    excludes = tuple(Exclude(*pair, "Always", 0.0, ((0, 0),)) for pair in pairs)
    return robot, Geometry(tuple(shapes), {}, (), True, excludes), pairs


def test_geoms_that_all_touch_each_other_share_a_bit(tmp_path):
    robot, shapes = robot_of([2, 2, 2])
    excludes = tuple(
        Exclude(a, b, "Always", 0.0, ((0, 0),)) for a, b in itertools.combinations(("l0", "l1", "l2"), 2)
    )
    geometry = Geometry(tuple(shapes), {}, (), True, excludes)
    assert filters(robot, geometry).bits == {(f"l{index}", 0): (1 << 30, 1) for index in range(3)}
    model = model_of(robot, geometry, tmp_path)
    assert geoms_in_mujoco(model, robot, home(robot)) == every_pair(robot, geometry)


@pytest.mark.slow
def test_thirty_classes_are_told_apart_and_what_is_beyond_them_is_said(tmp_path):
    robot, geometry, pairs = cliques(CLASSES + 2)
    found = filters(robot, geometry)
    assert found.wide == tuple(pairs[CLASSES:])
    assert found.pairs == found.wide
    assert len(set(found.bits.values())) == CLASSES
    assert all(0 < number < 1 << 31 for bits in found.bits.values() for number in bits)
    made = exported(robot, geometry)
    losses = [one for one in made.diagnostics if one.code == "W-WIDE-EXCLUDE"]
    assert len(losses) == 1
    assert all(f"{one} and {other}" in losses[0].message for one, other in found.wide)
    model = compiled(made, robot, tmp_path)
    lost = {pair for pair in every_pair(robot, geometry) if (pair[0][0], pair[1][0]) in found.wide}
    assert len(lost) == 3 * 2
    assert geoms_in_mujoco(model, robot, home(robot)) == every_pair(robot, geometry) - lost


def test_what_does_not_touch_the_links_of_the_world_still_touches_the_ground(tmp_path):
    """A root called `world` is MuJoCo's worldbody, in which the ground is too."""
    bare = robot_with([joint("revolute", "world", "arm")], root="world")
    for world in (0, 2):
        shapes = [
            Shape(link, "collision", None, None, 0, 0, 1.0, 1.0, ball(5.0))
            for link in ["world"] * world + ["arm"] * 2
        ]
        excludes = (Exclude("world", "arm", "User", 0.0),)
        geometry = Geometry(tuple(shapes), {}, (), True, excludes)
        assert filters(bare, geometry).pairs == ()
        model_of(bare, geometry, tmp_path)
        model = mujoco.MjModel.from_xml_path(str(tmp_path / "scene.xml"))
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        met = {frozenset(model.geom(one).name for one in contact.geom) for contact in data.contact}
        assert met == {frozenset(("floor", f"arm_collision_{index}")) for index in range(2)}


def test_as_many_as_there_are_bits_need_no_wider_exclude():
    robot, geometry, _ = cliques(CLASSES)
    assert filters(robot, geometry).wide == ()


def test_the_floor_and_objects_of_a_user_meet_every_class(tmp_path):
    """Whether they do or do not collide among themselves, as long as they have the lowest bit in contype."""
    robot, geometry, _ = cliques(3)
    model_of(robot, geometry, tmp_path)
    spec = mujoco.MjSpec.from_file(str(tmp_path / "scene.xml"))
    for name, conaffinity in (("thing", 1), ("pusher", 0)):
        body = spec.worldbody.add_body(name=name)
        body.add_freejoint()
        body.add_geom(name=name, type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[0.1, 0, 0], conaffinity=conaffinity)
    for key in list(spec.keys):
        # Older versions of MuJoCo have it on the element.
        spec.delete(key) if hasattr(spec, "delete") else key.delete()
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    solid = {model.geom(index).name for index in range(model.ngeom) if model.geom(index).name.startswith("l")}
    assert len(solid) == 12
    met = {frozenset(model.geom(one).name for one in contact.geom) for contact in data.contact[: data.ncon]}
    for other in ("floor", "thing", "pusher"):
        assert {frozenset((one, other)) for one in solid} <= met
    low = spec.worldbody.add_geom(name="low", type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[0.1, 0, 0])
    low.contype, low.conaffinity = 2, 2
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    assert not [one for one in data.contact[: data.ncon] if model.geom("low").id in one.geom]
