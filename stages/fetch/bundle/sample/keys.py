"""Configuration of the source `sample`."""

from typing import Literal

from stages.fetch.source_keys import SourceKeys


class SampleSourceKeys(SourceKeys):
    """The robot that is shipped with the package."""

    kind: Literal["sample"] = "sample"
    """Tells the sources apart."""


KEYS = SampleSourceKeys
