"""Folders that a file names for the results of a build: they lie below the working folder."""

import os
import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from omegaconf import DictConfig

from linkwright.pipeline import observed
from linkwright.pipeline.config.files.trust import CODE, override, trusted
from linkwright.pipeline.config.messages import shown
from linkwright.pipeline.config.plain import as_written
from linkwright.stages.robot.errors import Diagnostic

OUTPUT, SWEEP_DIR = "output", "hydra.sweep.dir"

_OF_THE_ENVIRONMENT = re.compile(r"\$\{oc\.env:\w+\}")
"""A value that is a variable of the environment, whole and without a default."""


def outside(
    named: Mapping[str, Any],
    config: DictConfig,
    typed: Collection[str],
    files: Iterable[Path],
    environ: Mapping[str, str],
    command: str,
) -> list[Diagnostic]:
    """A problem for each of the `named` folders, key → value, that a file puts outside of the working folder.

    `config`: the tree as Hydra composed it; `typed`: keys that the command line gives; `files`: those of the
    user that were composed; `command`: what was typed, to which the hint adds.
    """
    if trusted(files, environ):
        return []
    free = {*typed, *([OUTPUT] if _OF_THE_ENVIRONMENT.fullmatch(str(as_written(config).get(OUTPUT))) else [])}
    return [
        Diagnostic(
            CODE,
            f"a file must name a folder below the working folder (given {shown(place)})",
            key,
            f"if you want it there: {command} {override(key, place)}",
        )
        for key, place in named.items()
        if key not in free and isinstance(place, str) and not _is_below(place)
    ]


def _is_below(place: str) -> bool:
    """Whether a place lies below the working folder as it is written: links are not resolved."""
    there = os.path.abspath(os.path.expanduser(place))  # noqa: PTH100, PTH111  (links stay)
    return any(Path(here) in Path(there).parents for here in _working_folders())


def _working_folders() -> Iterator[str]:
    """The working folder, and the path by which the shell reached it."""
    here = os.getcwd()  # noqa: PTH109
    yield here
    by_link = os.environ.get("PWD", "")
    if os.path.isabs(by_link) and observed.real(Path(by_link)) == observed.real(Path(here)):  # noqa: PTH117
        yield os.path.normpath(by_link)
