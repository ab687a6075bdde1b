"""Expands trusted xacro files with ROS's own `xacro` package, in a guest process.

A xacro file is a program: its expressions can do what Python can. So only a file that ends in .xacro is
expanded, only with `source.trust`, and in a process that sees neither the environment nor a terminal.
"""

from __future__ import annotations

import importlib.util
import json
import re
import time
from collections.abc import Callable, Mapping
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

from linkwright.stages.fetch.urdf.ros_packages import VARIABLES
from linkwright.stages.fetch.urdf.text import LARGEST
from linkwright.stages.robot.errors import ConfigError, SourceError
from linkwright.stages.robot.system import guest
from linkwright.stages.robot.system.install import install

if TYPE_CHECKING:
    from linkwright.stages.fetch.urdf.section import UrdfSourceSection

BOUNDS = guest.Bounds(seconds=60, memory=2 << 30, reply=LARGEST + (1 << 16))
"""Limits of the guest process: xacro files of whole humanoids take some seconds."""

EXPAND_HINT = "expand it yourself: xacro FILE > robot.urdf"

_PACKAGE_HINT = "name its folder by source.packages={%s: FOLDER}"
_HINTS = {
    "Undefined substitution argument": "give the arguments of the xacro file by source.args={name: value}",
    "environment variable": "a xacro file can read only ROS's variables: " + EXPAND_HINT,
}
"""Words in an error of xacro → the hint."""

_FIND = re.compile(r"\$\(\s*find\s+([^\s()$]+)\s*\)")
_MAX_PACKAGES = 100
"""Largest number of packages whose folders are given to xacro."""

_MAX_MESSAGE = 500
"""Largest length of an error of xacro in a message."""


def is_named(path: Path) -> bool:
    """Tells whether the name of a file ends in .xacro."""
    return path.suffix.lower() == ".xacro"


def require(source: UrdfSourceSection) -> None:
    """Raises ConfigError if the source is a xacro file, and the file is not trusted or the package `xacro` is
    not installed."""
    if not is_named(Path(source.path)):
        return
    if not source.trust:
        msg = f"{source.path} is a xacro file, which is a program: expanding it runs it"
        hint = f"if you trust it, set source.trust=true on the command line, or {EXPAND_HINT}"
        raise ConfigError(msg, "source.trust", hint)
    if importlib.util.find_spec("xacro") is None:
        msg = f"{source.path} is a xacro file, and the package xacro, which expands it, is not installed"
        raise ConfigError(msg, "source.path", f"{install('xacro')}, or {EXPAND_HINT}")


def expand_xacro(
    source: UrdfSourceSection, text: str, environ: Mapping[str, str], find: Callable[[str], Path | None]
) -> str:
    """Returns the URDF that the source's xacro file, with the content `text`, makes. `find`: returns a
    package's folder by its name.

    Raises the errors of `require`, and SourceError if xacro cannot expand the file within its limits.
    """
    require(source)
    path = Path(source.path).absolute()
    packages = {name: find(name) for name in islice(dict.fromkeys(_FIND.findall(text)), _MAX_PACKAGES)}
    deadline = time.monotonic() + BOUNDS.seconds
    while True:
        request = {
            "path": str(path),
            "args": {name: _text(value) for name, value in source.args.items()},
            "packages": {name: str(place) for name, place in packages.items() if place is not None},
        }
        text_made, missing_package, fault = _guest_reply(request, path.name, environ)
        if missing_package and len(packages) < _MAX_PACKAGES and missing_package not in packages:
            # The name is in an included file, or is computed as the file is expanded.
            packages[missing_package] = find(missing_package)
            if packages[missing_package] is not None and time.monotonic() < deadline:
                continue
        if missing_package:
            raise _refused(
                f"there is no package {missing_package}", path.name, _PACKAGE_HINT % missing_package
            )
        if fault:
            fault = " ".join(fault.replace(f"{path.parent}/", "").split())[:_MAX_MESSAGE]
            raise _refused(
                fault, path.name, next((hint for words, hint in _HINTS.items() if words in fault), "")
            )
        return text_made


def _guest_reply(request: Mapping[str, Any], where: str, environ: Mapping[str, str]) -> tuple[str, str, str]:
    """Runs the guest; returns the expanded text, or the missing package, or xacro's error."""
    variables = {name: environ[name] for name in VARIABLES if name in environ}
    try:
        reply = guest.ask(
            "linkwright.stages.fetch.urdf.expand_guest", json.dumps(request).encode(), BOUNDS, variables
        )
    except guest.Ended as ended:
        raise _refused(f"it {ended}", where, f"look for an endless recursion, or {EXPAND_HINT}") from None
    head, _, output = reply.partition(b"\n")
    try:
        answer = json.loads(head)
        return output.decode(), str(answer["lacking"]), str(answer["refused"])
    except (ValueError, KeyError, TypeError, RecursionError):
        raise _refused("xacro's output is not text", where, f"check the file, or {EXPAND_HINT}") from None


def _refused(why: str, where: str, hint: str) -> SourceError:
    return SourceError(f"xacro cannot expand it: {why}", where, hint)


def _text(value: Any) -> str:
    """Returns a value as it is written on xacro's command line."""
    return str(value).lower() if isinstance(value, bool) else str(value)
