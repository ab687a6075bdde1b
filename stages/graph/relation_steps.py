"""Groups relations between dofs into trees of steps, in each of which one dof drives all others."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from heapq import heappop, heappush

import networkx as nx

from linkwright.stages.graph.mechanism import RelationSpec
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.robot import Value
from linkwright.stages.robot.text.globs import yaml_key


@dataclass(frozen=True, slots=True)
class DofRelation:
    """A relation between dofs, by their names: `follower` = factor · `driver` + offset."""

    title: str
    driver: str
    follower: str
    factor: float
    offset: float | None = None
    """Offset [rad or m]; None for the offset at the saved pose."""
    name: str = ""
    complete: bool = False
    """Whether the source gives factor and offset, so that no saved pose is needed."""
    is_direction_chosen: bool = False
    """Whether the user chose the direction."""


@dataclass(frozen=True, slots=True)
class Step:
    """A step from a dof to the next in its tree: `child` = factor · `parent` + offset."""

    name: str
    parent: str
    child: str
    factor: float
    offset: float = 0.0

    def inverted(self) -> "Step":
        """Returns the same step, solved for the parent."""
        return Step(self.name, self.child, self.parent, 1 / self.factor, 0.0 - self.offset / self.factor)


def trees_of(relations: Sequence[DofRelation], log: Diagnostics) -> list[list[DofRelation]]:
    """Returns the relations, grouped into trees; reports E-RELATION for a relation between dofs that are
    related already."""
    forest = nx.utils.UnionFind()
    tree_relations = []
    for relation in relations:
        if forest[relation.driver] == forest[relation.follower]:
            text = f"the joints {relation.driver!r} and {relation.follower!r} are related already"
            hint = (
                f"remove the redundant relation, or relations: {{{yaml_key(relation.name)}: {{drop: true}}}}"
            )
            log.report("E-RELATION", text, relation.title, hint)
            continue
        forest.union(relation.driver, relation.follower)
        tree_relations.append(relation)
    trees: dict[str, list[DofRelation]] = {}
    for relation in tree_relations:
        trees.setdefault(forest[relation.driver], []).append(relation)
    return list(trees.values())


def driver_of(tree: Sequence[DofRelation]) -> str:
    """Returns the first dof that follows no other dof. There is one, since a tree has fewer relations than
    dofs."""
    followers = {relation.follower for relation in tree}
    return next(relation.driver for relation in tree if relation.driver not in followers)


def steps_of(tree: Sequence[DofRelation]) -> list[Step]:
    """Returns the relations as steps; an offset that is not known yet is 0."""
    return [
        Step(relation.name, relation.driver, relation.follower, relation.factor, relation.offset or 0.0)
        for relation in tree
    ]


def walk(steps: Sequence[Step], start: str) -> Iterator[Step]:
    """Yields every step of a tree, in the direction away from `start`, a parent's step before its
    children's."""
    indices_of: dict[str, list[int]] = {}
    for number, step in enumerate(steps):
        indices_of.setdefault(step.parent, []).append(number)
        indices_of.setdefault(step.child, []).append(number)
    reached, ready = {start}, indices_of[start]
    while ready:
        step = steps[heappop(ready)]
        step_away = step if step.parent in reached else step.inverted()
        if step_away.child in reached:
            continue  # the step by which this dof was reached, from its other end
        reached.add(step_away.child)
        yield step_away
        for number in indices_of[step_away.child]:
            heappush(ready, number)


def _pair(spec: RelationSpec) -> tuple[str, str]:
    driver, follower = spec.connections
    return driver, follower


def followed_values(specs: Iterable[RelationSpec], saved: Mapping[str, Value]) -> dict[str, float]:
    """Returns the values of all scalar dofs, with followers as their drivers' values in `saved` give them.
    The relations must be complete (MIMIC); the result equals that of `with_relations`.
    """
    ordered = sorted(specs, key=lambda spec: (spec.title, spec.connections))
    relations = [
        DofRelation(spec.title, *_pair(spec), spec.ratio, spec.offset, complete=True) for spec in ordered
    ]
    values = {name: value for name, value in saved.items() if isinstance(value, float)}
    for tree in trees_of(
        [relation for relation in relations if relation.driver != relation.follower], Diagnostics()
    ):
        for step in walk(steps_of(tree), driver_of(tree)):
            values[step.child] = step.factor * values[step.parent] + step.offset
    return values
