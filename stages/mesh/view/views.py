"""Makes the views of a geometry: the file that the mesh stage writes beside its value."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from linkwright.stages.mesh import Memo
    from linkwright.stages.robot.model.geometry import Geometry

PICTURES = "pictures.json"


def views(geometry: Geometry, memo: Memo) -> dict[str, bytes]:
    """Returns the pictures of links with judged colliders, by file name; no file if no collider was
    judged."""
    # Late: only a page that shows colliders needs it.
    from linkwright.stages.mesh.view.pictures import pictures

    table = pictures(geometry, memo)
    return {PICTURES: table} if table else {}
