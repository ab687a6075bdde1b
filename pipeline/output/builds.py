"""Finds the build that a user names."""

from pathlib import Path

from linkwright.pipeline.errors import ConfigError
from linkwright.pipeline.output.manifest import is_build


def find(name: str, verb: str) -> Path:
    """The folder of a build: `outputs/<name>`, else `name`; ConfigError if neither holds a build."""
    places = [Path("outputs") / name, Path(name)]
    for place in places:
        if is_build(place):
            return place
    kin = sorted(str(place) for place in _siblings(Path("outputs"), name) if is_build(place))
    there = f"there is {', '.join(kin)}: name it" if kin else "build it first, or name the folder of a build"
    msg = f"there is no build in {places[0]} or {places[1]}"
    raise ConfigError(msg, verb, there)


def _siblings(folder: Path, name: str) -> list[Path]:
    """The folders beside the output of that name: of an earlier stage, or of a failed build."""
    try:
        return [place for place in folder.iterdir() if place.name.startswith(f"{name}.")]
    except OSError:
        return []
