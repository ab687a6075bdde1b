"""Makes the colliders of all links: equal jobs share a collider, and colliders that miss their tolerance are
improved."""

from __future__ import annotations

import json
import threading
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from hashlib import sha256
from typing import TYPE_CHECKING, Any

import numpy as np

from linkwright.stages.formats.meshes.surface import Surface, transform_surface
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
    placed_meshes: tuple[PlacedMesh, ...]
    """Meshes of the parts, with their poses in the link."""
    parts: tuple[int, ...]
    """Index of each part among the parts of the link."""

    @property
    def in_part_frame(self) -> bool:
        """Whether the collider is for a single part, in the frame of that part."""
        return self.choice.how.per == "part" and len(self.placed_meshes) == 1

    @property
    def link_from_subject(self) -> Array:
        """Pose of the job's frame in the link (4, 4)."""
        return self.placed_meshes[0].link_from_part if self.in_part_frame else _IDENTITY

    def identity_data(self) -> dict[str, Any]:
        """Returns everything that the collider depends on, as plain data."""
        if self.in_part_frame:
            mesh = self.placed_meshes[0].mesh
            meshes: list[Any] = [mesh.reply, mesh.part]
        else:
            # The rest of a mesh's key (whether it collides, whether it is drawn) does not change the
            # collider.
            meshes = [placed_mesh.key()[:3] for placed_mesh in self.placed_meshes]
        return {"maker": self.choice.maker, "settings": asdict(self.choice.settings), "of": meshes}

    def identity(self) -> str:
        """Returns the digest of `identity_data`."""
        return sha256(json.dumps(self.identity_data(), sort_keys=True).encode()).hexdigest()

    def surfaces(self, library: MeshLibrary) -> list[Surface]:
        """Returns the surfaces of the parts that have a mesh, in the frame of the job."""
        surfaces = []
        for placed_mesh in self.placed_meshes:
            surface = library.surface(placed_mesh.mesh, self.choice.how.triangles)
            if surface is not None:
                surfaces.append(
                    surface if self.in_part_frame else transform_surface(surface, placed_mesh.link_from_part)
                )
        return surfaces


@dataclass(frozen=True, slots=True, eq=False)
class MadeCollider:
    """A job and its collider."""

    job: ColliderJob
    collision: Collision


def collide(
    jobs: Sequence[ColliderJob], library: MeshLibrary, memo: Memo, shown: Shown | None = None
) -> list[MadeCollider]:
    """Makes the collider of each job. Jobs of a link are merged if a single primitive or hull represents
    their parts equally well."""
    maker = _ColliderMaker(library, memo)
    # One after the other, since the time is spent in Python: for the 20 parts of the sample two threads take
    # 5.2 s instead of 5.7 s, and two processes, which start for a second each, would save 2 s of 40.
    first_colliders = [MadeCollider(job, maker.collider_of(job)) for job in jobs]
    return maker.merge_pieces(maker.improve_misses(maker.share_colliders(first_colliders), shown))


class _ColliderMaker:
    """Makes colliders, and keeps each in memory by the identity of its job."""

    def __init__(self, library: MeshLibrary, memo: Memo) -> None:
        self._library, self._memo = library, memo
        self._colliders: dict[tuple[str, str], Collision] = {}
        self._lock = threading.Lock()

    def collider_of(self, job: ColliderJob, step: str = "make") -> Collision:
        """Returns the collider of a job. `step`: the maker's function, "make", or "together" to make a single
        collider of several parts."""
        return self._remembered(job, step, lambda: collision.encode(self._make(job, step)))

    def _remembered(self, job: ColliderJob, step: str, make: Callable[[], bytes]) -> Collision:
        """Returns the collider of a step ("make", "together" or "joined") from memory; the first time, it is
        read from the cache, or made by `make`."""
        memory_key = job.identity(), step
        if memory_key not in self._colliders:
            self._colliders[memory_key] = collision.decode(self._cached(job, step, make))
        return self._colliders[memory_key]

    def _cached(self, job: ColliderJob, step: str, make: Callable[[], bytes]) -> bytes:
        return self._memo("mesh.collider", {"collider": job.identity(), "step": step}, make)

    def _make(self, job: ColliderJob, step: str) -> Collision:
        surfaces = self._surfaces(job)
        if not surfaces:
            return Collision(note="it has no mesh")
        result: Collision = getattr(MAKERS[job.choice.maker], step)(surfaces, job.choice.settings)
        return result

    def _surfaces(self, job: ColliderJob) -> list[Surface]:
        with self._lock:
            return job.surfaces(self._library)

    def share_colliders(self, colliders: Sequence[MadeCollider]) -> list[MadeCollider]:
        """Returns the colliders, with a single shared collider for the parts of a link whose maker the same
        configuration entry chose, if a shared collider suffices."""
        result: list[MadeCollider] = []
        for group in _groups_by_entry(colliders):
            shared_collider = self._shared_collider(group)
            result += group if shared_collider is None else [shared_collider]
        return result

    def _shared_collider(self, group: Sequence[MadeCollider]) -> MadeCollider | None:
        if len(group) < 2:
            return None
        combined_job = _combined_job(group)
        shared = self.collider_of(combined_job, "together")
        return MadeCollider(combined_job, shared) if shared.pieces else None

    def merge_pieces(self, colliders: Sequence[MadeCollider]) -> list[MadeCollider]:
        """Returns the colliders, with fewer pieces where pieces of different parts can be merged. Only parts
        of a link whose maker the same configuration entry chose are merged."""
        result: list[MadeCollider] = []
        for group in _groups_by_entry(colliders):
            mergeable = [
                collider
                for collider in group
                if collider.collision.meets and len(collider.collision.pieces) > 1
            ]
            merged_collider = self._merged_collider(mergeable) if len(mergeable) > 1 else None
            if merged_collider is None:
                result += group
            else:
                result += [merged_collider, *(collider for collider in group if collider not in mergeable)]
        return result

    def _merged_collider(self, group: Sequence[MadeCollider]) -> MadeCollider | None:
        combined_job = _combined_job(group)
        pieces = [
            placed(piece, collider.job.link_from_subject)
            for collider in group
            for piece in collider.collision.pieces
        ]
        if len(pieces) < MIN_PIECES:
            return None

        settings = combined_job.choice.settings
        assert isinstance(settings, LadderSettings)

        def encoded_merge() -> bytes:
            return collision.encode(merge_across_parts(self._surfaces(combined_job), pieces, settings))

        merged = self._remembered(combined_job, "joined", encoded_merge)
        return MadeCollider(combined_job, merged) if merged.pieces else None

    def improve_misses(self, colliders: Sequence[MadeCollider], shown: Shown | None) -> list[MadeCollider]:
        """Returns the colliders, improved where a collider misses its tolerance and its maker has a second
        step. The worst collider is improved first."""
        candidates = _candidates_for_improvement(colliders)
        tasks: list[Making[Collision | DecompositionFailed]] = [
            Making(candidate.job.name, partial(self._improve, candidate)) for candidate in candidates.values()
        ]
        results: dict[str, Collision] = {}
        for identity, result in zip(candidates, side_by_side(tasks, shown), strict=True):
            if isinstance(result, DecompositionFailed):
                results[identity] = replace(candidates[identity].collision, note=result.message, failed=True)
            else:
                results[identity] = result
        return [
            replace(collider, collision=results.get(collider.job.identity(), collider.collision))
            for collider in colliders
        ]

    def _improve(self, collider: MadeCollider, guest: Guest) -> Collision:
        job = collider.job

        def encoded_improvement() -> bytes:
            task = Improvement(job.choice.maker, self._surfaces(job), job.choice.settings, collider.collision)
            return improved(task, guest)

        # Each collider is improved once, in a thread of its own, so `_colliders` is not needed.
        return collision.decode(self._cached(job, "improve", encoded_improvement))


def _candidates_for_improvement(colliders: Sequence[MadeCollider]) -> dict[str, MadeCollider]:
    """Returns a collider for each job that misses its tolerance and can be improved, by the job's identity,
    the worst first."""
    candidates: dict[str, MadeCollider] = {}
    for collider in colliders:
        if collider.job.choice.how.improves and not collider.collision.meets and collider.collision.faces:
            candidates.setdefault(collider.job.identity(), collider)
    return dict(sorted(candidates.items(), key=lambda item: (-_tolerances_off(item[1].collision), item[0])))


def _groups_by_entry(colliders: Sequence[MadeCollider]) -> list[list[MadeCollider]]:
    """Groups colliders: those of a link for which the same configuration entry chose the ladder are a group,
    and every other collider is a group by itself."""
    groups: dict[tuple[str, int], list[MadeCollider]] = {}
    for index, collider in enumerate(colliders):
        choice = collider.job.choice
        mergeable = choice.maker == "ladder" and not choice.apart and collider.collision.pieces
        # No link has an empty name, so the index makes a group of this collider alone.
        group_key = (collider.job.link, choice.entry) if mergeable else ("", index)
        groups.setdefault(group_key, []).append(collider)
    return list(groups.values())


def _combined_job(group: Sequence[MadeCollider]) -> ColliderJob:
    """Returns the job of a single collider for all parts of a group."""
    jobs = [collider.job for collider in group]
    placed_meshes = tuple(placed_mesh for job in jobs for placed_mesh in job.placed_meshes)
    parts = tuple(part for job in jobs for part in job.parts)
    return replace(jobs[0], name=jobs[0].link, placed_meshes=placed_meshes, parts=parts)


def _tolerances_off(result: Collision) -> float:
    """Returns by how many tolerances a collider misses its part; 0 if it was not measured."""
    if result.measures is None or result.tolerance is None:
        return 0.0
    return miss(result.measures, result.tolerance)


def jobs_of(
    link: str, placed_meshes: Sequence[PlacedMesh], names: Sequence[str], choices: Sequence[Choice]
) -> Iterator[ColliderJob]:
    """Yields the jobs of a link: a job for each part, or one job for all parts for which the same
    configuration entry chose the maker.

    `names`, `choices`: name and choice for each mesh.
    """
    groups: dict[tuple[int, str], list[int]] = {}
    for index, choice in enumerate(choices):
        apart = choice.apart or choice.how.per == "part"
        # A part that is apart is the only one with its index.
        groups.setdefault((choice.entry, str(index) if apart else ""), []).append(index)
    for indices in groups.values():
        name = names[indices[0]] if len(indices) == 1 else link
        meshes = tuple(placed_meshes[index] for index in indices)
        yield ColliderJob(link, name, choices[indices[0]], meshes, tuple(indices))


def collider_indices(made_colliders: Sequence[MadeCollider]) -> list[int]:
    """Returns the index of each collider among the colliders of its link."""
    counts: Counter[str] = Counter()
    indices = []
    for collider in made_colliders:
        indices.append(counts[collider.job.link])
        counts[collider.job.link] += 1
    return indices
