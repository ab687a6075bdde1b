"""Configuration of the source `sample`."""

from typing import Literal

from linkwright.stages.fetch.source_section import SourceSection


class SampleSourceSection(SourceSection):
    """A robot of the gallery, which the package contains."""

    kind: Literal["sample"] = "sample"
    """Kind of the source; `source=KIND` chooses it."""

    robot: Literal["sample", "quadruped"] = "sample"
    """The robot. sample: a desk arm with a gripper; quadruped: four legs under a free base."""
