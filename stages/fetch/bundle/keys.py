"""Configuration of the source `bundle`."""

from typing import Annotated, Literal

from stages.fetch.source_keys import SourceKeys
from stages.robot.keys import Text, example


class BundleSourceKeys(SourceKeys):
    """A bundle: a zip file of all that an earlier build fetched."""

    kind: Literal["bundle"] = "bundle"
    """Kind of the source; `source=KIND` chooses it."""

    path: Annotated[Text, example("arm.zip")]
    """The zip file, relative to the working directory."""


KEYS = BundleSourceKeys
