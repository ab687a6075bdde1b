"""Several mates between the same two bodies: the motion that all of them allow, and its limits.

The oracle of what a mate allows is written here in closed form, on the relative pose of its frames.
"""

import math
from dataclasses import replace
from itertools import combinations, permutations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from linkwright.stages.graph.dofs import value_in
from linkwright.stages.graph.onshape.assembly import Assembly, Entity, Mate, Occurrence
from linkwright.stages.graph.onshape.mates.joints import dofs_of, freedoms_of, right_handed
from linkwright.stages.graph.onshape.mates.parallel import combine_mates
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.poses import from_parts, inverse, rotation_from_quat, turn
from linkwright.stages.robot.model.robot import MateRef, frozen
from linkwright.stages.robot.motion.kinematics import chain

X, Y, Z = np.eye(3)
ONE, OTHER = ("one",), ("other",)
BODY_OF = {ONE: 3, OTHER: 1, (): 7}


def frame(z=Z, at=(0.0, 0.0, 0.0), spin=0.0):
    """A frame (4, 4) with this z axis, turned about it by `spin`."""
    z = np.asarray(z, float) / np.linalg.norm(z)
    x = np.eye(3)[int(np.argmin(np.abs(z)))]
    x = x - z * (z @ x)
    x /= np.linalg.norm(x)
    rotation = np.column_stack([x, np.cross(z, x), z])
    return from_parts(rotation @ turn(Z, spin), np.asarray(at, float))


class Pair:
    """Two occurrences somewhere, and mates between them at the saved pose, drawn by world frames."""

    def __init__(self, seed=0):
        self.rng = np.random.default_rng(seed)
        self.assembly = Assembly({})
        for path in (ONE, OTHER):
            place = frozen(self.somewhere())
            record = {"type": "Part"}
            self.assembly.occurrences[path] = Occurrence(path, path, record, place, False)
        self.mates = []

    def somewhere(self):
        return from_parts(rotation_from_quat(self.rng.normal(size=4)), self.rng.uniform(-1, 1, 3))

    def mate(self, name, kind, second, *values, first=ONE, limits=None):
        """A mate whose second entity stands at `second` in the world, and its dofs at `values`."""
        dofs = dofs_of("", kind, {}, np.eye(4))
        moved = second @ chain(dofs, dict(zip((dof.name for dof in dofs), values, strict=False)))
        return self.drawn(name, kind, moved, second, first, limits)

    def drawn(self, name, kind, moved, second, first=ONE, limits=None):
        paths = (first, OTHER if first == ONE else ONE)
        entities = tuple(
            Entity(path, frozen(inverse(self.assembly.occurrences[path].world_from_occurrence) @ world))
            for path, world in zip(paths, (moved, second), strict=True)
        )
        ref = MateRef((), f"id {name}", name, kind)
        self.mates.append(Mate(ref, name, entities, {} if limits is None else limits))
        return self.mates[-1]

    def combined(self):
        log = Diagnostics()
        made = combine_mates(self.mates, self.assembly, BODY_OF, log)
        assert not log.problems
        return made, sorted(note.code for note in log.notes)

    def only(self):
        made, _ = self.combined()
        (mate,) = made.mates
        assert made.welds == ()
        return mate

    def relative(self, mate, displaced=None):
        """second_from_first of a mate, with ONE displaced (4, 4, in the world)."""
        world = [
            (np.eye(4) if displaced is None or entity.path != ONE else displaced)
            @ self.assembly.world_from(entity)
            for entity in mate.entities
        ]
        first, second, _ = right_handed(*world)
        return inverse(second) @ first

    def dofs(self, mate):
        first, second, mirrored = right_handed(*(self.assembly.world_from(e) for e in mate.entities))
        limits = mate.limits or {}
        return second, dofs_of("", mate.ref.type, limits, inverse(second) @ first, mirrored)

    def displaced(self, mate, values):
        """Where ONE goes, from the saved pose, as OTHER stays and the mate's dofs get new values."""
        second, dofs = self.dofs(mate)
        saved = {dof.name: dof.saved for dof in dofs}
        moved = chain(dofs, {**saved, **values}) @ inverse(chain(dofs, saved))
        displaced = second @ moved @ inverse(second)
        return displaced if mate.entities[0].path == ONE else inverse(displaced)

    def some(self, mate):
        """Random values of a mate's dofs."""
        return {
            dof.name: tuple(self.rng.normal(size=4)) if dof.kind == "ball" else self.rng.uniform(-3, 3)
            for dof in self.dofs(mate)[1]
        }


def misfit(kind, relative):
    """What a mate forbids, as numbers that must vanish, from the pose of its first frame in its second."""
    x, y, z = relative[:3, 3]
    leaning = relative[:2, 2]
    return {
        "REVOLUTE": lambda: [x, y, z, *leaning],
        "SLIDER": lambda: [x, y, *(relative[:3, :3] - np.eye(3)).ravel()],
        "CYLINDRICAL": lambda: [x, y, *leaning],
        "BALL": lambda: [x, y, z],
        "PLANAR": lambda: [z, *leaning],
        "PARALLEL": lambda: [*leaning],
        "PIN_SLOT": lambda: [y, z, *leaning],
    }[kind]()


def freedom_left(pair):
    """How many ways the pair moves, by finite differences of what all its mates forbid."""

    def all_of(twist):
        step = 1e-6
        angle = float(np.linalg.norm(twist[:3]))
        rotation = turn(twist[:3] / angle, step * angle) if angle else np.eye(3)
        moved = from_parts(rotation, step * twist[3:])
        return np.concatenate([misfit(m.ref.type, pair.relative(m, moved)) for m in pair.mates]) / step

    jacobian = np.array([(all_of(t) - all_of(-t)) / 2 for t in np.eye(6)])
    return 6 - int((np.linalg.svd(jacobian)[1] > 1e-4).sum())


def check_motion(pair, mate, freedom):
    """The mate moves as all mates of the pair allow, in as many ways as they leave."""
    _, dofs = pair.dofs(mate)
    assert np.abs(misfit(mate.ref.type, pair.relative(mate))).max() < 1e-9
    assert sum(3 if dof.kind == "ball" else 1 for dof in dofs) == freedom == freedom_left(pair)
    for _ in range(5):
        moved = pair.displaced(mate, pair.some(mate))
        for other in pair.mates:
            assert np.abs(misfit(other.ref.type, pair.relative(other, moved))).max() < 1e-9, other.title


TURNED = {
    "REVOLUTE REVOLUTE": "on REVOLUTE", "REVOLUTE CYLINDRICAL": "on REVOLUTE",
    "REVOLUTE PIN_SLOT": "on REVOLUTE", "CYLINDRICAL CYLINDRICAL": "on CYLINDRICAL",
    "CYLINDRICAL PARALLEL": "beside CYLINDRICAL", "SLIDER CYLINDRICAL": "on SLIDER",
    "SLIDER SLIDER": "beside SLIDER", "SLIDER PLANAR": "across SLIDER", "PLANAR PLANAR same": "beside PLANAR",
    "PLANAR PARALLEL": "beside PLANAR", "PARALLEL PARALLEL": "beside PARALLEL",
    "BALL REVOLUTE": "under REVOLUTE", "BALL BALL": "anywhere REVOLUTE", "BALL PLANAR": "beside REVOLUTE",
    "BALL CYLINDRICAL": "on REVOLUTE", "BALL PARALLEL": "beside REVOLUTE",
    "CYLINDRICAL PLANAR": "beside REVOLUTE", "CYLINDRICAL CYLINDRICAL beside": "beside SLIDER",
    "CYLINDRICAL PLANAR in it": "across SLIDER", "CYLINDRICAL PARALLEL across": "across SLIDER",
    "PLANAR PLANAR across": "leaning SLIDER", "REVOLUTE REVOLUTE beside": "beside -",
    "REVOLUTE SLIDER": "on -", "BALL SLIDER": "on -", "REVOLUTE REVOLUTE leaning": "tilted -",
}  # fmt: skip
"""Two mates → where the second is to the axis of the first, and the type that they come to (-: rigid)."""

RECIPES = list(TURNED)


def two_mates(recipe, seed):
    """Two mates of a recipe at random places and values, and the type that they come to (None: rigid)."""
    pair = Pair(seed)
    rng = pair.rng
    place = pair.somewhere()
    axis, at, across = place[:3, 2], place[:3, 3], place[:3, 0]
    values = rng.uniform(-2, 2, 4)
    along = at + axis * rng.uniform(-1, 1)
    spin, lean = rng.uniform(-3, 3, 2)
    turned, off = rng.choice([-1, 1]) * axis, at + across * 0.3
    names, (where, kind) = recipe.split()[:2], TURNED[recipe].split()
    second = {
        "on": frame(turned, along, spin),
        "beside": frame(turned, off, spin),
        "across": frame(across, off, spin),
        "leaning": frame(across + lean * axis, off, spin),
        "tilted": frame(axis + 0.01 * across, at),
        "under": frame(axis, at, spin),
        "anywhere": frame(pair.somewhere()[:3, 2], off),
    }[where]
    first = frame(across if names[0] == "BALL" else axis, at)
    if where == "under":
        first = frame(turned, along, spin)
    for name, kind_of, second_frame in zip("ab", names, (first, second), strict=True):
        drawn = [tuple(rng.normal(size=4))] if kind_of == "BALL" else values
        if kind_of == "PIN_SLOT":  # the pin stands on the axis, wherever the slot has it
            second_frame = second_frame @ from_parts(np.eye(3), -values[0] * X)
        pair.mate(name, kind_of, second_frame, *drawn, first=ONE if rng.random() < 0.5 else OTHER)
    return pair, None if kind == "-" else kind


def freedom_of(kind):
    return sum(3 if freedom.kind == "ball" else 1 for freedom in freedoms_of(kind))


@pytest.mark.parametrize("recipe", RECIPES)
@settings(max_examples=8)
@given(seed=st.integers(0, 2**32 - 1))
def test_two_mates_move_as_both_allow(recipe, seed):
    pair, kind = two_mates(recipe, seed)
    made, codes = pair.combined()
    if kind is None:
        assert (made.mates, codes) == ((), ["W-MATES-RIGID"])
        assert {frozenset(weld) for weld in made.welds} == {frozenset((ONE, OTHER))}
        assert freedom_left(pair) == 0
        return
    (mate,) = made.mates
    assert (made.welds, codes, mate.ref.type) == ((), ["I-COMPOSED"], kind)
    check_motion(pair, mate, freedom_of(kind))


def shift(*xyz):
    return from_parts(np.eye(3), np.array(xyz))


def value(pair, mate, suffix="", displaced=None):
    dof = next(dof for dof in pair.dofs(mate)[1] if dof.name == suffix)
    return value_in(pair.relative(mate, displaced), dof.kind, dof.axis)


def limits_of(mate):
    return {name: pytest.approx(end, abs=1e-9) for name, end in (mate.limits or {}).items()}


HINGE, LOWER = ("REVOLUTE", frame(Z, (0, 0, 1)), 0.1), ("REVOLUTE", frame(), 0.4)
UPPER = ("REVOLUTE", frame(-Z, (0, 0, 1.2)), 0.1)
PARALLEL = ("PARALLEL", frame(Z, (1, 0, 0)), 0.1, 0.2, 0.3, 0.4)
SLOT, PLANE = ("PIN_SLOT", frame(), 0.2, 0.3), ("PLANAR", frame(-Z, (1, 1, 0)), 0.1, 0.2, 0.3)
SLOT_BESIDE = ("PIN_SLOT", frame() @ shift(0.5, 0, 0), -0.3, 0.3)


@pytest.mark.parametrize(
    ("mates", "joint"),
    [
        ({"Lower": LOWER, "A upper": UPPER}, "A upper"),
        ({"a": PARALLEL, "b": ("CYLINDRICAL", frame(), 0.1, 0.2), "c": HINGE}, "c"),
        ({"b": SLOT, "a": PLANE, "c": SLOT_BESIDE}, "b"),
    ],
    ids=["the first by name", "the most constrained", "a pin where a plane allows the same"],
)
def test_the_most_constrained_and_first_mate_is_the_joint(mates, joint):
    pair = Pair()
    drawn = {name: pair.mate(name, *mate) for name, mate in mates.items()}
    assert pair.only() is drawn[joint]


def test_two_balls_turn_about_the_line_through_them():
    pair = Pair()
    pair.mate("a", "BALL", frame(Z, (0, 0, 0), 0.7), (1, 0, 0, 0.3))
    pair.mate("b", "BALL", frame(X, (0, 0, 2)), (1, 0.5, -1, 0))
    made = pair.only()
    assert (made.title, made.ref) == ("a", replace(pair.mates[0].ref, type="REVOLUTE"))
    assert np.allclose(pair.assembly.world_from(made.entities[1])[:3, 2], Z)
    angle = 2 * math.atan2(0.3, 1)
    assert value(pair, made) == pytest.approx(angle)
    assert value(pair, made, "", pair.displaced(made, {"": 2.0})) == pytest.approx(2.0)


@pytest.mark.parametrize(
    ("first", "second", "kind", "suffix", "values"),
    [
        (
            ("a", "BALL", frame(X, (0.1, 0.2, 0.3)), (1, 2, 3, 4)),
            ("b", "PLANAR", frame(-Z, (0.5, 0, 0), 0.3), 0.2, 0.1, 1.1),
            *("REVOLUTE", "_turn", (-2.0, 0.0, 1.1, 3.0)),
        ),
        (
            ("a", "PLANAR", frame(X, (0, 0, 1), 0.2), 0.1, 0.2, 0.3),
            ("b", "CYLINDRICAL", frame(-Z), 0.7, 0.4),
            *("SLIDER", "_slide", (-1.0, 0.0, 0.7)),
        ),
    ],
)
def test_a_new_coordinate_counts_as_that_of_the_mate_that_has_it(first, second, kind, suffix, values):
    pair = Pair()
    pair.mate(*first)
    owner = pair.mate(*second)
    made = pair.only()
    assert (made.title, made.ref.type) == ("b", kind)
    for amount in values:
        assert value(pair, owner, suffix, pair.displaced(made, {"": amount})) == pytest.approx(amount)
    if kind == "REVOLUTE":
        assert np.allclose(pair.assembly.world_from(made.entities[0])[:2, 3], (0.1, 0.2))


def test_a_slide_along_no_axis_counts_in_the_first_mate():
    pair = Pair()
    across = np.array([1.0, 0.0, 2.0]) / math.sqrt(5)
    planar = pair.mate("a", "PLANAR", frame(Y, (0, 0, 1)), 0.3, -0.2, 0.3)
    pair.mate("b", "PLANAR", frame(np.cross(across, Y), spin=0.5), 0.1, 0.1, 0.4)
    made = pair.only()
    assert (made.title, made.ref.type) == ("a", "SLIDER")
    second = pair.assembly.world_from(planar.entities[1])[:3, :3]
    direction = second.T @ pair.assembly.world_from(made.entities[1])[:3, 2]
    assert abs(direction @ second.T @ across) == pytest.approx(1.0)
    moved = pair.displaced(made, {"": 0.9})
    assert pair.relative(planar, moved)[:3, 3] @ direction == pytest.approx(0.9)


def many():
    """A door of three hinges with a ball and a plane, drawn from either side."""
    pair = Pair(3)
    place = pair.somewhere()
    limits = {"limitAxialZMin": -1.0, "limitAxialZMax": 1.5}
    pair.mate("Hinge", "REVOLUTE", place @ shift(0, 0, 0.1), 0.4, limits=limits)
    pair.mate("Hinge", "CYLINDRICAL", place @ shift(0, 0, 0.9), 0.4, 0.2, first=OTHER)
    pair.mate("Another", "REVOLUTE", place @ frame(-Z), 0.6, limits={"limitAxialZMax": 1.3}, first=OTHER)
    pair.mate("Ball", "BALL", place @ frame(X, (0, 0, 2)), (1, 0, 1, 0))
    pair.mate("Floor", "PLANAR", place @ shift(3, 0, 2), 0.3, 0.2, 0.1)
    return pair


def test_many_mates_are_one_whatever_their_order():
    pair = many()
    mates = list(pair.mates)
    mates[1] = replace(mates[1], ref=replace(mates[1].ref, feature="another id"))
    outcomes = []
    for order in list(permutations(range(5)))[::7]:
        pair.mates = [mates[index] for index in order]
        made, codes = pair.combined()
        outcomes.append(([(m.ref, limits_of(m)) for m in made.mates], dict(made.absorbed), codes))
        assert outcomes[-1] == outcomes[0], order
    assert [mate.title for mate in made.mates] == ["Another"]
    check_motion(pair, made.mates[0], 1)


def test_mates_to_the_origin_are_composed_too():
    pair = Pair()
    for name, at in (("a", (0, 0, 0)), ("b", (0, 0, 1))):
        ball = pair.mate(name, "BALL", frame(X, at), (1, 0, 0.2, 0))
        world = pair.assembly.world_from(ball.entities[1])
        pair.mates[-1] = replace(ball, entities=(ball.entities[0], Entity((), frozen(world))))
    made = pair.only()
    assert (made.ref.type, made.entities[1].path) == ("REVOLUTE", ())
    assert np.allclose(made.entities[1].occurrence_from_frame[:3, 2], Z)


def test_three_slides_hold_rigidly_though_each_two_slide():
    pair = Pair()
    for name, axis in zip("abc", (X, Y, Z + 0.2 * X), strict=True):
        pair.mate(name, "PLANAR", frame(axis), 0.1, 0.2, 0.3)
    made, codes = pair.combined()
    assert (made.mates, codes) == ((), ["W-MATES-RIGID"])
    for pick in combinations(pair.mates, 2):
        assert combine_mates(pick, pair.assembly, BODY_OF, Diagnostics()).mates[0].ref.type == "SLIDER"


@pytest.mark.parametrize("recipe", [name for name in RECIPES if "-" not in TURNED[name]])
def test_mirrored_mates_move_as_their_mirror_images(recipe):
    """Both bodies mirrored at a plane: the same values, and poses that are each other's images."""
    pair, kind = two_mates(recipe, 11)
    image, mirror = Pair(11), np.diag([1.0, -1.0, 1.0, 1.0])
    for path, occurrence in pair.assembly.occurrences.items():
        world = frozen(mirror @ occurrence.world_from_occurrence)
        image.assembly.occurrences[path] = replace(occurrence, world_from_occurrence=world)
    image.mates = pair.mates
    mate, other = pair.only(), image.only()
    assert mate.ref == other.ref
    check_motion(image, other, freedom_of(kind))
    for _ in range(3):
        values = pair.some(mate)
        moved = mirror @ pair.displaced(mate, values) @ mirror
        assert np.allclose(image.displaced(other, values), moved, atol=1e-9)
