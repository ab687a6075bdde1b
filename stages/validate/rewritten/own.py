"""What of a package is for its user to set: what a build writes there is a start."""

import re
from collections.abc import Mapping
from typing import Literal

from linkwright.stages.validate.rewritten.compare import Difference

Weight = Literal["error", "warning", ""]
"""What a difference is: a fault; something that its user may have meant; nothing."""

DESCRIBES = (".urdf", ".xacro", ".srdf")
"""Endings of files that say what the robot is: nothing may be added to these."""

OWN: Mapping[str, str] = {
    "package.xml": "package (version|description|maintainer|license|author|url) .*",
    "pyproject.toml": "project (?!name|readme).*",
    "__init__.py": "__version__",
    ".setup_assistant": "moveit_setup_assistant_config package_settings .*",
    ".rviz": ".* (Background Color|Frame Rate|Name)",
}
"""By the end of a file's name: the facts that are nobody's but the user's."""

TUNED: Mapping[str, str] = {
    "controllers.yaml": "controller_manager ros__parameters update_rate",
    "joint_limits.yaml": "default_.*|joint_limits .* (has_acceleration_limits|max_acceleration)",
    "kinematics.yaml": ".*",
    "pilz_cartesian_limits.yaml": ".*",
}
"""The facts that are set by what the hardware can do."""


def weight_of(name: str, difference: Difference) -> Weight:
    """Of a difference in the file of this name."""
    place = " ".join(difference.path)
    if difference.change != "missing" and _has(OWN, name, place):
        return ""
    if name.endswith(".rviz") and difference.change != "missing" and _is_look(difference):
        return ""
    if difference.change == "added" and not name.endswith(DESCRIBES):
        return "warning"
    return "warning" if _has(TUNED, name, place) else "error"


def _has(table: Mapping[str, str], name: str, place: str) -> bool:
    return any(re.fullmatch(facts, place) for end, facts in table.items() if name.endswith(end))


def _is_look(difference: Difference) -> bool:
    """Whether it is a number or a switch of RViz, or more of what it shows."""
    message = difference.finding.message
    return difference.change == "added" or '"' not in message
