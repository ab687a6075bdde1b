"""Derives the names of packages from the name of a robot."""

import re


def stem_of(robot: str) -> str:
    """Returns the start of a package's name from a robot's: a letter, then a-z, 0-9 and single _ (REP
    144)."""
    stem = re.sub("[^a-z0-9]+", "_", robot.lower()).strip("_") or "robot"
    return stem if stem[0].isalpha() else f"robot_{stem}"


def package_of(robot: str) -> str:
    """Returns the default name of a robot's package."""
    stem = stem_of(robot)
    return stem if stem.endswith("_description") else f"{stem}_description"
