"""Derives the names of packages from the name of a robot."""

import re


def stem_of(robot_name: str) -> str:
    """Returns the stem of the package names of a robot: a letter, then a-z, 0-9 and single underscores (REP
    144)."""
    stem = re.sub("[^a-z0-9]+", "_", robot_name.lower()).strip("_") or "robot"
    return stem if stem[0].isalpha() else f"robot_{stem}"


def package_of(robot_name: str) -> str:
    """Returns the default name of a robot's package."""
    stem = stem_of(robot_name)
    return stem if stem.endswith("_description") else f"{stem}_description"
