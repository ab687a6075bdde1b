"""Configuration of the source `mjcf`."""

from typing import Literal

from stages.fetch.source_keys import SourceKeys
from stages.robot.keys import Text


class MjcfSourceKeys(SourceKeys):
    """An MJCF, MuJoCo's own format, as MuJoCo compiles it."""

    kind: Literal["mjcf"] = "mjcf"
    """Tells the sources apart."""

    path: Text
    """The file, relative to the working directory."""


KEYS = MjcfSourceKeys
