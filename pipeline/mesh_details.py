"""What the report tells of a robot's geometry besides its figures, and what the terminal shows meanwhile."""

from collections.abc import Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from stages.robot.plural import count

if TYPE_CHECKING:
    from pipeline.context import BuildContext
    from stages.mesh import Shown
    from stages.robot.geometry import ColliderFigures, Geometry

_MM = 1e3


def details(geometry: "Geometry") -> dict[str, Any]:
    """`colliders`: how the parts of each link collide, lengths in mm, volumes as shares of the part's.

    `excludes`: the pairs of links that do not collide with each other, why, and how deep they are in each
    other at `home` [mm]; nothing where the robot does not collide with itself.
    """
    excludes = [
        {"links": [one.link_a, one.link_b], "reason": one.reason, "depth": round(_MM * one.depth, 3)}
        for one in geometry.excludes
    ]
    colliders = [_collider(one) for one in geometry.colliders]
    return {**({"colliders": colliders} if colliders else {}), **({"excludes": excludes} if excludes else {})}


def _collider(one: "ColliderFigures") -> dict[str, Any]:
    row = asdict(one)
    measures = row.pop("measures") or {}
    row["tolerance"] = None if one.tolerance is None else round(_MM * one.tolerance, 4)
    for name, value in measures.items():
        of_length = name.startswith(("protrusion", "bareness"))
        row[name] = round(_MM * value, 4) if of_length else value
    return row


def shown(context: "BuildContext") -> "Shown":
    """Shows which parts get their colliders."""

    def show(running: Sequence[str], done: int, total: int) -> None:
        context.transient(f"colliders: {done} of {count(total, 'part')}, now {', '.join(running)}")

    return show
