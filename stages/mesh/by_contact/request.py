"""Defines the request for colliders by contact, and the pairs of links whose colliders touch falsely."""

from __future__ import annotations

import importlib.metadata
import importlib.util
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from linkwright.stages.mesh.collide import collision
from linkwright.stages.mesh.motion_digest import motion_digest
from linkwright.stages.mesh.surfaces.pieces import Piece, placed
from linkwright.stages.robot.model.robot import Link, Robot
from linkwright.stages.robot.motion.adjacency import Pair

if TYPE_CHECKING:
    from linkwright.stages.mesh.collide.make import ColliderJob, MadeCollider

POSES = 512
"""Number of seeded poses for which colliders are made. With fewer, pairs that rarely touch falsely seem to do
so often: with 64 poses, 5 to 9 % of the pairs."""


@dataclass(frozen=True, slots=True, eq=False)
class ContactRequest:
    """The colliders that contact decides."""

    robot: Robot
    jobs: Sequence[ColliderJob]
    """Jobs, one for each collider."""
    fixed: Mapping[str, Sequence[Piece]]
    """Link → the pieces that stay as they are, in the link's frame."""
    apart: Collection[Pair] | None
    """Pairs of links that do not collide; None if no two links do."""
    fine: Collection[str] | None
    """Links that must be within their tolerance; None for the links that meet the world."""

    def key(self) -> dict[str, Any]:
        """Returns all that the colliders depend on, as plain data."""
        frames = sorted([frame.name, frame.link] for frame in self.robot.frames)
        return {
            "jobs": [[job.link, job.identity_data()] for job in self.jobs],
            "fixed": {link: collision.digest(pieces) for link, pieces in sorted(self.fixed.items())},
            "apart": None if self.apart is None else sorted(self.apart),
            "fine": frames if self.fine is None else [sorted(self.fine)],
            "motion": motion_digest(self.robot),
            "up": None if self.robot.base.fixed else self.robot.world_from_root[2, :3].tolist(),
            "poses": POSES,
            "engine": _engine(),
        }


def fixed_pieces(links: Sequence[Link], made_colliders: Sequence[MadeCollider]) -> dict[str, list[Piece]]:
    """Returns the pieces that collide whatever contact decides, by link: those of finished colliders, and the
    links' own primitives. Links without any are left out."""
    pieces_by_link: dict[str, list[Piece]] = {}
    for collider in made_colliders:
        pieces = [placed(piece, collider.job.link_from_subject) for piece in collider.collision.pieces]
        pieces_by_link.setdefault(collider.job.link, []).extend(pieces)
    for link in links:
        pieces_by_link.setdefault(link.name, []).extend(shape for shape in link.shapes if shape.collision)
    return {link: pieces for link, pieces in pieces_by_link.items() if pieces}


def _engine() -> str:
    name = "coal" if importlib.util.find_spec("coal") else "python-fcl"
    return f"{name} {importlib.metadata.version(name)}"


@dataclass(frozen=True, slots=True)
class FalsePair:
    """Two links whose colliders overlap while the links are apart, in too many of the poses, or at `home`."""

    one: str
    other: str
    share: float
    """Share of the poses in which the colliders touch falsely."""
    home: bool
    """Whether the colliders touch falsely at `home`."""
    depth: float
    """Largest overlap beyond the allowed overlap [m]."""

    def has(self, link: str) -> bool:
        """Tells whether the link is one of the two."""
        return link in (self.one, self.other)

    def beside(self, link: str) -> str:
        """Returns the other link of the two."""
        return self.other if link == self.one else self.one
