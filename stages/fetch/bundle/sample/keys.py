"""Configuration of the source `sample`."""

from typing import Literal

from stages.fetch.source_keys import SourceKeys


class SampleSourceKeys(SourceKeys):
    """The sample robot, which the package contains."""

    kind: Literal["sample"] = "sample"
    """Kind of the source; `source=KIND` chooses it."""


KEYS = SampleSourceKeys
