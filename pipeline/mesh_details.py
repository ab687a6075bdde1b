"""What the report tells of a robot's geometry, besides its figures."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from stages.robot.geometry import Geometry


def details(geometry: "Geometry") -> dict[str, Any]:
    """`excludes`: the pairs of links that do not collide with each other, why, and how deep they are in each
    other at `home` [mm]; nothing where the robot does not collide with itself."""
    rows = [
        {"links": [one.link_a, one.link_b], "reason": one.reason, "depth": round(1e3 * one.depth, 3)}
        for one in geometry.excludes
    ]
    return {"excludes": rows} if rows else {}
