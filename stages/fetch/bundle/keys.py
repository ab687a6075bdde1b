"""Configuration of the source `bundle`."""

from typing import Literal

from stages.fetch.source_keys import SourceKeys
from stages.robot.keys import Text


class BundleSourceKeys(SourceKeys):
    """A bundle: the replies of an earlier fetch in one zip."""

    kind: Literal["bundle"] = "bundle"
    """Tells the sources apart."""

    path: Text
    """The zip file, relative to the working directory."""


KEYS = BundleSourceKeys
