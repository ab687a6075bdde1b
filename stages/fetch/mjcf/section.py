"""Configuration of the source `mjcf`."""

from typing import Annotated, Literal

from linkwright.stages.fetch.source_section import SourceSection
from linkwright.stages.robot.section import Text, example


class MjcfSourceSection(SourceSection):
    """An MJCF (MuJoCo XML), as MuJoCo compiles it."""

    kind: Literal["mjcf"] = "mjcf"
    """Kind of the source; `source=KIND` chooses it."""

    path: Annotated[Text, example("arm.xml")]
    """The file, relative to the working directory."""
