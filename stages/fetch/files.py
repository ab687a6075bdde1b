"""The files behind the sources that are files."""

from importlib.resources import files
from pathlib import Path
from typing import Any

from stages.fetch import regular_files
from stages.robot.errors import ConfigError, SourceError

LARGEST = 1 << 30
"""Larger bundles are not read: neither as a file nor unpacked [bytes]."""

_SAMPLE = "sample.zip"


def label(source: Any) -> str:
    """What a source is called in messages: its path as the user wrote it, or the sample."""
    return "the sample" if source.kind == "sample" else str(source.path)


def require(source: Any) -> None:
    """ConfigError where `source.path` is no file, or a package of a robot's file is no folder."""
    path = Path(source.path)
    if not regular_files.is_file(path):
        wanted, example = _WANTED[source.kind]
        what = f"is a folder, and {wanted}" if path.is_dir() else "does not exist"
        if regular_files.is_special(path):
            what = f"is no such file: {regular_files.NOT_REGULAR}"
        hint = f"paths start from the working folder; give one such as {example}"
        raise ConfigError(f"{source.path} {what}", "source.path", hint)
    if source.kind == "urdf":
        _require_urdf(source)


def _require_urdf(source: Any) -> None:
    from stages.fetch.urdf import expand

    for name, folder in source.packages.items():
        if not Path(folder).is_dir():
            hint = "name the folder that holds the package's own, such as meshes/"
            raise ConfigError(f"{folder} is no folder", f"source.packages.{name}", hint)
    expand.require(source)


def content(source: Any) -> bytes:
    """The bytes of the source's zip; SourceError where it cannot be read."""
    try:
        if source.kind == "sample":
            return files("stages.fetch").joinpath(_SAMPLE).read_bytes()
        return regular_files.content(Path(source.path), LARGEST)
    except regular_files.TooLarge as error:
        msg = f"not readable as a bundle: it has {error.size} bytes; at most {LARGEST} are read"
        raise SourceError(msg, label(source), "check that source.path names the right file") from None
    except OSError as error:
        msg = f"it cannot be read: {error.strerror or type(error).__name__}"
        hint = (
            "install linkwright again" if source.kind == "sample" else "check source.path and its permissions"
        )
        raise SourceError(msg, label(source), hint) from error


_WANTED = {
    "bundle": ("a bundle is a zip file", "robots/arm.zip"),
    "urdf": ("a URDF is a file", "robots/arm.urdf"),
    "mjcf": ("an MJCF is a file", "robots/arm.xml"),
}
