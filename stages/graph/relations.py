"""Relations between dofs: q₂ = −k·q₁, or +k·q₁ when reversed, in the mates' own values.

k is the ratio of a GEAR or LINEAR; from a turn to a slide, by RACK_AND_PINION or SCREW, it is L/2π for
a length L a turn, and 2π/L the other way. The sign is measured on recorded gears and taken for the
same in all four. What is related hangs together as a tree, of which one dof drives all others.
"""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from heapq import heappop, heappush

import networkx as nx

from stages.graph.bonds import Bonded, bonded
from stages.graph.mechanism import Bond
from stages.graph.notes import Notes
from stages.graph.properties import ends, with_each_dof
from stages.robot.model import Dof, DofKind, Relation, Robot, Value
from stages.robot.names import free, legal

ZERO_OFFSET = 1e-6
"""An offset [rad or m] that the saved pose leaves below this is rounding."""


@dataclass(frozen=True, slots=True)
class Step:
    """From a dof to the next in its tree: `child` = factor · `parent` + offset."""

    name: str
    parent: str
    child: str
    factor: float
    offset: float = 0.0

    def turned_round(self) -> "Step":
        """The same, solved for the parent."""
        return Step(self.name, self.child, self.parent, 1 / self.factor, 0.0 - self.offset / self.factor)


def with_relations(robot: Robot, bonds: Sequence[Bond], notes: Notes) -> Robot:
    """The robot with its bonds as relations, sorted by follower, each to the dof that drives its tree;
    saved turns are the ones that the relations give.

    The driver is the first, by title, that follows nothing; a bond that names dofs the wrong way round
    for that is solved for the other. Dofs that are related twice are an error (E-RELATION).
    """
    dofs = {dof.name: dof for dof in robot.dofs}
    found = bonded(robot, bonds, notes)
    names = _names(robot, found)
    saved = {dof.name: dof.saved for dof in robot.dofs if isinstance(dof.saved, float)}
    relations: list[Relation] = []
    for tree in _trees(found, notes):
        settled = _settled(tree, names, dofs, saved, notes)
        relations += _flattened(settled, _driver(tree), _said(tree))
    relations.sort(key=lambda relation: relation.follower)
    _tell_limits(relations, dofs, notes)
    moved = with_each_dof(robot, lambda dof: replace(dof, saved=saved.get(dof.name, dof.saved)))
    return replace(moved, relations=tuple(relations))


def said_values(bonds: Iterable[Bond], saved: Mapping[str, Value]) -> dict[str, float]:
    """The values that dofs have by bonds that say all (MIMIC), where what drives them is as `saved`: what
    `with_relations` makes of them."""
    ordered = sorted(bonds, key=lambda bond: (bond.title, bond.couplings))
    found = [Bonded(one.title, one.couplings[0], one.couplings[1], one.ratio, one.offset) for one in ordered]
    values = {name: value for name, value in saved.items() if isinstance(value, float)}
    for tree in _trees([one for one in found if one.driver != one.follower], Notes()):
        steps = [Step(one.title, one.driver, one.follower, one.factor, one.offset or 0.0) for one in tree]
        for step in _walk(steps, _driver(tree)):
            _told(step, values)
    return values


def negligible(offset: float, factor: float) -> bool:
    """Whether an offset [rad or m] of q₂ = factor · q₁ is rounding, of q₂ or of q₁."""
    return abs(offset) <= ZERO_OFFSET * max(1.0, abs(factor))


def _trees(found: Sequence[Bonded], notes: Notes) -> list[list[Bonded]]:
    """What hangs together; a bond between dofs that do already says too much."""
    forest = nx.utils.UnionFind()
    kept = []
    for one in found:
        if forest[one.driver] == forest[one.follower]:
            text = f"the joints {one.driver!r} and {one.follower!r} are related already"
            notes.tell("E-RELATION", text, one.title, "remove the relation that says too much")
            continue
        forest.union(one.driver, one.follower)
        kept.append(one)
    trees: dict[str, list[Bonded]] = {}
    for one in kept:
        trees.setdefault(forest[one.driver], []).append(one)
    return list(trees.values())


def _names(robot: Robot, found: Iterable[Bonded]) -> dict[Bonded, str]:
    """A name for each bond: its own, else a free one from its title."""
    taken = {joint.name for joint in robot.joints} | {loop.name for loop in robot.loops}
    taken |= {dof.name for dof in robot.dofs}
    names: dict[Bonded, str] = {}
    for one in found:
        names[one] = one.name or free(legal(one.title.rsplit("/", 1)[-1]) or "relation", taken)
        taken.add(names[one])
    return names


def _driver(tree: Sequence[Bonded]) -> str:
    """The first dof that follows nothing: there is one, as the bonds are one fewer than the dofs."""
    followers = {one.follower for one in tree}
    return next(one.driver for one in tree if one.driver not in followers)


def _settled(
    tree: Sequence[Bonded],
    names: Mapping[Bonded, str],
    dofs: Mapping[str, Dof],
    saved: dict[str, float],
    notes: Notes,
) -> list[Step]:
    """The tree's steps with sign and offset as the saved pose has them; `saved` is put in order.

    A pose tells a slide exactly but a turn only up to whole ones: so the values are settled from a slide
    outwards where there is one, else from the driver.
    """
    driver = _driver(tree)
    drawn = {names[one]: one for one in tree}
    steps = [Step(names[one], one.driver, one.follower, one.factor, one.offset or 0.0) for one in tree]
    if _said(tree):
        return [_told(step, saved) for step in _walk(steps, driver)]
    related = [driver, *(name for one in tree for name in (one.driver, one.follower))]
    start = next((name for name in related if dofs[name].kind == "slide"), driver)
    return [_measured(step, drawn[step.name], dofs, saved, notes) for step in _walk(steps, start)]


def _walk(steps: Sequence[Step], start: str) -> Iterator[Step]:
    """Every step of a tree, turned to lead away from `start`, a parent's before its children's."""
    at: dict[str, list[int]] = {}
    for number, step in enumerate(steps):
        at.setdefault(step.parent, []).append(number)
        at.setdefault(step.child, []).append(number)
    reached, ready = {start}, at[start]
    while ready:
        step = steps[heappop(ready)]
        away = step if step.parent in reached else step.turned_round()
        if away.child in reached:
            continue  # the step that led here, seen from its other end
        reached.add(away.child)
        yield away
        for number in at[away.child]:
            heappush(ready, number)


def _said(tree: Sequence[Bonded]) -> bool:
    """Whether the source says it all, so that nothing is measured."""
    return all(one.offset is not None for one in tree)


def _told(step: Step, saved: dict[str, float]) -> Step:
    """The step as its source says it, its child's saved value the one that it gives."""
    saved[step.child] = step.factor * saved[step.parent] + step.offset
    return step


def _measured(
    step: Step, drawn: Bonded, dofs: Mapping[str, Dof], saved: dict[str, float], notes: Notes
) -> Step:
    """The step as the saved pose has it, its child's saved turn the one that it gives."""
    parent, child = saved[step.parent], saved[step.child]
    kind = dofs[step.child].kind
    factor, offset = step.factor, _rest(child, step.factor * parent, kind)
    if negligible(offset, factor):
        offset = 0.0
    elif negligible(_rest(child, -factor * parent, kind), factor):
        text = "the saved pose fits the opposite direction, which is believed"
        notes.tell("I-RELATION-SIGN", text, drawn.title)
        factor, offset = -factor, 0.0
    found = replace(step, factor=factor, offset=offset)
    if offset:
        told = found if step.child == drawn.follower else found.turned_round()
        text = f"the saved pose has an offset of {told.offset:.6g} in this relation, which is kept"
        hint = "if none is meant, move the two in Onshape to where the relation has none, and build again"
        notes.tell("W-RELATION-OFFSET", text, drawn.title, hint)
    if kind == "turn":
        saved[step.child] = child + math.tau * round((factor * parent + offset - child) / math.tau)
    return found


def _rest(child: float, given: float, kind: DofKind) -> float:
    """What is left of a saved value, whole turns taken off."""
    return math.remainder(child - given, math.tau) if kind == "turn" else child - given


def _flattened(steps: Sequence[Step], driver: str, exact: bool) -> list[Relation]:
    """Each dof of a tree as following its driver: the steps on the way, one put into the next. Unless
    they are `exact`, what is left of an offset may be rounding."""
    whole = {driver: (1.0, 0.0)}
    relations = []
    for step in _walk(steps, driver):
        factor, offset = whole[step.parent]
        factor, offset = step.factor * factor, step.factor * offset + step.offset
        whole[step.child] = factor, 0.0 if not exact and negligible(offset, factor) else offset
        relations.append(Relation(step.name, step.child, driver, *whole[step.child]))
    return relations


def _tell_limits(relations: Iterable[Relation], dofs: Mapping[str, Dof], notes: Notes) -> None:
    """A follower whose limits hold no value that its driver gives it."""
    for one in relations:
        image = sorted(one.multiplier * end + one.offset for end in ends(dofs[one.driver].limits))
        low, high = ends(dofs[one.follower].limits)
        if image[0] > high or image[1] < low:
            text = (
                f"its driver {one.driver!r} takes it through [{image[0]:.6g}, {image[1]:.6g}], "
                f"all outside its own limits [{low:.6g}, {high:.6g}]"
            )
            notes.tell("W-RELATION-LIMIT", text, one.follower, "mend the limits of one of the two")
