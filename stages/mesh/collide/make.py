"""The colliders of all links: each part's is made once, and the worst ones are improved."""

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
from linkwright.stages.mesh.collide.merge_across_parts import MANY, across
from linkwright.stages.mesh.collide.side_by_side import Making, side_by_side
from linkwright.stages.mesh.configuration.collider_settings import LadderSettings
from linkwright.stages.mesh.library import MeshLibrary
from linkwright.stages.mesh.link_mesh import Use
from linkwright.stages.mesh.makers import MAKERS
from linkwright.stages.mesh.surfaces.pieces import placed
from linkwright.stages.robot.errors import DecompositionFailed
from linkwright.stages.robot.model.robot import Array, frozen
from linkwright.stages.robot.system.guest import Guest

if TYPE_CHECKING:
    from linkwright.stages.mesh import Memo, Shown

_HERE = frozen(np.eye(4))


@dataclass(frozen=True, slots=True, eq=False)
class ColliderJob:
    """One or several uses of parts in a link that have one collider.

    `name`: of the part, or of the link, for the user; `parts`: indices into the uses of the link.
    """

    link: str
    name: str
    choice: Choice
    uses: tuple[Use, ...]
    parts: tuple[int, ...]

    @property
    def alone(self) -> bool:
        """Whether it is a part in its own frame."""
        return self.choice.how.per == "part" and len(self.uses) == 1

    @property
    def link_from_subject(self) -> Array:
        return self.uses[0].link_from_part if self.alone else _HERE

    def key(self) -> dict[str, Any]:
        """All that the collider depends on, as plain data."""
        use = self.uses[0]
        made_of = [use.mesh.reply, use.mesh.part] if self.alone else [one.key()[:3] for one in self.uses]
        return {"maker": self.choice.maker, "settings": asdict(self.choice.settings), "of": made_of}

    def identity(self) -> str:
        """The digest of the key."""
        return sha256(json.dumps(self.key(), sort_keys=True).encode()).hexdigest()

    def surfaces(self, library: MeshLibrary) -> list[Surface]:
        """The surfaces of the parts that have a mesh, in the frame of the job."""
        every = [(use, library.surface(use.mesh, self.choice.how.triangles)) for use in self.uses]
        found = [(use, surface) for use, surface in every if surface is not None]
        if self.alone:
            return [surface for _, surface in found]
        return [moved(surface, use.link_from_part) for use, surface in found]


@dataclass(frozen=True, slots=True, eq=False)
class Collided:
    """A job and its collider."""

    job: ColliderJob
    collision: Collision


def collide(
    jobs: Sequence[ColliderJob], library: MeshLibrary, memo: Memo, shown: Shown | None = None
) -> list[Collided]:
    """The collider of each job; those of a link that one primitive or hull serves as well, together."""
    made = _Made(library, memo)
    # One after the other, since this is Python's own time: for the 20 parts of the sample two threads take
    # 5.2 s instead of 5.7 s, and two processes, which start for a second each, would save 2 s of 40.
    first = made.together([Collided(job, made.first(job)) for job in jobs])
    return made.across(made.improved(first, shown))


class _Made:
    """Colliders by what they depend on."""

    def __init__(self, library: MeshLibrary, memo: Memo) -> None:
        self._library, self._memo = library, memo
        self._first: dict[tuple[str, str], Collision] = {}
        self._lock = threading.Lock()

    def first(self, job: ColliderJob, how: str = "make") -> Collision:
        """What the first step of a maker gives, or the function `how`."""
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
        made: Collision = getattr(MAKERS[job.choice.maker], how)(surfaces, job.choice.settings)
        return made

    def _surfaces(self, job: ColliderJob) -> list[Surface]:
        with self._lock:
            return job.surfaces(self._library)

    def together(self, every: Sequence[Collided]) -> list[Collided]:
        """The same with one collider for parts of a link that the same key chose, where one will do."""
        return [one for group in _of_one_key(every) for one in (self._one_for_all(group) or group)]

    def _one_for_all(self, group: Sequence[Collided]) -> list[Collided]:
        if len(group) < 2:
            return []
        whole = _whole(group)
        made = self.first(whole, "together")
        return [Collided(whole, made)] if made.pieces else []

    def across(self, every: Sequence[Collided]) -> list[Collided]:
        """The same with fewer pieces for parts of a link that the same key chose, where some of one part
        and of another may be one."""
        found = []
        for group in _of_one_key(every):
            near = [one for one in group if one.collision.meets and len(one.collision.pieces) > 1]
            joined = self._joined(near) if len(near) > 1 else None
            found += [joined, *(one for one in group if one not in near)] if joined else group
        return found

    def _joined(self, group: Sequence[Collided]) -> Collided | None:
        whole = _whole(group)
        pieces = [placed(piece, one.job.link_from_subject) for one in group for piece in one.collision.pieces]
        if len(pieces) < MANY:
            return None

        settings = whole.choice.settings
        assert isinstance(settings, LadderSettings)

        def make() -> bytes:
            return collision.encode(across(self._surfaces(whole), pieces, settings))

        name = whole.identity(), "joined"
        if name not in self._first:
            self._first[name] = collision.decode(self._remembered(whole, "joined", make))
        return Collided(whole, self._first[name]) if self._first[name].pieces else None

    def improved(self, every: Sequence[Collided], shown: Shown | None) -> list[Collided]:
        """The same with the second step of the makers, the worst first."""
        wanting: dict[str, Collided] = {}
        for one in every:
            if one.job.choice.how.improves and not one.collision.meets and one.collision.faces:
                wanting.setdefault(one.job.identity(), one)
        ranked = sorted(wanting, key=lambda name: (-_off(wanting[name].collision), name))
        makings: list[Making[Collision | DecompositionFailed]] = [
            Making(wanting[name].job.name, partial(self._improve, wanting[name])) for name in ranked
        ]
        found: dict[str, Collision] = {}
        for name, result in zip(ranked, side_by_side(makings, shown), strict=True):
            if isinstance(result, DecompositionFailed):
                found[name] = replace(wanting[name].collision, note=result.message, failed=True)
            else:
                found[name] = result
        return [replace(one, collision=found.get(one.job.identity(), one.collision)) for one in every]

    def _improve(self, one: Collided, guest: Guest) -> Collision:
        job, made = one.job, one.collision

        def make() -> bytes:
            task = Improvement(job.choice.maker, self._surfaces(job), job.choice.settings, made)
            return improved(task, guest)

        return collision.decode(self._remembered(job, "improve", make))


def _of_one_key(every: Sequence[Collided]) -> list[list[Collided]]:
    """What of a link one key chose for the ladder, together; all else alone."""
    groups: dict[tuple[str, int], list[Collided]] = {}
    for number, one in enumerate(every):
        choice = one.job.choice
        joins = choice.maker == "ladder" and not choice.apart and one.collision.pieces
        key = (one.job.link, choice.entry) if joins else ("", number)
        groups.setdefault(key, []).append(one)
    return list(groups.values())


def _whole(group: Sequence[Collided]) -> ColliderJob:
    """The job of one collider for several parts of a link."""
    jobs = [one.job for one in group]
    uses = tuple(use for job in jobs for use in job.uses)
    parts = tuple(part for job in jobs for part in job.parts)
    return replace(jobs[0], name=jobs[0].link, uses=uses, parts=parts)


def _off(made: Collision) -> float:
    if made.measures is None or made.tolerance is None:
        return 0.0
    return miss(made.measures, made.tolerance)


def jobs_of(
    link: str, uses: Sequence[Use], names: Sequence[str], by: Sequence[Choice]
) -> Iterator[ColliderJob]:
    """What has a collider of its own in a link: each part, or the parts together that one key chose.

    `names`, `by`: the name and the choice for each use.
    """
    together: dict[tuple[int, str], list[int]] = {}
    for index, choice in enumerate(by):
        apart = choice.apart or choice.how.per == "part"
        together.setdefault((choice.entry, str(index) if apart else ""), []).append(index)
    for indices in together.values():
        name = names[indices[0]] if len(indices) == 1 else link
        chosen = tuple(uses[index] for index in indices)
        yield ColliderJob(link, name, by[indices[0]], chosen, tuple(indices))
