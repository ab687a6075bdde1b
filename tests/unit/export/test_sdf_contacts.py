"""Which colliders of an SDF collide, by the rule of Gazebo's DART engine: masks that share a bit."""

import itertools
from pathlib import Path

import numpy as np
import pytest

from linkwright.stages.export import export
from linkwright.stages.formats.written import Written
from linkwright.stages.mesh.collide.primitives import shapes as primitive_shapes
from linkwright.stages.robot.model.geometry import Exclude, Geometry
from linkwright.stages.robot.model.robot import Robot
from linkwright.stages.validate.read.sdf import check_file
from tests.support.building import plan_of
from tests.support.robots import joint, robot_with
from tests.support.sdf import Sdf
from tests.support.touching import ball

DEFAULT = 0xFF
"""The mask of a collider that has none in the file (sdformat, `sdf::Contact`)."""


def robot_of(counts, kind="revolute") -> tuple[Robot, Geometry]:
    """A base with so many links on it, each of so many balls."""
    names = [f"l{index}" for index in range(len(counts))]
    balls = {name: (ball(0.1),) * number for name, number in zip(["base", *names], [1, *counts], strict=True)}
    robot = robot_with([joint(kind, "base", name) for name in names], shapes=balls)
    shapes = tuple(shape for link in robot.links for shape in primitive_shapes(link))
    return robot, Geometry(shapes, {}, self_contact=True)


def with_excludes(geometry: Geometry, excludes) -> Geometry:
    return Geometry(geometry.shapes, {}, self_contact=True, excludes=tuple(excludes))


def exported(robot: Robot, geometry: Geometry):
    made = export(robot, geometry, plan_of(export={"sdf": {}}))
    return made.files["robot.sdf"], [one for one in made.diagnostics if one.code == "I-SDF-SELF"]


def masks(text: bytes) -> dict[tuple[str, int], int]:
    found = {}
    for name, node in Sdf(text).links.items():
        for number, shape in enumerate(node.findall("collision")):
            mask = shape.findtext("surface/contact/collide_bitmask")
            found[name, number] = DEFAULT if mask is None else int(mask)
    return found


def colliding(text: bytes) -> set[frozenset[tuple[str, int]]]:
    """The pairs of colliders that Gazebo lets collide."""
    sdf = Sdf(text)
    joined = {frozenset((one.findtext("parent"), one.findtext("child"))) for one in sdf.joints.values()}
    if sdf.top.findtext("self_collide") != "true":
        return set()
    return {
        frozenset((one, other))
        for (one, mask), (other, other_mask) in itertools.combinations(masks(text).items(), 2)
        if one[0] != other[0] and frozenset((one[0], other[0])) not in joined and mask & other_mask
    }


def wanted(robot: Robot, geometry: Geometry) -> set[frozenset[tuple[str, int]]]:
    joined = {frozenset((one.parent, one.child)) for one in robot.joints}
    apart = {(one.link_a, one.link_b): one.geoms for one in geometry.excludes}
    found = set()
    for one, other in itertools.combinations([link.name for link in robot.links], 2):
        sizes = [range(len(robot.link(name).shapes)) for name in (one, other)]
        for pair in itertools.product(*sizes):
            geoms = apart.get((one, other))
            meets = geoms is None or (geoms and pair not in geoms)
            if meets and frozenset((one, other)) not in joined:
                found.add(frozenset(zip((one, other), pair, strict=True)))
    return found


def checked(folder: Path, text: bytes, robot: Robot, geometry: Geometry) -> list[str]:
    (folder / "robot.sdf").write_bytes(text)
    checks = check_file(folder / "robot.sdf", Written(robot, geometry=geometry), quick=False)
    return [finding.message for check in checks if check.fails for finding in check.findings]


@pytest.mark.parametrize("seed", range(20))
def test_single_colliders_are_kept_apart_and_all_others_collide(seed: int, tmp_path: Path) -> None:
    random = np.random.default_rng(seed)
    counts = random.integers(1, 4, random.integers(2, 9)).tolist()
    robot, plain = robot_of(counts)
    excludes = [Exclude("base", "l0", "Adjacent", 0.0)]
    for (a, one), (b, other) in itertools.combinations(enumerate(counts), 2):
        if random.random() < 0.2:
            chosen = np.argwhere(random.random((one, other)) < 0.4)
            geoms = tuple((int(i), int(j)) for i, j in chosen) if len(chosen) < one * other else ()
            excludes.append(Exclude(f"l{a}", f"l{b}", "Always", 0.0, geoms))
    geometry = with_excludes(plain, excludes)
    text, losses = exported(robot, geometry)
    assert not losses
    assert colliding(text) == wanted(robot, geometry)
    assert all(mask & DEFAULT for mask in masks(text).values()), "each collides with the ground"
    assert checked(tmp_path, text, robot, geometry) == []


def test_a_robot_without_single_pairs_has_no_masks() -> None:
    robot, plain = robot_of([1, 2])
    text, losses = exported(robot, with_excludes(plain, [Exclude("base", "l0", "Adjacent", 0.0)]))
    assert b"collide_bitmask" not in text
    assert colliding(text) == wanted(robot, plain)
    assert not losses


def test_links_on_either_side_of_a_joint_of_two_dofs_are_told_apart_by_masks() -> None:
    """An SDF has a link between them, so Gazebo does not leave them out by itself."""
    robot, plain = robot_of([1, 1], "cylindrical")
    geometry = with_excludes(plain, [Exclude("base", f"l{n}", "Adjacent", 0.0) for n in range(2)])
    text, _ = exported(robot, geometry)
    assert {tuple(sorted(name for name, _ in pair)) for pair in colliding(text)} == {("l0", "l1")}


def test_more_pairs_than_bits_lose_contacts_by_name_and_touch_nothing_more(tmp_path: Path) -> None:
    robot, plain = robot_of([1] * 24)
    random = np.random.default_rng(0)
    pairs = [pair for pair in itertools.combinations(range(24), 2) if random.random() < 0.3]
    geometry = with_excludes(plain, [Exclude(f"l{a}", f"l{b}", "User", 0.0) for a, b in pairs])
    text, losses = exported(robot, geometry)
    missing = wanted(robot, geometry) - colliding(text)
    assert colliding(text) <= wanted(robot, geometry)
    assert missing
    (loss,) = losses
    named = {frozenset(words.split(" and ")) for words in loss.message.partition(": ")[2].split(", ")}
    assert named == {frozenset(name for name, _ in pair) for pair in missing}
    assert checked(tmp_path, text, robot, geometry) == []


def test_more_links_apart_from_each_other_than_low_bits_end_all_contacts(tmp_path: Path) -> None:
    robot, plain = robot_of([1] * 9)
    for number, collides in ((8, True), (9, False)):
        pairs = itertools.combinations(range(number), 2)
        geometry = with_excludes(plain, [Exclude(f"l{a}", f"l{b}", "User", 0.0) for a, b in pairs])
        text, losses = exported(robot, geometry)
        assert bool(colliding(text)) == collides != bool(losses)
        assert checked(tmp_path, text, robot, geometry) == []


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("<collide_bitmask>1</", "<collide_bitmask>3</", "colliders of l0 and l1 collide, but must not"),
        ("<collide_bitmask>1</", "<collide_bitmask>256</", "shares no bit with 255"),
        ("<self_collide>true</", "<self_collide>false</", "is false, expected true"),
        ("<collide_bitmask>2</", "<collide_bitmask>4</", "do not collide, but must"),
    ],
)
def test_other_masks_than_the_robots_are_found(old: str, new: str, message: str, tmp_path: Path) -> None:
    robot, plain = robot_of([1, 1, 2])
    excludes = [Exclude("l0", "l1", "User", 0.0), Exclude("l0", "l2", "User", 0.0, ((0, 0),))]
    excludes.append(Exclude("l1", "l2", "User", 0.0, ((0, 1),)))
    geometry = with_excludes(plain, excludes)
    text, _ = exported(robot, geometry)
    assert old.encode() in text, text.decode()
    messages = checked(tmp_path, text.replace(old.encode(), new.encode(), 1), robot, geometry)
    assert any(message in one for one in messages), messages
