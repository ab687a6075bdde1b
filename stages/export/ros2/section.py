"""Defines the configuration of the ROS 2 package."""

import re
from typing import Annotated

from pydantic import AfterValidator

from linkwright.stages.export.configuration.format_section import FormatSection
from linkwright.stages.robot.section import Text, example, invalid


def _as_package(name: str) -> str:
    """Returns the name if REP 144 allows it for a package; raises a validation error otherwise."""
    if not re.fullmatch("[a-z][a-z0-9]*(_[a-z0-9]+)*", name) or len(name) < 2:
        raise invalid("must be the name of a ROS package: a lower-case letter, then a-z, 0-9 and single _")
    return name


def _as_version(text: str) -> str:
    """Returns the version if package.xml allows it; raises a validation error otherwise."""
    if not re.fullmatch(r"\d+\.\d+\.\d+", text, re.ASCII):
        raise invalid("must be three whole numbers with points, as 1.0.0")
    return text


def _as_address(text: str) -> str:
    """Returns the email address if it is valid; raises a validation error otherwise."""
    if not re.fullmatch(r"[A-Za-z0-9_%+-]+(\.[A-Za-z0-9_%+-]+)*@([A-Za-z0-9-]+\.)+[A-Za-z]{2,}", text):
        raise invalid("must be an email address, which package.xml requires")
    return text


class Ros2FormatSection(FormatSection):
    """The ROS 2 package."""

    files = ("ros2/*",)

    package: Annotated[Text, AfterValidator(_as_package), example("my_arm_description")] | None = None
    """Name of the package and of its folder in `ros2/`; null: `<name>_description`."""

    version: Annotated[Text, AfterValidator(_as_version), example("1.0.0")] = "0.0.0"
    """Version of the package."""

    maintainer: Annotated[Text, example("Ada Lovelace")] = "TODO"
    """Name of the maintainer. The default, and those of `email` and `license`, are those of `ros2 pkg
    create`."""

    email: Annotated[Text, AfterValidator(_as_address), example("ada@example.com")] = "user@todo.todo"
    """Email address of the maintainer."""

    license: Annotated[Text, example("Apache-2.0")] = "TODO: License declaration"
    """License of the package."""

    moveit: bool = True
    """Whether a second package with the SRDF, for MoveIt, is written beside it: `<name>_moveit_config`."""
