"""Colliders that do not collide: whatever the excludes, MuJoCo and Gazebo have all other contacts."""

import itertools
from dataclasses import replace

import mujoco
import numpy as np
import pytest

from linkwright.stages.export.mjcf.contact.filters import MAX_CLASSES, filters_of
from linkwright.stages.formats.written import Written
from linkwright.stages.robot.contact.left_out import FilteredPairs
from linkwright.stages.robot.model.geom_form import ContactProperties
from linkwright.stages.robot.model.geometry import Exclude, Geometry
from linkwright.stages.robot.motion.start_pose import home
from linkwright.stages.validate.read.sdf import check_file
from tests.support.building import solid, write
from tests.support.exports import compiled, exported, messages_of
from tests.support.robots import joint, robot_with
from tests.support.sdf import Sdf
from tests.support.states import state
from tests.support.touching import ball, geoms_in_mujoco


def robot_of(counts, excludes=(), kind="revolute", **more):
    """A base with so many links on it, each of so many balls, all in one place."""
    balls = {f"l{index}": (ball(5.0),) * count for index, count in enumerate(counts)}
    rows = [joint(kind, "base", name) for name in balls]
    robot = robot_with(rows, shapes={"base": (ball(5.0),), **balls}, **more)
    return robot, colliders(robot, excludes)


def colliders(robot, excludes=()):
    shapes = tuple(shape for shape in solid(robot).shapes if shape.role == "collision")
    return Geometry(shapes, {}, self_contact=True, excludes=tuple(excludes))


def wanted(robot, geometry, is_left_out):
    """The pairs of shapes that collide; `is_left_out`: whether the engine leaves out two links by itself."""
    excludes, pairs = (
        {(exclude.link_a, exclude.link_b): exclude.geoms for exclude in geometry.excludes},
        set(),
    )
    for first, other in itertools.combinations([link.name for link in robot.links], 2):
        sizes = [range(len(geometry.shapes_of(link, "collision"))) for link in (first, other)]
        for pair in itertools.product(*sizes):
            geoms = excludes.get((first, other))
            if (geoms is None or (geoms and pair not in geoms)) and not is_left_out(first, other):
                pairs.add(frozenset(zip((first, other), pair, strict=True)))
    return pairs


def holds_in_mujoco(robot, geometry):
    """Whether the links of the compiled model collide as they must."""
    met = geoms_in_mujoco(compiled(exported(robot, geometry)), robot, home(robot))
    return {frozenset(pair) for pair in met} == wanted(robot, geometry, FilteredPairs(robot).contains)


def random_excludes(rng, counts):
    names = [f"l{index}" for index in range(len(counts))]
    for (a, first_count), (b, other) in itertools.combinations(zip(names, counts, strict=True), 2):
        if rng.random() < 0.5:
            mask = rng.random((first_count, other)) < 0.3
            geoms = () if mask.all() or rng.random() < 0.2 else np.argwhere(mask).tolist()
            yield Exclude(a, b, "Always", 0.0, tuple((i, j) for i, j in geoms))


@pytest.mark.parametrize("seed", range(20))
def test_any_excludes_of_geoms_are_kept_exactly(seed):
    rng = np.random.default_rng(seed)
    counts = rng.integers(1, 6, rng.integers(2, 6)).tolist()
    fixed = bool(rng.integers(2))
    robot, geometry = robot_of(counts, random_excludes(rng, counts), fixed=fixed)
    assert not filters_of(robot, geometry).widened_pairs
    assert holds_in_mujoco(robot, geometry)


RUBBER = ContactProperties((1.5, 0.01, 0.002), 4, (0.01, 0.8), (0.8, 0.9, 0.002, 0.4, 2.0), 0.002)
GLASS = ContactProperties(condim=1, solref=(-500.0, -20.0), margin=0.003)
STRONG = ContactProperties(friction=(0.2, 0.0, 0.0), priority=2)

MARGIN_OF_TWO = np.sum if tuple(map(int, mujoco.__version__.split(".")[:2])) >= (3, 5) else np.max
"""The margin that MuJoCo gives two geoms without a pair: the larger of theirs before 3.5."""


def contact_properties(model):
    """The properties of each contact, by its two geoms. They are copies: in MuJoCo 3.3.3 a contact is a view
    into its MjData, and does not keep it alive."""
    data = state(model)
    keys = ("dim", "friction", "solref", "solimp", "includemargin")  # no geom has a gap: the margin itself
    return {
        tuple(sorted(contact.geom)): {key: np.array(getattr(contact, key)) for key in keys}
        for contact in data.contact[: data.ncon]
    }


@pytest.mark.parametrize(
    ("first", "other"), list(itertools.combinations_with_replacement([None, RUBBER, GLASS, STRONG], 2))
)
def test_geoms_that_still_collide_do_so_as_without_an_exclude(first, other):
    """MuJoCo's own mixture of the properties of two geoms is the oracle, and of their margins the sum."""
    robot, geometry = robot_of([2, 2])
    contacts = {"base": None, "l0": first, "l1": other}
    shapes = tuple(replace(shape, contact=contacts[shape.link]) for shape in geometry.shapes)
    properties_of = []
    for excludes in ((), (Exclude("l0", "l1", "Always", 0.0, ((0, 0),)),)):
        model = compiled(exported(robot, replace(geometry, shapes=shapes, excludes=excludes)))
        assert model.npair == 3 * len(excludes)
        properties_of.append(contact_properties(model))
    free, paired = properties_of
    first, second = (model.geom(f"l{link}_collision_0").id for link in (0, 1))
    assert free.keys() - paired.keys() == {(first, second)}
    for geoms, properties in paired.items():
        margins = model.geom_margin[list(geoms)]
        free_margin = free[geoms].pop("includemargin")
        assert free_margin == pytest.approx(MARGIN_OF_TWO(margins), rel=1e-12, abs=0)
        assert properties.pop("includemargin") == pytest.approx(margins.sum(), rel=1e-12, abs=0)
        for key, value in properties.items():
            assert np.allclose(value, free[geoms][key], rtol=1e-12, atol=0), key


@pytest.mark.parametrize("seed", range(5))
def test_two_copies_in_one_scene_collide_with_each_other(seed):
    """Each geom of the one with each of the other, whatever each copy excludes within itself."""
    rng = np.random.default_rng(seed)
    counts = rng.integers(1, 4, 3).tolist()
    robot, geometry = robot_of(counts, random_excludes(rng, counts), fixed=False)
    outcome = exported(robot, geometry)
    single = geoms_in_mujoco(compiled(outcome), robot, home(robot))
    spec = mujoco.MjSpec()
    for prefix in ("a_", "b_"):
        copy = mujoco.MjSpec.from_string(outcome.files["robot.xml"].decode())
        spec.attach(copy, prefix=prefix, frame=spec.worldbody.add_frame())
    model = spec.compile()
    met = met_in(model)
    between = {pair for pair in met if len({name[:2] for name in pair}) == 2}
    names = [model.geom(geom).name for geom in range(model.ngeom)]
    ours, theirs = ([name for name in names if name.startswith(prefix)] for prefix in ("a_", "b_"))
    assert between == {frozenset(pair) for pair in itertools.product(ours, theirs)}
    assert len(met) - len(between) == 2 * len(single)


def met_in(model):
    """The pairs of geoms that are in contact, by name."""
    data = state(model)
    return {
        frozenset(model.geom(geom).name for geom in contact.geom) for contact in data.contact[: data.ncon]
    }


def beside_the_world(number):
    """A robot with this number of balls on the world's own link, each excluded from another link on it."""
    names = [f"l{index}" for index in range(number)]
    shapes = {"world": (ball(5.0),) * number} | dict.fromkeys(names, (ball(5.0),))
    robot = robot_with([joint("revolute", "world", name) for name in names], root="world", shapes=shapes)
    excludes = [Exclude("world", name, "Always", 0.0, ((n, 0),)) for n, name in enumerate(names)]
    return robot, colliders(robot, excludes)


def test_geoms_of_the_world_are_told_apart_by_bits():
    robot, geometry = beside_the_world(4)
    masks = filters_of(robot, geometry)
    assert not masks.excluded_pairs
    assert len(set(masks.bits.values())) == 4
    assert holds_in_mujoco(robot, geometry)


@pytest.mark.slow
def test_thirty_classes_are_told_apart_and_more_are_reported():
    robot, geometry = beside_the_world(MAX_CLASSES)
    assert filters_of(robot, geometry).widened_pairs == ()
    robot, geometry = beside_the_world(MAX_CLASSES + 1)
    masks = filters_of(robot, geometry)
    assert masks.widened_pairs == masks.excluded_pairs == (("world", f"l{MAX_CLASSES}"),)
    (loss,) = messages_of(exported(robot, geometry), "W-WIDE-EXCLUDE")
    assert f"world and l{MAX_CLASSES}" in loss


@pytest.mark.parametrize("world", [0, 2])
def test_ground_touches_links_that_the_world_excludes(world, tmp_path):
    """A root called `world` is MuJoCo's worldbody, in which the ground is too."""
    shapes = {"world": (ball(5.0),) * world, "arm": (ball(5.0),) * 2}
    robot = robot_with([joint("revolute", "world", "arm")], root="world", shapes=shapes)
    geometry = colliders(robot, [Exclude("world", "arm", "User", 0.0)])
    assert filters_of(robot, geometry).excluded_pairs == ()
    write(robot, tmp_path, geometry=geometry)
    met = met_in(mujoco.MjModel.from_xml_path(str(tmp_path / "scene.xml")))
    assert met == {frozenset(("floor", f"arm_collision_{index}")) for index in range(2)}


def test_floor_and_objects_of_a_user_meet_every_class(tmp_path):
    """Whether they do or do not collide among themselves, as long as they have the lowest bit in contype."""
    robot, geometry = beside_the_world(3)
    write(robot, tmp_path, geometry=geometry)
    spec = mujoco.MjSpec.from_file(str(tmp_path / "scene.xml"))
    for name, conaffinity in (("thing", 1), ("pusher", 0)):
        body = spec.worldbody.add_body(name=name)
        body.add_freejoint()
        body.add_geom(name=name, type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[0.1, 0, 0], conaffinity=conaffinity)
    for key in list(spec.keys):
        # Older versions of MuJoCo have it on the element.
        spec.delete(key) if hasattr(spec, "delete") else key.delete()
    model = spec.compile()
    links = {model.geom(index).name for index in range(model.ngeom) if model.geom(index).name.startswith("l")}
    assert len(links) == 3
    met = met_in(model)
    for other in ("floor", "thing", "pusher"):
        assert {frozenset((geom, other)) for geom in links} <= met
    low = spec.worldbody.add_geom(name="low", type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[0.1, 0, 0])
    low.contype, low.conaffinity = 2, 2
    assert not [pair for pair in met_in(spec.compile()) if "low" in pair]


DEFAULT = 0xFF
"""The mask of a collider that has none in the file (sdformat, `sdf::Contact`)."""


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


def wanted_in_gazebo(robot, geometry):
    joined = {frozenset((joint.parent, joint.child)) for joint in robot.joints}
    return wanted(robot, geometry, lambda *links: frozenset(links) in joined)


def faults_of(folder, text, robot, geometry):
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
    assert colliding(text) == wanted_in_gazebo(robot, geometry)
    assert all(mask & DEFAULT for mask in masks(text).values()), "each collides with the ground"
    assert faults_of(tmp_path, text, robot, geometry) == []


def test_robot_without_single_pairs_has_no_masks():
    robot, geometry = robot_of([1, 2], [Exclude("base", "l0", "Adjacent", 0.0)])
    text, losses = sdf_and_losses(robot, geometry)
    assert b"collide_bitmask" not in text
    assert colliding(text) == wanted_in_gazebo(*robot_of([1, 2]))
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
    missing = wanted_in_gazebo(robot, geometry) - colliding(text)
    assert colliding(text) <= wanted_in_gazebo(robot, geometry)
    assert missing
    named = {frozenset(words.split(" and ")) for words in loss.partition(": ")[2].split(", ")}
    assert named == {frozenset(name for name, _ in pair) for pair in missing}
    assert faults_of(tmp_path, text, robot, geometry) == []


@pytest.mark.parametrize(("number", "collides"), [(8, True), (9, False)])
def test_links_beyond_the_low_bits_end_all_contacts(number, collides, tmp_path):
    pairs = itertools.combinations(range(number), 2)
    robot, geometry = robot_of([1] * 9, [Exclude(f"l{a}", f"l{b}", "User", 0.0) for a, b in pairs])
    text, losses = sdf_and_losses(robot, geometry)
    assert bool(colliding(text)) == collides != bool(losses)
    assert faults_of(tmp_path, text, robot, geometry) == []


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
    messages = faults_of(tmp_path, text.replace(old.encode(), new.encode(), 1), robot, geometry)
    assert any(message in text for text in messages), messages
