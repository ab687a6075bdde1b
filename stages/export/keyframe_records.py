"""What robot.json says of named poses."""

from typing import Any

from stages.export.json_values import as_value
from stages.robot.model import Robot
from stages.robot.start_pose import SAVED, keyframes


def keyframe_records(robot: Robot) -> list[dict[str, Any]]:
    """A record of each but the saved pose, which is with the dofs: the values of all dofs, also of loops, and
    those that the user gives."""
    given = {one.name: dict(one.given) for one in robot.keyframes}
    return [
        {
            "name": name,
            "given": {dof: as_value(value) for dof, value in given.get(name, {}).items()},
            "values": {dof: as_value(value) for dof, value in values.items()},
        }
        for name, values in keyframes(robot).items()
        if name != SAVED
    ]
