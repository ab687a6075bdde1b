"""Checks that folders for results that a file names are below the working folder."""

import os
import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from omegaconf import DictConfig

from linkwright.pipeline import observed
from linkwright.pipeline.config.files.trust import TRUST_CODE, are_trusted, override_text
from linkwright.pipeline.config.messages import shown
from linkwright.stages.robot.errors import Diagnostic

OUTPUT, SWEEP_DIR = "output", "hydra.sweep.dir"

_ENVIRONMENT_VALUE = re.compile(r"\$\{oc\.env:\w+\}")
"""The pattern of a value that is a single environment variable without a default."""


def folder_problems(
    folders: Mapping[str, Any],
    config: DictConfig,
    typed_keys: Collection[str],
    files: Iterable[Path],
    environ: Mapping[str, str],
    command: str,
) -> list[Diagnostic]:
    """Returns a problem for each folder that a file puts outside of the working folder.

    `folders`: key → folder; `config`: the tree as Hydra composed it; `typed_keys`: the keys that the command
    line sets; `files`: the user's own files in the composition; `command`: the typed command, which the hints
    repeat.
    """
    if are_trusted(files, environ):
        return []
    output_value = next((str(value) for key, value in config.items_ex(resolve=False) if key == OUTPUT), "")
    free_keys = {*typed_keys, *([OUTPUT] if _ENVIRONMENT_VALUE.fullmatch(output_value) else [])}
    return [
        Diagnostic(
            TRUST_CODE,
            f"a file must name a folder below the working folder (given {shown(place)})",
            key,
            f"if you want it there: {command} {override_text(key, place)}",
        )
        for key, place in folders.items()
        if key not in free_keys and isinstance(place, str) and not _is_below(place)
    ]


def _is_below(place: str) -> bool:
    """Tells whether a path is below the working folder; links are not resolved."""
    absolute = os.path.abspath(os.path.expanduser(place))  # noqa: PTH100, PTH111  (links stay)
    return any(Path(folder) in Path(absolute).parents for folder in _working_folders())


def _working_folders() -> Iterator[str]:
    """Yields the working folder, and the path by which the shell reached it."""
    folder = os.getcwd()  # noqa: PTH109
    yield folder
    by_link = os.environ.get("PWD", "")
    if os.path.isabs(by_link) and observed.real_path(Path(by_link)) == observed.real_path(Path(folder)):  # noqa: PTH117
        yield os.path.normpath(by_link)
