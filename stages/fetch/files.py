"""The files behind the sources `bundle` and `sample`."""

from importlib.resources import files
from pathlib import Path
from typing import Any

from stages.robot.errors import ConfigError, SourceError

LARGEST = 1 << 30
"""Larger bundles are not read: neither as a file nor unpacked [bytes]."""

_SAMPLE = "sample.zip"


def label(source: Any) -> str:
    """What a source is called in messages: its path as the user wrote it, or the sample."""
    return "the sample" if source.kind == "sample" else str(source.path)


def require(source: Any) -> None:
    """ConfigError where `source.path` is no file."""
    path = Path(source.path)
    if path.is_file():
        return
    what = "is a folder, and a bundle is a zip file" if path.is_dir() else "does not exist"
    msg = f"{source.path} {what}"
    raise ConfigError(msg, "source.path", f"paths start from the working folder; give one such as {_EXAMPLE}")


def content(source: Any) -> bytes:
    """The bytes of the source's zip; SourceError where it cannot be read."""
    try:
        if source.kind == "sample":
            return files("stages.fetch").joinpath(_SAMPLE).read_bytes()
        path = Path(source.path)
        size = path.stat().st_size
        if size > LARGEST:
            msg = f"not readable as a bundle: it has {size} bytes; at most {LARGEST} are read"
            raise SourceError(msg, label(source), "check that source.path names the right file")
        return path.read_bytes()
    except OSError as error:
        msg = f"it cannot be read: {error.strerror or type(error).__name__}"
        hint = (
            "install linkwright again" if source.kind == "sample" else "check source.path and its permissions"
        )
        raise SourceError(msg, label(source), hint) from error


_EXAMPLE = "robots/arm.zip"
