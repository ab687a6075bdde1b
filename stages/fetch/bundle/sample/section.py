"""Configuration of the source `sample`."""

from typing import Literal

from linkwright.stages.fetch.source_section import SourceSection


class SampleSourceSection(SourceSection):
    """The sample robot, which the package contains."""

    kind: Literal["sample"] = "sample"
    """Kind of the source; `source=KIND` chooses it."""
