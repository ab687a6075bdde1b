"""Configuration of the Python package."""

import keyword
import re
from typing import Annotated

from pydantic import AfterValidator

from linkwright.stages.export.configuration.format_section import FormatSection
from linkwright.stages.robot.section import Text, example, invalid


def _as_package(name: str) -> str:
    module = module_of(name)
    # PEP 508, without what would be no name of a module.
    if not re.fullmatch("[a-z][a-z0-9]*([._-][a-z0-9]+)*", name) or keyword.iskeyword(module):
        raise invalid("must be the name of a package: a lower-case letter, then a-z, 0-9 and single - _ .")
    return name


def _as_version(text: str) -> str:
    # PEP 440, without epochs and local versions, which no index takes.
    if not re.fullmatch(r"\d+(\.\d+)*((a|b|rc)\d+)?(\.post\d+)?(\.dev\d+)?", text, re.ASCII):
        raise invalid("must be a version, as 1.0 or 1.2.0rc1")
    return text


def module_of(package: str) -> str:
    """The name by which a package is imported."""
    return re.sub("[.-]", "_", package)


class PythonFormatSection(FormatSection):
    """The Python package."""

    files = ("python/*",)

    package: Annotated[Text, AfterValidator(_as_package), example("my-arm-description")] | None = None
    """Its name for pip; it is imported by that with `_` for `-`. null: `<name>_description`."""

    version: Annotated[Text, AfterValidator(_as_version), example("1.0.0")] = "0.0.0"
    """Its version."""

    author: Annotated[Text, example("Ada Lovelace")] | None = None
    """Who made the robot."""

    license: Annotated[Text, example("Apache-2.0")] | None = None
    """Its license."""
