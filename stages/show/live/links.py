"""Describes the links for the header: their CAD parts, masses, and the fit of their colliders."""

from collections.abc import Iterable, Mapping
from typing import Any

from linkwright.stages.robot.model.robot import Part, Robot
from linkwright.stages.show.live.rounding import rounded


def links(robot: Robot, colliders: Iterable[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Returns each link with its parts and its colliders. `colliders`: the rows of the table of colliders in
    the build's report, with lengths in mm."""
    colliders_of_link: dict[str, list[dict[str, Any]]] = {}
    for row in colliders:
        colliders_of_link.setdefault(row["link"], []).append(_collider(row))
    return [
        {
            "name": link.name,
            "mass": rounded(link.inertial.mass),
            "parts": [
                {"name": _name(part), "mass": rounded(part.inertial.mass) or None} for part in link.parts
            ],
            "colliders": colliders_of_link.get(link.name, []),
        }
        for link in robot.links
    ]


def _name(part: Part) -> str:
    return part.name or "/".join(part.path)


def _collider(row: Mapping[str, Any]) -> dict[str, Any]:
    return {
        "part": ", ".join(row["parts"]),
        "made": row["rung"] or row["maker"],
        "tolerance_mm": row["tolerance"],
        "stands_out_mm": row.get("protrusion_max"),
        "bare_mm": row.get("bareness_max"),
        "within": bool(row["meets"]),
    }
