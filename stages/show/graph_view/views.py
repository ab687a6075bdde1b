"""The views of a robot: files of the graph stage beside its value."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from linkwright.stages.robot.model.robot import Robot

PICTURE, OUTLINE, TABLES = "graph.svg", "outline.txt", "tables.json"
NARROW_OUTLINE = "narrow_outline.txt"
"""The outline for a terminal that is too narrow for the other."""

VIEWS = (PICTURE, OUTLINE, NARROW_OUTLINE, TABLES)


def views(robot: "Robot") -> dict[str, bytes]:
    """The picture, the outlines and the tables, by file name."""
    # Late: what was drawn before is not drawn again.
    from linkwright.stages.show.graph_view.outline import NARROW, outline
    from linkwright.stages.show.graph_view.picture import draw
    from linkwright.stages.show.graph_view.tables import tables

    return {
        PICTURE: draw(robot),
        OUTLINE: outline(robot).encode(),
        NARROW_OUTLINE: outline(robot, NARROW).encode(),
        TABLES: tables(robot),
    }
