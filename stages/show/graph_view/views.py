"""Names the views of a robot: files of the graph stage beside its value."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from linkwright.stages.robot.model.robot import Robot

PICTURE, OUTLINE, TABLES = "graph.svg", "outline.txt", "tables.json"
NARROW_OUTLINE = "narrow_outline.txt"
"""The outline for a terminal that is too narrow for `OUTLINE`."""

VIEWS = (PICTURE, OUTLINE, NARROW_OUTLINE, TABLES)


def views(robot: "Robot") -> dict[str, bytes]:
    """Draws the picture, the outlines and the tables; returns them by file name."""
    # Late: views from the cache are not drawn again.
    from linkwright.stages.show.graph_view.draw_views import drawn_views

    return dict(zip(VIEWS, drawn_views(robot), strict=True))
