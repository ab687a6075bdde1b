"""Finds the build that a user names."""

from pathlib import Path

from linkwright.pipeline.errors import ConfigError
from linkwright.pipeline.output.manifest import is_build


def find(name: str, verb: str) -> Path:
    """Returns the folder of a build: `outputs/<name>`, else `name`; raises ConfigError if neither holds a
    build."""
    candidates = [Path("outputs") / name, Path(name)]
    for candidate in candidates:
        if is_build(candidate):
            return candidate
    similar = sorted(str(candidate) for candidate in _siblings(Path("outputs"), name) if is_build(candidate))
    hint = (
        f"there is {', '.join(similar)}: name it"
        if similar
        else "build it first, or name the folder of a build"
    )
    msg = f"there is no build in {candidates[0]} or {candidates[1]}"
    raise ConfigError(msg, verb, hint)


def _siblings(folder: Path, name: str) -> list[Path]:
    """Returns the folders whose names extend `name`: outputs of earlier stages or of failed builds."""
    try:
        return [place for place in folder.iterdir() if place.name.startswith(f"{name}.")]
    except OSError:
        return []
