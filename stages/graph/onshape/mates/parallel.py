"""Combines several mates between the same two bodies into one mate or a weld.

Onshape's mates are constraints, so two bodies move only as every mate between them allows. That is
the motion of one of them (the second hinge of a door, a CYLINDRICAL beside a REVOLUTE), or what only
their intersection is: a turn (two BALLs, a PLANAR across a CYLINDRICAL), a slide (two PLANARs), or
nothing at all. No intersection of what mates allow is anything else than these or a shift in any
direction of a plane or of space, which no mate describes: such mates stay as they are.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from linkwright.stages.graph.onshape.assembly import Assembly, Entity, Mate, Path
from linkwright.stages.graph.onshape.mates.combined_limits import MET, LimitLost, limited, narrowed
from linkwright.stages.graph.onshape.mates.coordinates import coordinates, ties
from linkwright.stages.graph.onshape.mates.joints import JOINT_TYPES
from linkwright.stages.graph.onshape.mates.twists import (
    ALIKE,
    View,
    columns,
    common,
    extent,
    span,
    view,
    within,
)
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.poses import inverse
from linkwright.stages.robot.model.robot import Array, frozen

RIGID = "W-MATES-RIGID"

MateKey = tuple[Path, str, str]


@dataclass(frozen=True, slots=True)
class Absorbed:
    """A mate that another one replaces: the key of that one, and by the suffixes of its dofs which dof
    of the other moves it: its change = factor · the other's."""

    by: MateKey
    dofs: Mapping[str, tuple[str, float]]

    @property
    def sign(self) -> int:
        """1 or -1 where all its values change as the other's do, or against them; else 0."""
        factors = {factor for _, factor in self.dofs.values()}
        return int(factors.pop()) if factors in ({1.0}, {-1.0}) else 0


@dataclass(frozen=True, slots=True)
class CombinedMates:
    """`mates`: one for each two bodies, where one mate can describe their motion. `welds`: occurrences that
    their mates hold rigidly against each other; those mates are gone. `absorbed`: by key, mates that are
    gone but still move."""

    mates: tuple[Mate, ...]
    welds: tuple[tuple[Path, Path], ...]
    absorbed: Mapping[MateKey, Absorbed]


@dataclass(slots=True)
class _Work:
    assembly: Assembly
    log: Diagnostics
    mates: list[Mate]
    welds: list[tuple[Path, Path]]
    absorbed: dict[MateKey, Absorbed]


def combined(
    mates: Sequence[Mate], assembly: Assembly, body_of: Mapping[Path, int], log: Diagnostics
) -> CombinedMates:
    """Combines the mates between different bodies, two bodies at a time.

    `body_of`: occurrence path → body. Mates of one body, or of an unknown type, are passed on. The
    result does not depend on the order of `mates`, nor on which entity of a mate is the first. Where
    there are welds only they are reported: once merged the bodies are others, and this is called again.
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
        known = all(mate.ref.type in JOINT_TYPES and mate.ref.type != "FASTENED" for mate in group)
        views = [view(mate, assembly, body_of) for mate in group] if known and len(group) > 1 else []
        if not views or any(one.residual > MET for one in views) or not _join(views, work):
            work.mates.extend(group)
    log.add(one for one in work.log.found if not work.welds or one.code == RIGID)
    return CombinedMates(tuple(work.mates), tuple(work.welds), work.absorbed)


def _join(views: Sequence[View], work: _Work) -> bool:
    """Replaces several mates by one mate or a weld; False where neither describes their common motion."""
    centre, size = extent(views)
    groups = [one for one in views if one.mate.ref.type != "PIN_SLOT"]
    slots = [one for one in views if one.mate.ref.type == "PIN_SLOT"]
    shared = common([span(columns(one, centre, size)) for one in groups])
    alike = [one for one in groups if len(columns(one, centre, size).T) == shared.shape[1]]
    if slots and within(span(columns(slots[0], centre, size)), shared) and _same_slot(slots, centre, size):
        alike = slots
    elif not all(_slot_allows(slot, shared, centre, size) for slot in slots):
        return False
    elif shared.shape[1] == 0 and not alike:
        _weld(views, work)
        return True
    if alike:
        _absorb(alike[0], [one for one in views if one is not alike[0]], views, size, work)
    elif shared.shape[1] == 1:
        _absorb(_single(views, shared[:, 0], centre, size, work.assembly), views, views, size, work)
    return bool(alike) or shared.shape[1] == 1


def _same_slot(slots: Sequence[View], centre: Array, size: float) -> bool:
    """Whether PIN_SLOTs are one: pins on one axis, slots along one line of the same body.

    That they span the same twists is not enough: so do pins side by side, across their slots.
    """
    lines = [[span(column[:, None]) for column in columns(slot, centre, size).T] for slot in slots]
    return all(
        slot.bodies == slots[0].bodies and all(within(one, first) for one, first in zip(own, lines[0]))
        for slot, own in zip(slots, lines, strict=True)
    )


def _slot_allows(slot: View, shared: Array, centre: Array, size: float) -> bool:
    """Whether a PIN_SLOT, which is no subgroup, allows these motions everywhere: the slide alone, or the
    turn alone, or none."""
    return any(within(shared, span(column[:, None])) for column in columns(slot, centre, size).T)


def _weld(views: Sequence[View], work: _Work) -> None:
    first, second = views[0].mate.entities
    work.welds.append((first.path, second.path))
    work.log.report(
        RIGID,
        f"{_listed(views)} join the same two bodies, and together they leave them no motion",
        views[0].mate.title,
        "if they should move against each other, suppress the redundant mate",
    )


def _single(views: Sequence[View], twist: Array, centre: Array, size: float, assembly: Assembly) -> View:
    """A mate for a single remaining motion: a turn about an axis, or a slide along a direction."""
    turn, shift = twist[:3], twist[3:] * size
    if np.linalg.norm(turn) > ALIKE:
        axis = turn / np.linalg.norm(turn)
        # shift = axis × (centre − point) where |turn| is 1; of the axis' points the nearest to the centre.
        point = centre + np.cross(axis, shift / np.linalg.norm(turn))
        return _turning(views, axis, point, assembly)
    return _sliding(views, shift / np.linalg.norm(shift), assembly)


def _turning(views: Sequence[View], axis: Array, point: Array, assembly: Assembly) -> View:
    """A REVOLUTE that counts the turn of the first mate with one; of BALLs, that of the first ball's
    frames about the axis."""
    turns = [one for one in views if any(dof.kind == "turn" for dof in one.dofs)]
    kept = (turns or views)[0]
    sides = [frame[:3, :3].T @ axis for frame in (kept.first, kept.second)]
    if turns:
        sign = math.copysign(1.0, sides[1][2])
    else:
        away = [axis @ (one.second[:3, 3] - kept.second[:3, 3]) for one in views]
        sign = math.copysign(1.0, next(one for one in away if abs(one) > ALIKE))
        sign = -sign if kept.mirrored else sign
    # What both frames are turned from, so that neither is along the axis.
    reference = int(np.argmin(np.round(np.max(np.abs(sides), axis=0), 6)))
    middle = (kept.first[:3, 3] + kept.second[:3, 3]) / 2
    origin = point + axis * (axis @ (middle - point))
    frames = [_frame(sign * axis, frame[:3, reference], origin) for frame in (kept.first, kept.second)]
    return _made(kept, "REVOLUTE", frames, assembly)


def _sliding(views: Sequence[View], axis: Array, assembly: Assembly) -> View:
    """A SLIDER that counts the slide of the first mate with one along it; else the way along it of the
    first mate that has slides, in the direction of the one that shares most of it."""
    shares = [
        [float(axis @ one.second[:3, :3] @ dof.axis) for dof in one.dofs if dof.kind == "slide"]
        for one in views
    ]
    along = [max(map(abs, share), default=0.0) for share in shares]
    exact = [index for index, share in enumerate(along) if share > 1 - ALIKE]
    chosen = (exact or [index for index, share in enumerate(along) if share > ALIKE])[0]
    kept, share = views[chosen], np.array(shares[chosen])
    axis = math.copysign(1.0, share[np.argmax(np.round(np.abs(share), 6))]) * axis
    middle = (kept.first[:3, 3] + kept.second[:3, 3]) / 2
    reference = int(np.argmin(np.round(np.abs(kept.second[:3, :3].T @ axis), 6)))
    frames = [
        _frame(axis, kept.second[:3, reference], middle + axis * (axis @ (frame[:3, 3] - middle)))
        for frame in (kept.first, kept.second)
    ]
    return _made(kept, "SLIDER", frames, assembly)


def _frame(z: Array, reference: Array, origin: Array) -> Array:
    """The frame (4, 4) with this z axis and origin whose x axis is the nearest to a reference."""
    x = reference - z * (z @ reference)
    x /= np.linalg.norm(x)
    frame = np.eye(4)
    frame[:3, :] = np.column_stack([x, np.cross(z, x), z, origin])
    return frame


def _made(kept: View, kind: str, frames: Sequence[Array], assembly: Assembly) -> View:
    """A mate in place of one: of another type, with other frames (4, 4, in the world)."""
    entities = []
    for entity, frame in zip(kept.mate.entities, frames, strict=True):
        at = assembly.occurrences[entity.path].world_from_occurrence if entity.path else np.eye(4)
        entities.append(Entity(entity.path, frozen(inverse(at) @ frame)))
    limits: dict[str, float] | None = None if kept.mate.limits is None else {}
    mate = replace(kept.mate, ref=replace(kept.mate.ref, type=kind), entities=tuple(entities), limits=limits)
    body_of = dict(zip((entity.path for entity in entities), kept.bodies, strict=True))
    return view(mate, assembly, body_of)


def _absorb(into: View, others: Sequence[View], views: Sequence[View], size: float, work: _Work) -> None:
    """Replaces all mates by one, with their limits where these bound one of its coordinates."""
    limits = [dof.limits for dof in into.dofs]
    for one in others:
        moved: dict[str, tuple[str, float]] = {}
        here = coordinates(one, np.eye(4))
        for value, dof, tie in zip(here, one.dofs, ties(one, into, size), strict=True):
            if tie is not None and tie.factor:
                moved[dof.name] = into.dofs[tie.onto].name, tie.factor
            try:
                limits = narrowed(limits, into, tie, dof, float(value))
            except LimitLost as lost:
                _report_lost(one, into, dof.name, str(lost), work.log)
        work.absorbed[one.mate.ref.key] = Absorbed(into.mate.ref.key, moved)
    origin = into.mate.limit_origin
    for one in others:
        origin = origin.with_those_of(one.mate.title, one.mate.limit_origin)
    work.mates.append(limited(into, limits, origin))
    word = JOINT_TYPES[into.mate.ref.type]
    work.log.report(
        "I-COMPOSED",
        f"{_listed(views)} join the same two bodies: together they are one {word} joint",
        into.mate.title,
    )


def _report_lost(one: View, into: View, suffix: str, why: str, log: Diagnostics) -> None:
    what = suffix.strip("_") or JOINT_TYPES[one.mate.ref.type]
    log.report(
        "W-LIMIT-LOST",
        f"{into.mate.title} replaces this mate, and cannot keep the limits of its {what}: {why}",
        one.mate.title,
        f"set limits on {into.mate.title}",
    )


def _listed(views: Sequence[View]) -> str:
    return ", ".join(one.mate.title for one in views)
