"""Prints the lowest version that pyproject.toml allows of every dependency, as constraints for pip."""

import re
import tomllib
from collections.abc import Iterator
from pathlib import Path

PROJECT = Path(__file__).resolve().parents[1] / "pyproject.toml"
FLOOR = re.compile(r"([\w.-]+)>=([\w.]+)")


def requirements() -> Iterator[str]:
    """Every requirement that is not an extra of our own."""
    stated = tomllib.loads(PROJECT.read_text())
    extras = stated["project"]["optional-dependencies"].values()
    for group in (stated["build-system"]["requires"], stated["project"]["dependencies"], *extras):
        yield from (one for one in group if not one.startswith("linkwright["))


def floors() -> dict[str, str]:
    """The lowest version that is allowed, by package."""
    return dict(FLOOR.match(one).groups() for one in requirements())


if __name__ == "__main__":
    print("\n".join(f"{name}=={version}" for name, version in floors().items()))
