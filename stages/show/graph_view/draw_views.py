"""Draws all views of a robot."""

from linkwright.stages.robot.model.robot import Robot
from linkwright.stages.show.graph_view.outline import NARROW, outline
from linkwright.stages.show.graph_view.picture import draw
from linkwright.stages.show.graph_view.tables import tables


def drawn_views(robot: Robot) -> tuple[bytes, ...]:
    """Returns the picture, the outline, the narrow outline and the tables, in the order of `views.VIEWS`."""
    return draw(robot), outline(robot).encode(), outline(robot, NARROW).encode(), tables(robot)
