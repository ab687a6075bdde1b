"""Defines the configuration of the Python package."""

import keyword
import re
from typing import Annotated

from pydantic import AfterValidator

from linkwright.stages.export.configuration.format_section import FormatSection
from linkwright.stages.robot.section import Text, example, invalid


def _check_package(name: str) -> str:
    module = import_name(name)
    # Names of PEP 508 in lower case that also give a valid module name.
    if not re.fullmatch("[a-z][a-z0-9]*([._-][a-z0-9]+)*", name) or keyword.iskeyword(module):
        raise invalid(
            "must be a package name: a lower-case letter first, words of a-z and 0-9 joined by single - _ "
            "or ., and no keyword of Python"
        )
    return name


def _check_version(text: str) -> str:
    # PEP 440, without epochs, and without local versions, which PyPI refuses.
    if not re.fullmatch(r"\d+(\.\d+)*((a|b|rc)\d+)?(\.post\d+)?(\.dev\d+)?", text, re.ASCII):
        raise invalid("must be a version such as 1.0 or 1.2.0rc1")
    return text


def import_name(package: str) -> str:
    """Returns the import name of a package."""
    return re.sub("[.-]", "_", package)


class PythonFormatSection(FormatSection):
    """Configuration of the Python package with the robot's files."""

    files = ("python/*",)

    package: Annotated[Text, AfterValidator(_check_package), example("my-arm-description")] | None = None
    """Name of the package for pip. Its import name has `_` in place of `-` and `.`. null:
    `<name>_description`."""

    version: Annotated[Text, AfterValidator(_check_version), example("1.0.0")] = "0.0.0"
    """Version of the package."""

    author: Annotated[Text, example("Ada Lovelace")] | None = None
    """Author of the robot."""

    license: Annotated[Text, example("Apache-2.0")] | None = None
    """License of the package."""
