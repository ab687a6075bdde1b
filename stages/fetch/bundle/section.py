"""Configuration of the source `bundle`."""

from typing import Annotated, Literal

from linkwright.stages.fetch.source_section import SourceSection
from linkwright.stages.robot.section import Text, example


class BundleSourceSection(SourceSection):
    """A bundle: a zip file of all that an earlier build fetched."""

    kind: Literal["bundle"] = "bundle"
    """Kind of the source; `source=KIND` chooses it."""

    path: Annotated[Text, example("arm.zip")]
    """The zip file, relative to the working directory."""
