"""Reads the torque check as a number: the share of a joint's strength that the robot's weight takes."""

from collections.abc import Iterable

from linkwright.stages.robot.check import Check

CODE = "C-TORQUE"
"""Code of the torque check."""


def torque_value(checks: Iterable[Check]) -> float | None:
    """Returns the largest share over the joints. Returns None if the check did not run, or if no joint that
    holds the robot has a limited force."""
    torque = next((check for check in checks if check.code == CODE), None)
    if torque is None or torque.table is None:
        return None
    # The last column is the share, empty for a force without a limit.
    return torque.value if any(row[-1] is not None for row in torque.table.rows) else None
