"""The views of a geometry: a file of the mesh stage beside its value."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from linkwright.stages.mesh import Memo
    from linkwright.stages.robot.model.geometry import Geometry

PICTURES = "pictures.json"


def views(geometry: Geometry, memo: Memo) -> dict[str, bytes]:
    """The pictures of links whose colliders were judged, by file name; no file where none was."""
    # Late: only a page that shows colliders needs it.
    from linkwright.stages.mesh.view.pictures import pictures

    drawn = pictures(geometry, memo)
    return {PICTURES: drawn} if drawn else {}
