"""What is asked of colliders by contact, and what is reported of those that are still false."""

from __future__ import annotations

import importlib.metadata
import importlib.util
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from linkwright.stages.mesh.collide import collision
from linkwright.stages.mesh.motion_digest import motion_digest
from linkwright.stages.mesh.surfaces.pieces import Piece
from linkwright.stages.robot.model.robot import Robot
from linkwright.stages.robot.motion.adjacency import Pair

if TYPE_CHECKING:
    from linkwright.stages.mesh.collide.make import ColliderJob

POSES = 512
"""Seeded poses that make colliders: by fewer harmless pairs look bad, by 64 of them 5 to 9 %."""


@dataclass(frozen=True, slots=True, eq=False)
class ContactRequest:
    """The colliders that contact decides.

    `jobs`: a collider each; `fixed`: by link the pieces that stay as they are, in its frame; `apart`: pairs
    of links that do not collide, None where no two do; `fine`: the links that are to be within their
    tolerance, None for those that meet the world.
    """

    robot: Robot
    jobs: Sequence[ColliderJob]
    fixed: Mapping[str, Sequence[Piece]]
    apart: Collection[Pair] | None
    fine: Collection[str] | None

    def key(self) -> dict[str, Any]:
        """All that the colliders depend on, as plain data."""
        frames = sorted([frame.name, frame.link] for frame in self.robot.frames)
        return {
            "jobs": [[job.link, job.key()] for job in self.jobs],
            "fixed": {link: collision.digest(pieces) for link, pieces in sorted(self.fixed.items())},
            "apart": None if self.apart is None else sorted(self.apart),
            "fine": frames if self.fine is None else [sorted(self.fine)],
            "motion": motion_digest(self.robot),
            "up": None if self.robot.base.fixed else self.robot.world_from_root[2, :3].tolist(),
            "poses": POSES,
            "engine": _engine(),
        }


def _engine() -> str:
    name = "coal" if importlib.util.find_spec("coal") else "python-fcl"
    return f"{name} {importlib.metadata.version(name)}"


@dataclass(frozen=True, slots=True)
class FalsePair:
    """Two links whose colliders overlap where the links are apart, in too many of the poses, or at `home`.

    `share`: of the poses; `depth` [m]: how much deeper than is allowed they are then.
    """

    one: str
    other: str
    share: float
    home: bool
    depth: float

    def has(self, link: str) -> bool:
        """Whether the link is one of the two."""
        return link in (self.one, self.other)

    def beside(self, link: str) -> str:
        """The other link of the two."""
        return self.other if link == self.one else self.one
