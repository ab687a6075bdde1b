"""What was found in public files and looked at: by file, whether each finding is true, and why."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

import yaml

FILE = Path(__file__).with_name("public_models.yaml")


@dataclass(frozen=True, slots=True)
class Judgement:
    """A judgement of the findings of this code and level, in the models that the globs mean, whose line one
    of `lines` means. `true`: whether the file is so, and else a false alarm; `why` in a few words."""

    code: str
    level: str
    models: tuple[str, ...]
    lines: tuple[str, ...]
    true: bool
    why: str

    def means(self, model):
        return any(fnmatchcase(model, glob) for glob in self.models)

    def judges(self, model, code, level, line):
        same = (self.code, self.level) == (code, level)
        return same and self.means(model) and any(fnmatchcase(line, glob) for glob in self.lines)


def judgements(path=FILE):
    """Those of a file: a list by "CODE level", each with `models`, with `true_since` or `false_since`, the
    reason, and `lines` where not all findings of that code are meant."""
    table: Mapping[str, Sequence[Mapping[str, Any]]] = yaml.safe_load(path.read_text())
    return tuple(_judgement(*key.split(), **row) for key, rows in table.items() for row in rows)


def _judgement(code, level, *, models, lines="*", true_since="", false_since=""):
    if bool(true_since) == bool(false_since):
        msg = f"{code} {level} of {models}: it is either true or false, for a reason"
        raise ValueError(msg)
    why = true_since or false_since
    return Judgement(code, level, _globs(models), _globs(lines), bool(true_since), why)


def _globs(globs):
    return (globs,) if isinstance(globs, str) else tuple(globs)


def lines_of(check):
    """Each finding of a check as a line; of one without findings its detail."""
    said = [f"{finding.element} {finding.attribute}: {finding.message}" for finding in check.findings]
    return said or [" ".join(check.detail.split())]


def level_of(check):
    return "error" if check.fails else "warning"


def judged(judgements, model, check):
    """The lines of a check of a model, each with the first judgement of it, None where it has none."""
    judgements = [judgement for judgement in judgements if judgement.means(model)]
    level = level_of(check)
    return [
        (
            line,
            next(
                (judgement for judgement in judgements if judgement.judges(model, check.code, level, line)),
                None,
            ),
        )
        for line in lines_of(check)
    ]
