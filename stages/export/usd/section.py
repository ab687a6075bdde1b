"""Configuration of the USD writer."""

from typing import Annotated, Literal

from pydantic import StringConstraints

from linkwright.stages.export.configuration.format_section import FormatSection
from linkwright.stages.robot.section import Text, example


class UsdFormatSection(FormatSection):
    """The USD."""

    files = ("<name>.usda", "<name>_meshes.usd", ".thumbs/256x256/<name>.usda.png")

    geometry: Literal["binary", "text"] = "binary"
    """Encoding of the layer `<name>_meshes.usd`, which has the points of all meshes. binary: small, and quick
    to load; text: readable and easy to compare, five times as large."""

    author: Annotated[Text, example("Ada Lovelace")] = "unspecified"
    """Author, in the metadata of SimReady that the USD has."""

    license: Annotated[Text, example("CC-BY-4.0")] = "unspecified"
    """Licence of the robot, in the same metadata."""

    category: Annotated[Text, example("robot arm")] = "robot"
    """What sort of thing the robot is, in the same metadata."""

    qcode: Annotated[str, StringConstraints(strict=True, pattern="^Q[0-9]+$"), example("Q337121")] = "Q11012"
    """Item of Wikidata for what the robot is, in the same metadata; Q11012: a robot."""

    date: Annotated[Text | None, example("2026-08-31")] = None
    """Date of the USD, in the same metadata; null: that of the variable SOURCE_DATE_EPOCH, else unspecified.
    The time of a build is not used: the same input gives the same bytes."""
