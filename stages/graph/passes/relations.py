"""Relations between dofs: q₂ = −k·q₁, or +k·q₁ when reversed, in the mates' own values.

k is the ratio of a GEAR or LINEAR; from a turn to a slide, by RACK_AND_PINION or SCREW, it is L/2π for
a length L a turn, and 2π/L the other way. The sign is measured on recorded gears and taken for the
same in all four; it is always as drawn, or as the user chooses, whatever the saved pose, which gives only
the offset. Related dofs make a tree, in which one dof drives all others.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

from linkwright.stages.graph.mechanism import RelationSpec
from linkwright.stages.graph.passes.limits.joint_limits import unwrapped, with_each_dof
from linkwright.stages.graph.passes.relation_dofs import configured, dof_relations, named
from linkwright.stages.graph.relation_steps import DofRelation, Step, driver_of, steps_of, trees_of, walk
from linkwright.stages.graph.section import RelationSection
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.robot import Dof, DofKind, Link, Relation, Robot, frozen
from linkwright.stages.robot.motion.kinematics import link_poses, saved_configuration
from linkwright.stages.robot.text.globs import as_key

ZERO_OFFSET = 1e-6
"""An offset [rad or m] that the saved pose leaves below this is rounding."""


def with_relations(
    robot: Robot,
    specs: Sequence[RelationSpec],
    log: Diagnostics,
    wanted: Mapping[str, RelationSection] | None = None,
) -> Robot:
    """The robot with its relations, sorted by follower, each to the dof that drives its tree; saved turns
    are the ones that the relations give.

    `wanted`: the key `relations`. Where an offset of the user's is not that of the saved pose, the saved
    pose changes, and the parts with it. The driver is the first dof, by title, that follows nothing; a
    relation that leads towards it is solved for its other dof. E-RELATION for dofs related twice.
    """
    dofs = {dof.name: dof for dof in robot.dofs}
    found = dof_relations(robot, configured(named(robot, specs), wanted or {}, log), log)
    saved = {dof.name: dof.saved for dof in robot.dofs if isinstance(dof.saved, float)}
    relations: list[Relation] = []
    for tree in trees_of(found, log):
        relations += _flattened(_measured_all(tree, dofs, saved, log), driver_of(tree), _complete(tree))
    relations.sort(key=lambda relation: relation.follower)
    _report_limits(relations, dofs, log)
    moved = with_each_dof(robot, lambda dof: replace(dof, saved=saved.get(dof.name, dof.saved)))
    return replace(_with_moved_parts(moved, dofs), relations=tuple(relations))


def _with_moved_parts(robot: Robot, before: Mapping[str, Dof]) -> Robot:
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


def negligible(offset: float, factor: float) -> bool:
    """Whether an offset [rad or m] of q₂ = factor · q₁ is rounding, of q₂ or of q₁."""
    return abs(offset) <= ZERO_OFFSET * max(1.0, abs(factor))


def _measured_all(
    tree: Sequence[DofRelation], dofs: Mapping[str, Dof], saved: dict[str, float], log: Diagnostics
) -> list[Step]:
    """The tree's steps with the offsets of the saved pose; `saved` gets the values that belong to them.

    A pose gives a slide exactly but a turn only up to whole ones: so the values are found from a slide
    outwards where there is one, else from the driver.
    """
    driver = driver_of(tree)
    if _complete(tree):
        steps = list(walk(steps_of(tree), driver))
        for step in steps:
            saved[step.child] = step.factor * saved[step.parent] + step.offset
        return steps
    drawn = {one.name: one for one in tree}
    related = [driver, *(name for one in tree for name in (one.driver, one.follower))]
    start = next((name for name in related if dofs[name].kind == "slide"), driver)
    return [_measured(step, drawn[step.name], dofs, saved, log) for step in walk(steps_of(tree), start)]


def _complete(tree: Sequence[DofRelation]) -> bool:
    """Whether the source gives every offset, so that nothing is measured."""
    return all(one.complete for one in tree)


def _measured(
    step: Step, drawn: DofRelation, dofs: Mapping[str, Dof], saved: dict[str, float], log: Diagnostics
) -> Step:
    """The step with the offset of the saved pose, or with the user's; `saved` gets the child's value."""
    parent, child, kind = saved[step.parent], saved[step.child], dofs[step.child].kind
    found = step
    if drawn.offset is None:
        offset = _rest(child, step.factor * parent, kind)
        found = replace(step, offset=0.0 if negligible(offset, step.factor) else offset)
    value = found.factor * parent + found.offset
    if found.offset and drawn.offset is None:
        # A pose gives a turn up to whole ones only: the offset is the least that its limits allow.
        within = unwrapped(replace(dofs[step.child], saved=value)).saved
        if isinstance(within, float) and within != value:
            found, value = replace(found, offset=found.offset + within - value), within
        fits = negligible(_rest(child, -step.factor * parent, kind), step.factor)
        _report_offset(found, drawn, fits and not drawn.sure, log)
    if kind == "turn":
        child += math.tau * round((value - child) / math.tau)
    if drawn.offset is not None and not negligible(value - child, step.factor):
        moves = f"{step.child!r} moves from its saved {child:.6g} to {value:.6g}"
        text = f"the saved pose does not fulfil its offset of {drawn.offset:.6g}: {moves}"
        log.report("I-RELATION-MOVED", text, drawn.title)
        child = value
    saved[step.child] = child
    return found


def _report_offset(found: Step, drawn: DofRelation, opposite: bool, log: Diagnostics) -> None:
    """Reports an offset in the saved pose; `opposite`: there would be none in the other direction."""
    offset = (found if found.child == drawn.follower else found.inverted()).offset
    name = as_key(drawn.name)
    keep = f"relations: {{{name}: {{offset: {offset:.12g}}}}}"
    text = f"the saved pose has an offset of {offset:.6g} in this relation"
    if opposite:
        log.report(
            "W-RELATION-SIGN",
            f"{text} as it is drawn, which is kept; in the opposite direction the offset would be 0",
            drawn.title,
            f"if it moves in the opposite direction, relations: {{{name}: {{invert: true}}}}; if not, {keep}",
        )
        return
    hint = f"if no offset is meant, move the two joints in Onshape; if it is meant, {keep}"
    log.report("W-RELATION-OFFSET", f"{text}, which is kept", drawn.title, hint)


def _rest(child: float, given: float, kind: DofKind) -> float:
    """The rest of a saved value, without whole turns."""
    return math.remainder(child - given, math.tau) if kind == "turn" else child - given


def _flattened(steps: Sequence[Step], driver: str, exact: bool) -> list[Relation]:
    """Each dof of a tree as a follower of its driver: the steps on the way, composed. Unless they are
    `exact`, a small offset is rounding."""
    whole = {driver: (1.0, 0.0)}
    relations = []
    for step in walk(steps, driver):
        factor, offset = whole[step.parent]
        factor, offset = step.factor * factor, step.factor * offset + step.offset
        whole[step.child] = factor, 0.0 if not exact and negligible(offset, factor) else offset
        relations.append(Relation(step.name, step.child, driver, *whole[step.child]))
    return relations


def _report_limits(relations: Iterable[Relation], dofs: Mapping[str, Dof], log: Diagnostics) -> None:
    """W-RELATION-LIMIT for a follower whose limits exclude all values that its driver gives it."""
    for one in relations:
        image = dofs[one.driver].limits.mapped(one.multiplier, one.offset).interval
        low, high = dofs[one.follower].limits.interval
        if image[0] > high or image[1] < low:
            text = (
                f"its driver {one.driver!r} moves it through [{image[0]:.6g}, {image[1]:.6g}], "
                f"all outside its own limits [{low:.6g}, {high:.6g}]"
            )
            log.report("W-RELATION-LIMIT", text, one.follower, "correct the limits of one of the two")
