"""Configuration of the source `sample`."""

from typing import Literal

from linkwright.stages.fetch.source_section import SourceSection


class SampleSourceSection(SourceSection):
    """A robot of the gallery, which the package contains."""

    kind: Literal["sample"] = "sample"
    """Kind of the source; `source=KIND` chooses it."""

    robot: Literal["sample", "quadruped", "delta", "rover", "hand"] = "sample"
    """The robot. sample: a desk arm with a gripper; quadruped: four legs under a free base; delta: a platform
    on three arms and six rods; rover: wheels, a lift with a gripper, and a camera; hand: coupled fingers."""
