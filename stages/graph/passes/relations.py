"""Relations between dofs: q₂ = −k·q₁, or +k·q₁ when reversed, in the mates' own values.

k is the ratio of a GEAR or LINEAR; from a turn to a slide, by RACK_AND_PINION or SCREW, it is L/2π for
a length L a turn, and 2π/L the other way. The sign is measured on recorded gears and taken for the
same in all four; it is always as drawn, or as the user says, whatever the saved pose, which gives only the
offset. What is related hangs together as a tree, of which one dof drives all others.
"""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from heapq import heappop, heappush

import networkx as nx

from stages.graph.globs import as_key
from stages.graph.keys import RelationKeys
from stages.graph.mechanism import RelationSpec
from stages.graph.passes.joint_limits import unwrapped, with_each_dof
from stages.graph.passes.relation_dofs import DofRelation, dof_relations, named, settled
from stages.robot.diagnostics import Diagnostics
from stages.robot.kinematics import link_poses, saved_configuration
from stages.robot.model import Dof, DofKind, Link, Relation, Robot, Value, frozen

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


def with_relations(
    robot: Robot,
    specs: Sequence[RelationSpec],
    log: Diagnostics,
    wanted: Mapping[str, RelationKeys] | None = None,
) -> Robot:
    """The robot with its specs as relations, sorted by follower, each to the dof that drives its tree;
    saved turns are the ones that the relations give.

    `wanted`: what `relations:` says of them. Where an offset of the user's is not that of the saved pose,
    the pose is another, and its parts are where that has them. The driver is the first, by title, that
    follows nothing; a spec that names dofs the wrong way round for that is solved for the other. Dofs that
    are related twice are an error (E-RELATION).
    """
    dofs = {dof.name: dof for dof in robot.dofs}
    found = dof_relations(robot, settled(named(robot, specs), wanted or {}, log), log)
    saved = {dof.name: dof.saved for dof in robot.dofs if isinstance(dof.saved, float)}
    relations: list[Relation] = []
    for tree in _trees(found, log):
        relations += _flattened(_measured_all(tree, dofs, saved, log), _driver(tree), _said(tree))
    relations.sort(key=lambda relation: relation.follower)
    _tell_limits(relations, dofs, log)
    moved = with_each_dof(robot, lambda dof: replace(dof, saved=saved.get(dof.name, dof.saved)))
    return replace(_posed(moved, dofs), relations=tuple(relations))


def _posed(robot: Robot, before: Mapping[str, Dof]) -> Robot:
    """The robot with its parts where its saved values have them, if those are others than `before`."""

    def changed(dof: Dof) -> bool:
        old, new = before[dof.name].saved, dof.saved
        if not (isinstance(old, float) and isinstance(new, float)):
            return False
        return abs(_rest(new, old, dof.kind)) > ZERO_OFFSET

    if not any(map(changed, robot.dofs)):
        return robot
    poses = link_poses(robot, saved_configuration(robot))
    links: list[Link] = []
    for link in robot.links:
        pose = robot.world_from_root @ poses[link.name]
        parts = (replace(one, world_from_part=frozen(pose @ one.link_from_part)) for one in link.parts)
        links.append(replace(link, parts=tuple(parts)))
    return replace(robot, links=tuple(links))


def said_values(specs: Iterable[RelationSpec], saved: Mapping[str, Value]) -> dict[str, float]:
    """The values that dofs have by specs that say all (MIMIC), where what drives them is as `saved`: what
    `with_relations` makes of them."""
    ordered = sorted(specs, key=lambda spec: (spec.title, spec.connections))
    found = [
        DofRelation(b.title, b.connections[0], b.connections[1], b.ratio, b.offset, said=True)
        for b in ordered
    ]
    values = {name: value for name, value in saved.items() if isinstance(value, float)}
    for tree in _trees([one for one in found if one.driver != one.follower], Diagnostics()):
        steps = [Step(one.title, one.driver, one.follower, one.factor, one.offset or 0.0) for one in tree]
        for step in _walk(steps, _driver(tree)):
            _told(step, values)
    return values


def negligible(offset: float, factor: float) -> bool:
    """Whether an offset [rad or m] of q₂ = factor · q₁ is rounding, of q₂ or of q₁."""
    return abs(offset) <= ZERO_OFFSET * max(1.0, abs(factor))


def _trees(found: Sequence[DofRelation], log: Diagnostics) -> list[list[DofRelation]]:
    """What hangs together; a spec between dofs that do already says too much."""
    forest = nx.utils.UnionFind()
    kept = []
    for one in found:
        if forest[one.driver] == forest[one.follower]:
            text = f"the joints {one.driver!r} and {one.follower!r} are related already"
            hint = f"remove the one that says too much, or relations: {{{as_key(one.name)}: {{drop: true}}}}"
            log.report("E-RELATION", text, one.title, hint)
            continue
        forest.union(one.driver, one.follower)
        kept.append(one)
    trees: dict[str, list[DofRelation]] = {}
    for one in kept:
        trees.setdefault(forest[one.driver], []).append(one)
    return list(trees.values())


def _driver(tree: Sequence[DofRelation]) -> str:
    """The first dof that follows nothing: there is one, as the specs are one fewer than the dofs."""
    followers = {one.follower for one in tree}
    return next(one.driver for one in tree if one.driver not in followers)


def _measured_all(
    tree: Sequence[DofRelation], dofs: Mapping[str, Dof], saved: dict[str, float], log: Diagnostics
) -> list[Step]:
    """The tree's steps with their offsets as the saved pose has them; `saved` is put in order.

    A pose tells a slide exactly but a turn only up to whole ones: so the values are settled from a slide
    outwards where there is one, else from the driver.
    """
    driver = _driver(tree)
    drawn = {one.name: one for one in tree}
    steps = [Step(one.name, one.driver, one.follower, one.factor, one.offset or 0.0) for one in tree]
    if _said(tree):
        return [_told(step, saved) for step in _walk(steps, driver)]
    related = [driver, *(name for one in tree for name in (one.driver, one.follower))]
    start = next((name for name in related if dofs[name].kind == "slide"), driver)
    return [_measured(step, drawn[step.name], dofs, saved, log) for step in _walk(steps, start)]


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


def _said(tree: Sequence[DofRelation]) -> bool:
    """Whether the source says it all, so that nothing is measured."""
    return all(one.said for one in tree)


def _told(step: Step, saved: dict[str, float]) -> Step:
    """The step as its source says it, its child's saved value the one that it gives."""
    saved[step.child] = step.factor * saved[step.parent] + step.offset
    return step


def _measured(
    step: Step, drawn: DofRelation, dofs: Mapping[str, Dof], saved: dict[str, float], log: Diagnostics
) -> Step:
    """The step as the saved pose has it, its child's saved turn the one that it gives; with an offset of
    the user's, as they have it, and the child where it then is."""
    parent, child, kind = saved[step.parent], saved[step.child], dofs[step.child].kind
    found = step
    if drawn.offset is None:
        offset = _rest(child, step.factor * parent, kind)
        found = replace(step, offset=0.0 if negligible(offset, step.factor) else offset)
    value = found.factor * parent + found.offset
    if found.offset and drawn.offset is None:
        # A pose tells a turn up to whole ones only: the offset is the least that its limits allow.
        within = unwrapped(replace(dofs[step.child], saved=value)).saved
        if isinstance(within, float) and within != value:
            found, value = replace(found, offset=found.offset + within - value), within
        fits = negligible(_rest(child, -step.factor * parent, kind), step.factor)
        _tell_offset(found, drawn, fits and not drawn.sure, log)
    if kind == "turn":
        child += math.tau * round((value - child) / math.tau)
    if drawn.offset is not None and not negligible(value - child, step.factor):
        moves = f"{step.child!r} moves from its saved {child:.6g} to {value:.6g}"
        text = f"the saved pose does not have its offset of {drawn.offset:.6g}: {moves}"
        log.report("I-RELATION-MOVED", text, drawn.title)
        child = value
    saved[step.child] = child
    return found


def _tell_offset(found: Step, drawn: DofRelation, opposite: bool, log: Diagnostics) -> None:
    """That the saved pose has an offset; `opposite`: it would have none in the other direction."""
    offset = (found if found.child == drawn.follower else found.turned_round()).offset
    name = as_key(drawn.name)
    keep = f"relations: {{{name}: {{offset: {offset:.12g}}}}}"
    text = f"the saved pose has an offset of {offset:.6g} in this relation"
    if opposite:
        log.report(
            "W-RELATION-SIGN",
            f"{text} as it is drawn, which is kept; in the opposite direction it would have none",
            drawn.title,
            f"if it goes the other way, relations: {{{name}: {{invert: true}}}}; if not, {keep}",
        )
        return
    hint = f"if none is meant, move the two in Onshape to where it has none; if it is, {keep}"
    log.report("W-RELATION-OFFSET", f"{text}, which is kept", drawn.title, hint)


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


def _tell_limits(relations: Iterable[Relation], dofs: Mapping[str, Dof], log: Diagnostics) -> None:
    """A follower whose limits hold no value that its driver gives it."""
    for one in relations:
        image = sorted(one.multiplier * end + one.offset for end in dofs[one.driver].limits.interval)
        low, high = dofs[one.follower].limits.interval
        if image[0] > high or image[1] < low:
            text = (
                f"its driver {one.driver!r} takes it through [{image[0]:.6g}, {image[1]:.6g}], "
                f"all outside its own limits [{low:.6g}, {high:.6g}]"
            )
            log.report("W-RELATION-LIMIT", text, one.follower, "mend the limits of one of the two")
