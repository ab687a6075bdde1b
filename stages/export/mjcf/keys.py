"""Configuration of the MJCF writer."""

from stages.robot.keys import Keys


class MjcfKeys(Keys):
    """The MJCF and its scene."""


KEYS = MjcfKeys
