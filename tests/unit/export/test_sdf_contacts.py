"""Which colliders of an SDF collide, by the rule of Gazebo's DART engine: masks that share a bit."""

import itertools

import numpy as np
import pytest

from linkwright.stages.formats.written import Written
from linkwright.stages.robot.model.geometry import Exclude
from linkwright.stages.validate.read.sdf import check_file
from tests.support.building import solid
from tests.support.exports import exported, messages_of
from tests.support.robots import joint, robot_with
from tests.support.sdf import Sdf
from tests.support.touching import ball

DEFAULT = 0xFF
"""The mask of a collider that has none in the file (sdformat, `sdf::Contact`)."""


def robot_of(counts, excludes=(), kind="revolute"):
    """A base with so many links on it, each of so many balls."""
    balls = {"base": (ball(0.1),)} | {f"l{index}": (ball(0.1),) * count for index, count in enumerate(counts)}
    robot = robot_with([joint(kind, "base", f"l{index}") for index in range(len(counts))], shapes=balls)
    return robot, solid(robot, self_contact=True, excludes=tuple(excludes))


def sdf_and_losses(robot, geometry):
    made = exported(robot, geometry, export={"sdf": {}})
    return made.files["robot.sdf"], messages_of(made, "I-SDF-SELF")


def masks(text):
    by_collider = {}
    for name, node in Sdf(text).links.items():
        for number, shape in enumerate(node.findall("collision")):
            mask = shape.findtext("surface/contact/collide_bitmask")
            by_collider[name, number] = DEFAULT if mask is None else int(mask)
    return by_collider


def colliding(text):
    """The pairs of colliders that Gazebo lets collide."""
    sdf = Sdf(text)
    joined = {frozenset((joint.findtext("parent"), joint.findtext("child"))) for joint in sdf.joints.values()}
    if sdf.top.findtext("self_collide") != "true":
        return set()
    return {
        frozenset((first, other))
        for (first, mask), (other, other_mask) in itertools.combinations(masks(text).items(), 2)
        if first[0] != other[0] and frozenset((first[0], other[0])) not in joined and mask & other_mask
    }


def wanted(robot, geometry):
    joined = {frozenset((joint.parent, joint.child)) for joint in robot.joints}
    apart = {(exclude.link_a, exclude.link_b): exclude.geoms for exclude in geometry.excludes}
    pairs = set()
    for first, other in itertools.combinations([link.name for link in robot.links], 2):
        sizes = [range(len(robot.link(name).shapes)) for name in (first, other)]
        for pair in itertools.product(*sizes):
            geoms = apart.get((first, other))
            meets = geoms is None or (geoms and pair not in geoms)
            if meets and frozenset((first, other)) not in joined:
                pairs.add(frozenset(zip((first, other), pair, strict=True)))
    return pairs


def checked(folder, text, robot, geometry):
    (folder / "robot.sdf").write_bytes(text)
    checks = check_file(folder / "robot.sdf", Written(robot, geometry=geometry), quick=False)
    return [finding.message for check in checks if check.fails for finding in check.findings]


@pytest.mark.parametrize("seed", range(20))
def test_single_colliders_are_kept_apart_and_all_others_collide(seed, tmp_path):
    random = np.random.default_rng(seed)
    counts = random.integers(1, 4, random.integers(2, 9)).tolist()
    excludes = [Exclude("base", "l0", "Adjacent", 0.0)]
    for (a, first_count), (b, other) in itertools.combinations(enumerate(counts), 2):
        if random.random() < 0.2:
            chosen = np.argwhere(random.random((first_count, other)) < 0.4)
            geoms = tuple((int(i), int(j)) for i, j in chosen) if len(chosen) < first_count * other else ()
            excludes.append(Exclude(f"l{a}", f"l{b}", "Always", 0.0, geoms))
    robot, geometry = robot_of(counts, excludes)
    text, losses = sdf_and_losses(robot, geometry)
    assert not losses
    assert colliding(text) == wanted(robot, geometry)
    assert all(mask & DEFAULT for mask in masks(text).values()), "each collides with the ground"
    assert checked(tmp_path, text, robot, geometry) == []


def test_robot_without_single_pairs_has_no_masks():
    robot, geometry = robot_of([1, 2], [Exclude("base", "l0", "Adjacent", 0.0)])
    text, losses = sdf_and_losses(robot, geometry)
    assert b"collide_bitmask" not in text
    assert colliding(text) == wanted(*robot_of([1, 2]))
    assert not losses


def test_links_beside_a_joint_of_two_dofs_have_masks():
    """An SDF has a link between them, so Gazebo does not leave them out by itself."""
    excludes = [Exclude("base", f"l{n}", "Adjacent", 0.0) for n in range(2)]
    text, _ = sdf_and_losses(*robot_of([1, 1], excludes, "cylindrical"))
    assert {tuple(sorted(name for name, _ in pair)) for pair in colliding(text)} == {("l0", "l1")}


def test_pairs_beyond_the_bits_lose_contacts_by_name(tmp_path):
    random = np.random.default_rng(0)
    pairs = [pair for pair in itertools.combinations(range(24), 2) if random.random() < 0.3]
    robot, geometry = robot_of([1] * 24, [Exclude(f"l{a}", f"l{b}", "User", 0.0) for a, b in pairs])
    text, (loss,) = sdf_and_losses(robot, geometry)
    missing = wanted(robot, geometry) - colliding(text)
    assert colliding(text) <= wanted(robot, geometry)
    assert missing
    named = {frozenset(words.split(" and ")) for words in loss.partition(": ")[2].split(", ")}
    assert named == {frozenset(name for name, _ in pair) for pair in missing}
    assert checked(tmp_path, text, robot, geometry) == []


@pytest.mark.parametrize(("number", "collides"), [(8, True), (9, False)])
def test_links_beyond_the_low_bits_end_all_contacts(number, collides, tmp_path):
    pairs = itertools.combinations(range(number), 2)
    robot, geometry = robot_of([1] * 9, [Exclude(f"l{a}", f"l{b}", "User", 0.0) for a, b in pairs])
    text, losses = sdf_and_losses(robot, geometry)
    assert bool(colliding(text)) == collides != bool(losses)
    assert checked(tmp_path, text, robot, geometry) == []


@pytest.mark.parametrize(("old", "new", "message"), [
    ("<collide_bitmask>1</", "<collide_bitmask>3</", "colliders of l0 and l1 collide, but must not"),
    ("<collide_bitmask>1</", "<collide_bitmask>256</", "shares no bit with 255"),
    ("<self_collide>true</", "<self_collide>false</", "is false, expected true"),
    ("<collide_bitmask>2</", "<collide_bitmask>4</", "do not collide, but must"),
])  # fmt: skip
def test_other_masks_than_the_robots_are_found(old, new, message, tmp_path):
    excludes = [Exclude("l0", "l1", "User", 0.0), Exclude("l0", "l2", "User", 0.0, ((0, 0),))]
    excludes.append(Exclude("l1", "l2", "User", 0.0, ((0, 1),)))
    robot, geometry = robot_of([1, 1, 2], excludes)
    text, _ = sdf_and_losses(robot, geometry)
    assert old.encode() in text, text.decode()
    messages = checked(tmp_path, text.replace(old.encode(), new.encode(), 1), robot, geometry)
    assert any(message in text for text in messages), messages
