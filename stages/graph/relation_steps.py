"""Relations between dofs as trees of steps, in each of which one dof drives all others."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from heapq import heappop, heappush

import networkx as nx

from linkwright.stages.graph.mechanism import RelationSpec
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.robot import Value
from linkwright.stages.robot.text.globs import as_key


@dataclass(frozen=True, slots=True)
class DofRelation:
    """`follower` = factor · `driver` + offset, names of dofs; an offset of None is that of the saved pose.

    `complete`: the source gives all of it, and has no pose of its own. `sure`: the user chose the direction.
    """

    title: str
    driver: str
    follower: str
    factor: float
    offset: float | None = None
    name: str = ""
    complete: bool = False
    sure: bool = False


@dataclass(frozen=True, slots=True)
class Step:
    """From a dof to the next in its tree: `child` = factor · `parent` + offset."""

    name: str
    parent: str
    child: str
    factor: float
    offset: float = 0.0

    def inverted(self) -> "Step":
        """The same, solved for the parent."""
        return Step(self.name, self.child, self.parent, 1 / self.factor, 0.0 - self.offset / self.factor)


def trees_of(found: Sequence[DofRelation], log: Diagnostics) -> list[list[DofRelation]]:
    """The relations that belong together; E-RELATION for one between dofs that are related already."""
    forest = nx.utils.UnionFind()
    kept = []
    for one in found:
        if forest[one.driver] == forest[one.follower]:
            text = f"the joints {one.driver!r} and {one.follower!r} are related already"
            hint = f"remove the redundant relation, or relations: {{{as_key(one.name)}: {{drop: true}}}}"
            log.report("E-RELATION", text, one.title, hint)
            continue
        forest.union(one.driver, one.follower)
        kept.append(one)
    trees: dict[str, list[DofRelation]] = {}
    for one in kept:
        trees.setdefault(forest[one.driver], []).append(one)
    return list(trees.values())


def driver_of(tree: Sequence[DofRelation]) -> str:
    """The first dof that follows nothing: there is one, as there is one relation fewer than dofs."""
    followers = {one.follower for one in tree}
    return next(one.driver for one in tree if one.driver not in followers)


def steps_of(tree: Sequence[DofRelation]) -> list[Step]:
    """The relations as steps; an offset that is not known yet is 0."""
    return [Step(one.name, one.driver, one.follower, one.factor, one.offset or 0.0) for one in tree]


def walk(steps: Sequence[Step], start: str) -> Iterator[Step]:
    """Every step of a tree, turned to lead away from `start`, a parent's before its children's."""
    at: dict[str, list[int]] = {}
    for number, step in enumerate(steps):
        at.setdefault(step.parent, []).append(number)
        at.setdefault(step.child, []).append(number)
    reached, ready = {start}, at[start]
    while ready:
        step = steps[heappop(ready)]
        away = step if step.parent in reached else step.inverted()
        if away.child in reached:
            continue  # the step that led here, seen from its other end
        reached.add(away.child)
        yield away
        for number in at[away.child]:
            heappush(ready, number)


def _pair(spec: RelationSpec) -> tuple[str, str]:
    driver, follower = spec.connections
    return driver, follower


def followed_values(specs: Iterable[RelationSpec], saved: Mapping[str, Value]) -> dict[str, float]:
    """The values of scalar dofs where those that drive others are as `saved`.

    Of relations that are complete (MIMIC); the same values as those that the pass over relations gives.
    """
    ordered = sorted(specs, key=lambda spec: (spec.title, spec.connections))
    found = [
        DofRelation(spec.title, *_pair(spec), spec.ratio, spec.offset, complete=True) for spec in ordered
    ]
    values = {name: value for name, value in saved.items() if isinstance(value, float)}
    for tree in trees_of([one for one in found if one.driver != one.follower], Diagnostics()):
        for step in walk(steps_of(tree), driver_of(tree)):
            values[step.child] = step.factor * values[step.parent] + step.offset
    return values
