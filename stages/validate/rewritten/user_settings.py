"""Lists the facts of a package that its user may set, since a build writes only first values."""

import re
from collections.abc import Mapping
from typing import Literal

from linkwright.stages.validate.rewritten.compare import Difference

Weight = Literal["error", "warning", ""]
"""The weight of a difference: a fault; a possible choice of the user; none."""

ROBOT_ENDINGS = (".urdf", ".xacro", ".srdf")
"""Endings of files that describe the robot, to which nothing may be added."""

USER_FACTS: Mapping[str, str] = {
    "package.xml": "package (version|description|maintainer|license|author|url) .*",
    "pyproject.toml": "project (?!name|readme).*",
    "__init__.py": "__version__",
    ".setup_assistant": "moveit_setup_assistant_config package_settings .*",
    ".rviz": ".* (Background Color|Frame Rate|Name)",
}
"""End of a file's name → pattern of the facts that only the user decides."""

HARDWARE_FACTS: Mapping[str, str] = {
    "controllers.yaml": "controller_manager ros__parameters update_rate",
    "joint_limits.yaml": "default_.*|joint_limits .* (has_acceleration_limits|max_acceleration)",
    "kinematics.yaml": ".*",
    "pilz_cartesian_limits.yaml": ".*",
}
"""End of a file's name → pattern of the facts that depend on the hardware."""


def weight_of(name: str, difference: Difference) -> Weight:
    """Returns the weight of a difference in the file of this name."""
    place = " ".join(difference.path)
    if difference.change != "missing" and _lists_fact(USER_FACTS, name, place):
        return ""
    if name.endswith(".rviz") and difference.change != "missing" and _is_look(difference):
        return ""
    if difference.change == "added" and not name.endswith(ROBOT_ENDINGS):
        return "warning"
    return "warning" if _lists_fact(HARDWARE_FACTS, name, place) else "error"


def _lists_fact(table: Mapping[str, str], name: str, place: str) -> bool:
    return any(re.fullmatch(facts, place) for ending, facts in table.items() if name.endswith(ending))


def _is_look(difference: Difference) -> bool:
    """Tells whether a difference is a number or a switch of RViz, or an additional display."""
    # Only texts are quoted in messages. A file that cannot be read differs as a whole, without a path.
    is_number = bool(difference.path) and '"' not in difference.finding.message
    return difference.change == "added" or is_number
