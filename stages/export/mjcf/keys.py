"""Configuration of the MJCF writer."""

from stages.robot.keys import Keys


class MjcfFormatKeys(Keys):
    """The MJCF and its scene."""


KEYS = MjcfFormatKeys
