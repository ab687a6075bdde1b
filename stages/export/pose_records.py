"""What robot.json says of named poses, and of all else that its source's SRDF says."""

from typing import Any

from stages.export.json_values import as_value
from stages.robot.codec import plain
from stages.robot.model import Robot
from stages.robot.semantics import NOTHING_MORE
from stages.robot.start_pose import SAVED, keyframes


def pose_records(robot: Robot) -> dict[str, Any]:
    """The tables `keyframes`: a record of each but the saved pose, which is with the dofs, with the values of
    all dofs, also of loops, and those that the user gives; and `semantics`, where the source has an SRDF."""
    given = {one.name: dict(one.given) for one in robot.keyframes}
    poses = [
        {
            "name": name,
            "given": {dof: as_value(value) for dof, value in given.get(name, {}).items()},
            "values": {dof: as_value(value) for dof, value in values.items()},
        }
        for name, values in keyframes(robot).items()
        if name != SAVED
    ]
    return {"keyframes": poses} | (
        {} if robot.semantics == NOTHING_MORE else {"semantics": plain(robot.semantics)}
    )
