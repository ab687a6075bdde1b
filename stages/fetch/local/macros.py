"""xacro files, through ROS's own `xacro` package. A xacro file is a program: it is run, as in ROS."""

from __future__ import annotations

import contextlib
import importlib.util
import io
import re
from collections.abc import Callable, Iterator, Mapping
from itertools import islice
from pathlib import Path
from typing import Any

from stages.robot.errors import ConfigError, SourceError
from stages.robot.install import install

_PACKAGE = "name its folder by source.packages={%s: FOLDER}"
_ARGUMENT = "a xacro's arguments are given by source.args={name: value}"
_BOUND = re.compile(r"""xmlns:([\w.-]+)\s*=\s*["'][^"'<]*xacro/?["']""")

_MOST_PREFIXES = 20


def wanted(path: Path, text: str) -> bool:
    """Whether a file is to be expanded: it is called .xacro, or has elements of xacro's."""
    if is_named(path):
        return True
    bound = (found.group(1) for found in islice(_BOUND.finditer(text), _MOST_PREFIXES))
    return any(f"<{prefix}:" in text for prefix in {"xacro", *bound})


def is_named(path: Path) -> bool:
    """Whether a file is called .xacro."""
    return path.suffix.lower() == ".xacro"


def require(where: str) -> None:
    """ConfigError where the `xacro` package is not installed."""
    if importlib.util.find_spec("xacro") is None:
        msg = f"{where} is a xacro file, and the package that expands those is not installed"
        hint = f"{install('xacro')}, or expand it yourself: xacro FILE > robot.urdf"
        raise ConfigError(msg, "source.path", hint)


def expanded(path: Path, where: str, args: Mapping[str, Any], find: Callable[[str], Path | None]) -> str:
    """The URDF that a xacro file makes. `find`: a package's folder by its name.

    ConfigError where xacro is not installed; SourceError where it refuses the file.
    """
    require(where)
    import xacro

    mappings = {name: _text(value) for name, value in args.items()}
    lacking: list[str] = []
    try:
        with contextlib.redirect_stderr(io.StringIO()), _found_by(find, lacking):
            xacro.init_stacks(str(path))
            document = xacro.parse(None, str(path))
            xacro.process_doc(document, mappings=mappings)
            text: str = document.toprettyxml(indent="  ")
    except Exception as error:
        why = "it nests too deep, or calls itself" if isinstance(error, RecursionError) else str(error)
        hint = _ARGUMENT if "Undefined substitution argument" in why else ""
        if lacking:
            why, hint = f"there is no package {lacking[-1]}", _PACKAGE % lacking[-1]
        why = " ".join(why.split()).replace(f"{path.parent}/", "") or type(error).__name__
        raise SourceError(f"xacro refuses it: {why}", where, hint) from None
    return text


def _text(value: Any) -> str:
    """A value as xacro's command line would get it."""
    return str(value).lower() if isinstance(value, bool) else str(value)


@contextlib.contextmanager
def _found_by(find: Callable[[str], Path | None], lacking: list[str]) -> Iterator[None]:
    """Within it, `$(find name)` asks `find`: xacro's own look-up needs an installed ROS. Packages that are
    nowhere are added to `lacking`."""
    from xacro import substitution_args

    def folder(name: str) -> str:
        found = find(name)
        if found is None:
            lacking.append(name)
            raise substitution_args.SubstitutionException(name)
        return str(found)

    own = substitution_args._eval_find
    substitution_args._eval_find = folder
    substitution_args._eval_dict["find"] = folder
    try:
        yield
    finally:
        substitution_args._eval_find = own
        substitution_args._eval_dict["find"] = own
