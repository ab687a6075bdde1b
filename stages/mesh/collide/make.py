"""Makes the colliders of all links: each part's collider once; the worst ones are improved."""

from __future__ import annotations

import json
import threading
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from hashlib import sha256
from typing import TYPE_CHECKING, Any

import numpy as np

from linkwright.stages.formats.meshes.surface import Surface, moved
from linkwright.stages.mesh.collide import collision
from linkwright.stages.mesh.collide.acceptance import miss
from linkwright.stages.mesh.collide.choices import Choice
from linkwright.stages.mesh.collide.collision import Collision
from linkwright.stages.mesh.collide.improvement import Improvement, improved
from linkwright.stages.mesh.collide.merge_across_parts import MIN_PIECES, merge_across_parts
from linkwright.stages.mesh.collide.side_by_side import Making, side_by_side
from linkwright.stages.mesh.configuration.collider_settings import LadderSettings
from linkwright.stages.mesh.library import MeshLibrary
from linkwright.stages.mesh.link_mesh import PlacedMesh
from linkwright.stages.mesh.makers import MAKERS
from linkwright.stages.mesh.surfaces.pieces import placed
from linkwright.stages.robot.errors import DecompositionFailed
from linkwright.stages.robot.model.robot import Array, frozen
from linkwright.stages.robot.system.guest import Guest

if TYPE_CHECKING:
    from linkwright.stages.mesh import Memo, Shown

_IDENTITY = frozen(np.eye(4))


@dataclass(frozen=True, slots=True, eq=False)
class ColliderJob:
    """The task to make a collider for a part of a link, or for several parts together."""

    link: str
    name: str
    """Name of the part, or of the link if there are several parts, for the user."""
    choice: Choice
    """Chosen maker, with its settings."""
    uses: tuple[PlacedMesh, ...]
    """Meshes of the parts, with their poses in the link."""
    parts: tuple[int, ...]
    """Indices of the parts among the uses of the link."""

    @property
    def single(self) -> bool:
        """Whether the collider is for a single part, in the part's frame."""
        return self.choice.how.per == "part" and len(self.uses) == 1

    @property
    def link_from_subject(self) -> Array:
        """Pose of the job's frame in the link (4, 4)."""
        return self.uses[0].link_from_part if self.single else _IDENTITY

    def key(self) -> dict[str, Any]:
        """Returns all that the collider depends on, as plain data."""
        use = self.uses[0]
        meshes = [use.mesh.reply, use.mesh.part] if self.single else [use.key()[:3] for use in self.uses]
        return {"maker": self.choice.maker, "settings": asdict(self.choice.settings), "of": meshes}

    def identity(self) -> str:
        """Returns the digest of the key."""
        return sha256(json.dumps(self.key(), sort_keys=True).encode()).hexdigest()

    def surfaces(self, library: MeshLibrary) -> list[Surface]:
        """Returns the surfaces of the parts that have a mesh, in the frame of the job."""
        candidates = [(use, library.surface(use.mesh, self.choice.how.triangles)) for use in self.uses]
        present = [(use, surface) for use, surface in candidates if surface is not None]
        if self.single:
            return [surface for _, surface in present]
        return [moved(surface, use.link_from_part) for use, surface in present]


@dataclass(frozen=True, slots=True, eq=False)
class Collided:
    """A job and its collider."""

    job: ColliderJob
    collision: Collision


def collide(
    jobs: Sequence[ColliderJob], library: MeshLibrary, memo: Memo, shown: Shown | None = None
) -> list[Collided]:
    """Makes the collider of each job. Jobs of a link are joined if a single primitive or hull serves them as
    well."""
    memory = _ColliderMemory(library, memo)
    # One after the other, since the time is spent in Python: for the 20 parts of the sample two threads take
    # 5.2 s instead of 5.7 s, and two processes, which start for a second each, would save 2 s of 40.
    first = memory.together([Collided(job, memory.first(job)) for job in jobs])
    return memory.across(memory.improved(first, shown))


class _ColliderMemory:
    """Maker of colliders that remembers them by the key of their job."""

    def __init__(self, library: MeshLibrary, memo: Memo) -> None:
        self._library, self._memo = library, memo
        self._first: dict[tuple[str, str], Collision] = {}
        self._lock = threading.Lock()

    def first(self, job: ColliderJob, how: str = "make") -> Collision:
        """Returns the collider from the first step of a maker, or from its function `how`."""
        name = job.identity(), how
        if name not in self._first:
            data = self._remembered(job, how, lambda: collision.encode(self._make(job, how)))
            self._first[name] = collision.decode(data)
        return self._first[name]

    def _remembered(self, job: ColliderJob, step: str, make: Callable[[], bytes]) -> bytes:
        return self._memo("mesh.collider", {"collider": job.identity(), "step": step}, make)

    def _make(self, job: ColliderJob, how: str) -> Collision:
        surfaces = self._surfaces(job)
        if not surfaces:
            return Collision(note="it has no mesh")
        result: Collision = getattr(MAKERS[job.choice.maker], how)(surfaces, job.choice.settings)
        return result

    def _surfaces(self, job: ColliderJob) -> list[Surface]:
        with self._lock:
            return job.surfaces(self._library)

    def together(self, outcomes: Sequence[Collided]) -> list[Collided]:
        """Returns the colliders. Parts of a link that the same key chose share a single one if that
        suffices."""
        return [
            collided for group in _groups_by_key(outcomes) for collided in (self._one_for_all(group) or group)
        ]

    def _one_for_all(self, group: Sequence[Collided]) -> list[Collided]:
        if len(group) < 2:
            return []
        whole = _whole(group)
        shared = self.first(whole, "together")
        return [Collided(whole, shared)] if shared.pieces else []

    def across(self, outcomes: Sequence[Collided]) -> list[Collided]:
        """Returns the colliders. Parts of a link that the same key chose get fewer pieces if pieces of
        different parts can be joined."""
        result = []
        for group in _groups_by_key(outcomes):
            accepted = [
                collided
                for collided in group
                if collided.collision.meets and len(collided.collision.pieces) > 1
            ]
            joined_collider = self._joined(accepted) if len(accepted) > 1 else None
            result += (
                [joined_collider, *(collided for collided in group if collided not in accepted)]
                if joined_collider
                else group
            )
        return result

    def _joined(self, group: Sequence[Collided]) -> Collided | None:
        whole = _whole(group)
        pieces = [
            placed(piece, collided.job.link_from_subject)
            for collided in group
            for piece in collided.collision.pieces
        ]
        if len(pieces) < MIN_PIECES:
            return None

        settings = whole.choice.settings
        assert isinstance(settings, LadderSettings)

        def make() -> bytes:
            return collision.encode(merge_across_parts(self._surfaces(whole), pieces, settings))

        name = whole.identity(), "joined"
        if name not in self._first:
            self._first[name] = collision.decode(self._remembered(whole, "joined", make))
        return Collided(whole, self._first[name]) if self._first[name].pieces else None

    def improved(self, outcomes: Sequence[Collided], shown: Shown | None) -> list[Collided]:
        """Returns the colliders after the second step of their makers, which starts with the worst
        collider."""
        candidates: dict[str, Collided] = {}
        for collided in outcomes:
            if collided.job.choice.how.improves and not collided.collision.meets and collided.collision.faces:
                candidates.setdefault(collided.job.identity(), collided)
        ranked = sorted(candidates, key=lambda name: (-_tolerances_off(candidates[name].collision), name))
        makings: list[Making[Collision | DecompositionFailed]] = [
            Making(candidates[name].job.name, partial(self._improve, candidates[name])) for name in ranked
        ]
        results: dict[str, Collision] = {}
        for name, result in zip(ranked, side_by_side(makings, shown), strict=True):
            if isinstance(result, DecompositionFailed):
                results[name] = replace(candidates[name].collision, note=result.message, failed=True)
            else:
                results[name] = result
        return [
            replace(collided, collision=results.get(collided.job.identity(), collided.collision))
            for collided in outcomes
        ]

    def _improve(self, collided: Collided, guest: Guest) -> Collision:
        job, first_collider = collided.job, collided.collision

        def make() -> bytes:
            task = Improvement(job.choice.maker, self._surfaces(job), job.choice.settings, first_collider)
            return improved(task, guest)

        return collision.decode(self._remembered(job, "improve", make))


def _groups_by_key(outcomes: Sequence[Collided]) -> list[list[Collided]]:
    """Groups colliders: those of a link that the same key chose for the ladder are a group, every other
    collider is a group by itself."""
    groups: dict[tuple[str, int], list[Collided]] = {}
    for number, collided in enumerate(outcomes):
        choice = collided.job.choice
        joins = choice.maker == "ladder" and not choice.apart and collided.collision.pieces
        key = (collided.job.link, choice.entry) if joins else ("", number)
        groups.setdefault(key, []).append(collided)
    return list(groups.values())


def _whole(group: Sequence[Collided]) -> ColliderJob:
    """Returns the job of a single collider for all parts of a group."""
    jobs = [collided.job for collided in group]
    uses = tuple(use for job in jobs for use in job.uses)
    parts = tuple(part for job in jobs for part in job.parts)
    return replace(jobs[0], name=jobs[0].link, uses=uses, parts=parts)


def _tolerances_off(result: Collision) -> float:
    if result.measures is None or result.tolerance is None:
        return 0.0
    return miss(result.measures, result.tolerance)


def jobs_of(
    link: str, uses: Sequence[PlacedMesh], names: Sequence[str], choices: Sequence[Choice]
) -> Iterator[ColliderJob]:
    """Yields the jobs of a link: a job for each part, or a job for all parts together that the same key
    chose.

    `names`, `choices`: name and choice for each use.
    """
    groups: dict[tuple[int, str], list[int]] = {}
    for index, choice in enumerate(choices):
        apart = choice.apart or choice.how.per == "part"
        groups.setdefault((choice.entry, str(index) if apart else ""), []).append(index)
    for indices in groups.values():
        name = names[indices[0]] if len(indices) == 1 else link
        part_uses = tuple(uses[index] for index in indices)
        yield ColliderJob(link, name, choices[indices[0]], part_uses, tuple(indices))
