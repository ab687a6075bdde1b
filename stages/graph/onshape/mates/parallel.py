"""Combines several mates between the same two bodies into one mate or a weld.

Onshape's mates are constraints, so two bodies move only as every mate between them allows. That is the motion
of one of these mates (the second hinge of a door, a CYLINDRICAL beside a REVOLUTE), or an intersection of
their motions: a turn (two BALLs, a PLANAR across a CYLINDRICAL), a slide (two PLANARs), or no motion. The
only other intersections are shifts in any direction of a plane or of space, which no mate describes: such
mates stay as they are.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from linkwright.stages.graph.onshape.assembly import Assembly, Entity, Mate, Path
from linkwright.stages.graph.onshape.mates.combined_limits import (
    POSE_TOLERANCE,
    LimitLost,
    narrow_limits,
    with_dof_limits,
)
from linkwright.stages.graph.onshape.mates.coordinates import coordinate_couplings, coordinates
from linkwright.stages.graph.onshape.mates.joints import JOINT_TYPES
from linkwright.stages.graph.onshape.mates.twists import (
    ANGLE_TOLERANCE,
    MateView,
    extent,
    intersection,
    is_within,
    span,
    twist_columns,
    view,
)
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.poses import inverse
from linkwright.stages.robot.model.robot import Array, frozen

RIGID_CODE = "W-MATES-RIGID"

MateKey = tuple[Path, str, str]


@dataclass(frozen=True, slots=True)
class Absorbed:
    """A mate that another mate replaces."""

    by: MateKey
    """Key of the other mate."""
    dofs: Mapping[str, tuple[str, float]]
    """Suffix of a dof of this mate → the suffix of the other mate's dof that moves it, and the ratio of the
    change of this dof to that of the other."""

    @property
    def sign(self) -> int:
        """1 or -1 if all dofs change as those of the other mate do, or as their opposites; else 0."""
        factors = {factor for _, factor in self.dofs.values()}
        return int(factors.pop()) if factors in ({1.0}, {-1.0}) else 0


@dataclass(frozen=True, slots=True)
class CombinedMates:
    """The result of combining the mates between two bodies."""

    mates: tuple[Mate, ...]
    """A single mate for each two bodies, if a mate can describe their motion."""
    welds: tuple[tuple[Path, Path], ...]
    """Pairs of occurrences that their mates hold rigidly; those mates are removed."""
    absorbed: Mapping[MateKey, Absorbed]
    """Key of each mate that another mate replaces → how the other mate moves it."""


@dataclass(slots=True)
class _Work:
    assembly: Assembly
    log: Diagnostics
    mates: list[Mate]
    welds: list[tuple[Path, Path]]
    absorbed: dict[MateKey, Absorbed]


def combine_mates(
    mates: Sequence[Mate], assembly: Assembly, body_of: Mapping[Path, int], log: Diagnostics
) -> CombinedMates:
    """Combines the mates between different bodies, two bodies at a time.

    `body_of`: occurrence path → body. Mates of one body, or of an unknown type, are passed on. The result
    does not depend on the order of `mates`, nor on which entity of a mate is the first. Where there are
    welds, only these are reported: they change the bodies, and this function is called again.
    """
    work = _Work(assembly, Diagnostics(), [], [], {})
    pairs: dict[tuple[int, int], list[Mate]] = {}
    for mate in sorted(mates, key=lambda mate: (mate.title, mate.ref.key)):
        bodies = sorted({body_of[entity.path] for entity in mate.entities if entity.path in body_of})
        if len(bodies) == 2:
            pairs.setdefault((bodies[0], bodies[1]), []).append(mate)
        else:
            work.mates.append(mate)
    for _, group in sorted(pairs.items()):
        combinable = all(mate.ref.type in JOINT_TYPES and mate.ref.type != "FASTENED" for mate in group)
        views = [view(mate, assembly, body_of) for mate in group] if combinable and len(group) > 1 else []
        if (
            not views
            or any(mate_view.residual > POSE_TOLERANCE for mate_view in views)
            or not _join(views, work)
        ):
            work.mates.extend(group)
    log.add(diagnostic for diagnostic in work.log.notes if not work.welds or diagnostic.code == RIGID_CODE)
    return CombinedMates(tuple(work.mates), tuple(work.welds), work.absorbed)


def _join(views: Sequence[MateView], work: _Work) -> bool:
    """Replaces several mates by a single mate or a weld; returns False if neither describes their common
    motion."""
    centre, size = extent(views)
    groups = [mate_view for mate_view in views if mate_view.mate.ref.type != "PIN_SLOT"]
    slots = [mate_view for mate_view in views if mate_view.mate.ref.type == "PIN_SLOT"]
    shared = intersection([span(twist_columns(mate_view, centre, size)) for mate_view in groups])
    equal_views = [
        mate_view for mate_view in groups if len(twist_columns(mate_view, centre, size).T) == shared.shape[1]
    ]
    if (
        slots
        and is_within(span(twist_columns(slots[0], centre, size)), shared)
        and _same_slot(slots, centre, size)
    ):
        equal_views = slots
    elif not all(_slot_allows(slot, shared, centre, size) for slot in slots):
        return False
    elif shared.shape[1] == 0 and not equal_views:
        _weld(views, work)
        return True
    if equal_views:
        _absorb(
            equal_views[0],
            [mate_view for mate_view in views if mate_view is not equal_views[0]],
            views,
            size,
            work,
        )
    elif shared.shape[1] == 1:
        _absorb(_single_motion(views, shared[:, 0], centre, size, work.assembly), views, views, size, work)
    return bool(equal_views) or shared.shape[1] == 1


def _same_slot(slots: Sequence[MateView], centre: Array, size: float) -> bool:
    """Tells whether PIN_SLOTs are equivalent: pins on the same axis, slots along the same line of the same
    body.

    Equal twists are not enough: pins side by side, across their slots, have them too.
    """
    lines = [[span(column[:, None]) for column in twist_columns(slot, centre, size).T] for slot in slots]
    return all(
        slot.bodies == slots[0].bodies
        and all(is_within(axis, first) for axis, first in zip(slot_lines, lines[0]))
        for slot, slot_lines in zip(slots, lines, strict=True)
    )


def _slot_allows(slot: MateView, shared: Array, centre: Array, size: float) -> bool:
    """Tells whether a PIN_SLOT, whose motions are not a group, allows the `shared` motions at every pose:
    only the slide, only the turn, or no motion."""
    return any(is_within(shared, span(column[:, None])) for column in twist_columns(slot, centre, size).T)


def _weld(views: Sequence[MateView], work: _Work) -> None:
    first, second = views[0].mate.entities
    work.welds.append((first.path, second.path))
    work.log.report(
        RIGID_CODE,
        f"{_titles(views)} join the same two bodies, and together they leave them no motion",
        views[0].mate.title,
        "if they should move against each other, suppress the redundant mate",
    )


def _single_motion(
    views: Sequence[MateView], twist: Array, centre: Array, size: float, assembly: Assembly
) -> MateView:
    """Returns a mate for a single remaining motion: a turn about an axis, or a slide along a direction."""
    turn, shift = twist[:3], twist[3:] * size
    if np.linalg.norm(turn) > ANGLE_TOLERANCE:
        axis = turn / np.linalg.norm(turn)
        # shift = axis × (centre − point) where |turn| is 1; of the axis' points the nearest to the centre.
        point = centre + np.cross(axis, shift / np.linalg.norm(turn))
        return _revolute(views, axis, point, assembly)
    return _slider(views, shift / np.linalg.norm(shift), assembly)


def _revolute(views: Sequence[MateView], axis: Array, point: Array, assembly: Assembly) -> MateView:
    """Returns a REVOLUTE that measures the turn of the first mate that has a turn; for BALLs, the turn of the
    first ball's frames about the axis."""
    turns = [mate_view for mate_view in views if any(dof.kind == "turn" for dof in mate_view.dofs)]
    source = (turns or views)[0]
    sides = [frame[:3, :3].T @ axis for frame in (source.first, source.second)]
    if turns:
        sign = math.copysign(1.0, sides[1][2])
    else:
        offsets = [axis @ (mate_view.second[:3, 3] - source.second[:3, 3]) for mate_view in views]
        sign = math.copysign(1.0, next(distance for distance in offsets if abs(distance) > ANGLE_TOLERANCE))
        sign = -sign if source.mirrored else sign
    # The x axis of both frames is nearest to this axis, so that neither x is along z.
    reference = int(np.argmin(np.round(np.max(np.abs(sides), axis=0), 6)))
    middle = (source.first[:3, 3] + source.second[:3, 3]) / 2
    origin = point + axis * (axis @ (middle - point))
    frames = [_frame(sign * axis, frame[:3, reference], origin) for frame in (source.first, source.second)]
    return _replacement(source, "REVOLUTE", frames, assembly)


def _slider(views: Sequence[MateView], axis: Array, assembly: Assembly) -> MateView:
    """Returns a SLIDER that measures the slide of the first mate whose slide is along its axis. If there is
    none, it measures the distance along the axis of the first mate that has slides, in the direction of the
    slide nearest to the axis."""
    shares = [
        [float(axis @ mate_view.second[:3, :3] @ dof.axis) for dof in mate_view.dofs if dof.kind == "slide"]
        for mate_view in views
    ]
    cosines = [max(map(abs, share), default=0.0) for share in shares]
    parallel_views = [index for index, share in enumerate(cosines) if share > 1 - ANGLE_TOLERANCE]
    view_index = (
        parallel_views or [index for index, share in enumerate(cosines) if share > ANGLE_TOLERANCE]
    )[0]
    source, share = views[view_index], np.array(shares[view_index])
    axis = math.copysign(1.0, share[np.argmax(np.round(np.abs(share), 6))]) * axis
    middle = (source.first[:3, 3] + source.second[:3, 3]) / 2
    reference = int(np.argmin(np.round(np.abs(source.second[:3, :3].T @ axis), 6)))
    frames = [
        _frame(axis, source.second[:3, reference], middle + axis * (axis @ (frame[:3, 3] - middle)))
        for frame in (source.first, source.second)
    ]
    return _replacement(source, "SLIDER", frames, assembly)


def _frame(z: Array, reference: Array, origin: Array) -> Array:
    """Returns the frame (4, 4) with this z axis and origin whose x axis is the nearest to a reference."""
    x = reference - z * (z @ reference)
    x /= np.linalg.norm(x)
    frame = np.eye(4)
    frame[:3, :] = np.column_stack([x, np.cross(z, x), z, origin])
    return frame


def _replacement(mate_view: MateView, kind: str, frames: Sequence[Array], assembly: Assembly) -> MateView:
    """Returns a mate in place of `mate_view`: of another type, with other frames (4, 4, in the world)."""
    entities = []
    for entity, frame in zip(mate_view.mate.entities, frames, strict=True):
        world_from_occurrence = (
            assembly.occurrences[entity.path].world_from_occurrence if entity.path else np.eye(4)
        )
        entities.append(Entity(entity.path, frozen(inverse(world_from_occurrence) @ frame)))
    limits: dict[str, float] | None = None if mate_view.mate.limits is None else {}
    mate = replace(
        mate_view.mate, ref=replace(mate_view.mate.ref, type=kind), entities=tuple(entities), limits=limits
    )
    body_of = dict(zip((entity.path for entity in entities), mate_view.bodies, strict=True))
    return view(mate, assembly, body_of)


def _absorb(
    remaining: MateView, absorbed: Sequence[MateView], views: Sequence[MateView], size: float, work: _Work
) -> None:
    """Replaces the mates `absorbed` by `remaining`, which gets their limits as far as they limit its dofs."""
    limits = [dof.limits for dof in remaining.dofs]
    for mate_view in absorbed:
        moved_dofs: dict[str, tuple[str, float]] = {}
        values = coordinates(mate_view, np.eye(4))
        for value, dof, coupling in zip(
            values, mate_view.dofs, coordinate_couplings(mate_view, remaining, size), strict=True
        ):
            if coupling is not None and coupling.factor:
                moved_dofs[dof.name] = remaining.dofs[coupling.dof_index].name, coupling.factor
            try:
                limits = narrow_limits(limits, remaining, coupling, dof, float(value))
            except LimitLost as lost:
                _report_lost(mate_view, remaining, dof.name, str(lost), work.log)
        work.absorbed[mate_view.mate.ref.key] = Absorbed(remaining.mate.ref.key, moved_dofs)
    origin = remaining.mate.limit_origin
    for mate_view in absorbed:
        origin = origin.merged_with(mate_view.mate.title, mate_view.mate.limit_origin)
    work.mates.append(with_dof_limits(remaining, limits, origin))
    word = JOINT_TYPES[remaining.mate.ref.type]
    work.log.report(
        "I-COMPOSED",
        f"{_titles(views)} join the same two bodies: together they are one {word} joint",
        remaining.mate.title,
    )


def _report_lost(mate_view: MateView, remaining: MateView, suffix: str, why: str, log: Diagnostics) -> None:
    coordinate = suffix.strip("_") or JOINT_TYPES[mate_view.mate.ref.type]
    log.report(
        "W-LIMIT-LOST",
        f"{remaining.mate.title} replaces this mate, and cannot keep the limits of its {coordinate}: {why}",
        mate_view.mate.title,
        f"set limits on {remaining.mate.title}",
    )


def _titles(views: Sequence[MateView]) -> str:
    return ", ".join(mate_view.mate.title for mate_view in views)
