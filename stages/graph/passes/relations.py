"""Adds relations between dofs: q₂ = −k·q₁, or +k·q₁ when reversed, in the mates' own values.

k is the ratio of a GEAR or LINEAR; from a turn to a slide, by RACK_AND_PINION or SCREW, it is L/2π for a
length L for each turn, and 2π/L from a slide to a turn. The sign was measured on recorded gears and is
assumed to be the same for all four types. The sign is always as in CAD, or as the user chooses: the saved
pose gives only the offset. Related dofs are a tree, in which one dof drives all others.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

from linkwright.stages.graph.mechanism import RelationSpec
from linkwright.stages.graph.passes.limits.joint_limits import unwrapped, with_each_dof
from linkwright.stages.graph.passes.relation_dofs import (
    dof_relations,
    with_configured_relations,
    with_relation_names,
)
from linkwright.stages.graph.relation_steps import DofRelation, Step, driver_of, steps_of, trees_of, walk
from linkwright.stages.graph.section import RelationSection
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.robot import Dof, DofKind, Link, Relation, Robot, frozen
from linkwright.stages.robot.motion.kinematics import link_poses, saved_configuration
from linkwright.stages.robot.text.globs import yaml_key

OFFSET_TOLERANCE = 1e-6
"""Largest offset [rad or m] from the saved pose that counts as rounding."""


def with_relations(
    robot: Robot,
    specs: Sequence[RelationSpec],
    log: Diagnostics,
    sections: Mapping[str, RelationSection] | None = None,
) -> Robot:
    """Returns the robot with its relations, sorted by follower, each from the dof that drives its tree; saved
    turns become those that the relations give.

    `sections`: the key `relations`. Where the user's offset differs from that of the saved pose, the saved
    pose changes, and the parts with it. The driver is the first dof, by title, that follows nothing; a
    relation that leads towards it is solved for its other dof. Reports E-RELATION for dofs related twice.
    """
    dofs = {dof.name: dof for dof in robot.dofs}
    dof_links = dof_relations(
        robot, with_configured_relations(with_relation_names(robot, specs), sections or {}, log), log
    )
    saved = {dof.name: dof.saved for dof in robot.dofs if isinstance(dof.saved, float)}
    relations: list[Relation] = []
    for tree in trees_of(dof_links, log):
        relations += _driver_relations(
            _measure_all(tree, dofs, saved, log), driver_of(tree), _is_complete(tree)
        )
    relations.sort(key=lambda relation: relation.follower)
    _report_limits(relations, dofs, log)
    robot_at_saved = with_each_dof(robot, lambda dof: replace(dof, saved=saved.get(dof.name, dof.saved)))
    return replace(_with_moved_parts(robot_at_saved, dofs), relations=tuple(relations))


def _with_moved_parts(robot: Robot, dofs_before: Mapping[str, Dof]) -> Robot:
    """Moves the parts of a robot to its saved values, if these differ from those of `dofs_before`."""

    def changed(dof: Dof) -> bool:
        old, new = dofs_before[dof.name].saved, dof.saved
        if not (isinstance(old, float) and isinstance(new, float)):
            return False
        return abs(_deviation(new, old, dof.kind)) > OFFSET_TOLERANCE

    if not any(map(changed, robot.dofs)):
        return robot
    poses = link_poses(robot, saved_configuration(robot))
    links: list[Link] = []
    for link in robot.links:
        pose = robot.world_from_root @ poses[link.name]
        parts = (replace(part, world_from_part=frozen(pose @ part.link_from_part)) for part in link.parts)
        links.append(replace(link, parts=tuple(parts)))
    return replace(robot, links=tuple(links))


def is_negligible(offset: float, factor: float) -> bool:
    """Tells whether an offset [rad or m] of q₂ = factor · q₁ is only rounding, of q₂ or of q₁."""
    return abs(offset) <= OFFSET_TOLERANCE * max(1.0, abs(factor))


def _measure_all(
    tree: Sequence[DofRelation], dofs: Mapping[str, Dof], saved: dict[str, float], log: Diagnostics
) -> list[Step]:
    """Returns the tree's steps with the offsets of the saved pose, and writes the values that these steps
    give to `saved`.

    A pose gives a slide exactly but a turn only up to whole turns: so the values are computed outwards from a
    slide if the tree has any, else from the driver.
    """
    driver = driver_of(tree)
    if _is_complete(tree):
        steps = list(walk(steps_of(tree), driver))
        for step in steps:
            saved[step.child] = step.factor * saved[step.parent] + step.offset
        return steps
    relation_of = {relation.name: relation for relation in tree}
    related = [driver, *(name for relation in tree for name in (relation.driver, relation.follower))]
    start = next((name for name in related if dofs[name].kind == "slide"), driver)
    return [_measure(step, relation_of[step.name], dofs, saved, log) for step in walk(steps_of(tree), start)]


def _is_complete(tree: Sequence[DofRelation]) -> bool:
    """Tells whether the source gives every offset, so that nothing is measured."""
    return all(relation.complete for relation in tree)


def _measure(
    step: Step, relation: DofRelation, dofs: Mapping[str, Dof], saved: dict[str, float], log: Diagnostics
) -> Step:
    """Returns the step with the offset of the saved pose, or with the user's; writes the child's value to
    `saved`."""
    parent, child, kind = saved[step.parent], saved[step.child], dofs[step.child].kind
    measured = step
    if relation.offset is None:
        offset = _deviation(child, step.factor * parent, kind)
        measured = replace(step, offset=0.0 if is_negligible(offset, step.factor) else offset)
    value = measured.factor * parent + measured.offset
    if measured.offset and relation.offset is None:
        # A pose gives a turn only up to whole turns: the offset is the least that its limits allow.
        unwrapped_value = unwrapped(replace(dofs[step.child], saved=value)).saved
        if isinstance(unwrapped_value, float) and unwrapped_value != value:
            measured, value = (
                replace(measured, offset=measured.offset + unwrapped_value - value),
                unwrapped_value,
            )
        fits_opposite = is_negligible(_deviation(child, -step.factor * parent, kind), step.factor)
        _report_offset(measured, relation, fits_opposite and not relation.is_direction_chosen, log)
    if kind == "turn":
        child += math.tau * round((value - child) / math.tau)
    if relation.offset is not None and not is_negligible(value - child, step.factor):
        change = f"{step.child!r} moves from its saved {child:.6g} to {value:.6g}"
        text = f"the saved pose does not fulfil its offset of {relation.offset:.6g}: {change}"
        log.report("I-RELATION-MOVED", text, relation.title)
        child = value
    saved[step.child] = child
    return measured


def _report_offset(measured: Step, relation: DofRelation, fits_opposite: bool, log: Diagnostics) -> None:
    """Reports an offset in the saved pose. `fits_opposite`: whether the offset would be 0 in the opposite
    direction."""
    offset = (measured if measured.child == relation.follower else measured.inverted()).offset
    name = yaml_key(relation.name)
    yaml = f"relations: {{{name}: {{offset: {offset:.12g}}}}}"
    text = f"the saved pose has an offset of {offset:.6g} in this relation"
    if fits_opposite:
        log.report(
            "W-RELATION-SIGN",
            f"{text} as it is drawn, which is kept; in the opposite direction the offset would be 0",
            relation.title,
            f"if it moves in the opposite direction, relations: {{{name}: {{invert: true}}}}; if not, {yaml}",
        )
        return
    hint = f"if no offset is meant, move the two joints in Onshape; if it is meant, {yaml}"
    log.report("W-RELATION-OFFSET", f"{text}, which is kept", relation.title, hint)


def _deviation(child: float, expected: float, kind: DofKind) -> float:
    """Returns the difference of a saved value from the expected value, without whole turns."""
    return math.remainder(child - expected, math.tau) if kind == "turn" else child - expected


def _driver_relations(steps: Sequence[Step], driver: str, is_exact: bool) -> list[Relation]:
    """Returns the relation of each dof of a tree to the tree's driver: the steps of its path, composed. A
    small offset counts as rounding unless the steps are exact (`is_exact`)."""
    steps_from_driver = {driver: (1.0, 0.0)}
    relations = []
    for step in walk(steps, driver):
        factor, offset = steps_from_driver[step.parent]
        factor, offset = step.factor * factor, step.factor * offset + step.offset
        steps_from_driver[step.child] = (
            factor,
            0.0 if not is_exact and is_negligible(offset, factor) else offset,
        )
        relations.append(Relation(step.name, step.child, driver, *steps_from_driver[step.child]))
    return relations


def _report_limits(relations: Iterable[Relation], dofs: Mapping[str, Dof], log: Diagnostics) -> None:
    """Reports W-RELATION-LIMIT for a follower whose limits exclude all values that its driver gives it."""
    for relation in relations:
        values = dofs[relation.driver].limits.mapped(relation.multiplier, relation.offset).interval
        low, high = dofs[relation.follower].limits.interval
        if values[0] > high or values[1] < low:
            text = (
                f"its driver {relation.driver!r} moves it through [{values[0]:.6g}, {values[1]:.6g}], "
                f"all outside its own limits [{low:.6g}, {high:.6g}]"
            )
            log.report("W-RELATION-LIMIT", text, relation.follower, "correct the limits of one of the two")
