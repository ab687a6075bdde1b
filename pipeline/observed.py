"""Records the questions that a build asks the file system and the environment before its first stage.

An unchanged build is recognised by asking the same again (`pipeline.run.unchanged`). Whoever reads a file or
a variable that decides what is composed asks here. A variable's value is kept as a digest, since it may be a
secret. Imports nothing heavy.
"""

import hashlib
import json
import os
import stat
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path

import linkwright.conf
from linkwright.stages.robot.system import regular_files

MAX_BYTES = 16 << 20
"""Largest size of a readable file [bytes]; YAML and XML have lower limits."""

DOTENV = ".env"

VARIABLES = ("HOME", "PWD", "USERPROFILE", "XDG_CACHE_HOME")
PREFIXES = ("LINKWRIGHT_", "ONSHAPE_")
"""The names, and the beginnings of names, of variables that every build may read."""

Answer = tuple[str, str, str]
"""A question, its subject (a path or the name of a variable), and its answer."""

_CONF = os.path.join(os.path.dirname(linkwright.conf.__file__), "")  # noqa: PTH118, PTH120


class Observed:
    """The questions of a build with their answers. `salt` becomes part of the digests of variables.

    `lasts`: whether the same answers lead to the same build. They do not if a file changed meanwhile, or if a
    value depends on the moment, such as `${now:%H}`.
    """

    def __init__(self, salt: str, environ: Mapping[str, str] = os.environ) -> None:
        self.salt = salt
        self.lasts = True
        self._environ = environ
        self._answers: dict[tuple[str, str], str] = {}
        for name in VARIABLES:
            self.ask("variable", name)
        for prefix in PREFIXES:
            self.ask("variables", prefix)
        for question in ("text", "mode"):
            self.ask(question, DOTENV)

    @property
    def answers(self) -> tuple[Answer, ...]:
        """All questions with their answers, in the order in which each was first asked."""
        return tuple((question, about, answer) for (question, about), answer in self._answers.items())

    def ask(self, question: str, about: str) -> None:
        self.note(question, about, answer(question, about, self.salt, self._environ))

    def note(self, question: str, about: str, recorded: str) -> None:
        """Records an answer, except about files of `conf`, which belong to the program
        (`pipeline.run.program`)."""
        if about.startswith(_CONF) and ".." not in about:
            return
        if self._answers.setdefault((question, about), recorded) != recorded:
            self.lasts = False


_NOW: ContextVar[Observed | None] = ContextVar("observed", default=None)


@contextmanager
def recording(salt: str) -> Iterator[Observed]:
    """Records the answers to the questions below that are asked in the block."""
    observed = Observed(salt)
    token = _NOW.set(observed)
    try:
        yield observed
    finally:
        _NOW.reset(token)


def still_true(answers: Iterable[Answer], salt: str, environ: Mapping[str, str] = os.environ) -> bool:
    """Tells whether every question has the same answer now."""
    return all(answer(question, about, salt, environ) == recorded for question, about, recorded in answers)


def is_file(path: Path) -> bool:
    """Tells whether a file is at the path."""
    return _ask("kind", path) == "file"


def is_folder(path: Path) -> bool:
    """Tells whether a folder is at the path."""
    return _ask("kind", path) == "folder"


def real(path: Path) -> Path:
    """Returns a path with all links resolved."""
    return Path(_ask("real", path))


def yaml_files(folder: Path) -> list[str]:
    """Returns the names of the YAML files in a folder, sorted; [] if there is no such folder."""
    names: list[str] = json.loads(_ask("YAML files", folder))
    return names


def yaml_below(folder: Path) -> list[str]:
    """Returns the paths of the YAML files in a folder and below it, relative to it, sorted."""
    paths: list[str] = json.loads(_ask("YAML below", folder))
    return paths


def folders_with_yaml(folder: Path) -> list[str]:
    """Returns the names of the folders in a folder that have YAML files, sorted."""
    names: list[str] = json.loads(_ask("folders with YAML", folder))
    return names


def holds_yaml(folder: Path) -> bool:
    """Tells whether a YAML file is anywhere below a folder of this folder."""
    return _ask("holds YAML", folder) == "yes"


def read(path: Path, content: bytes) -> None:
    """Records the content of a file that was read."""
    if observed := _NOW.get():
        observed.note("text", str(path), hashlib.sha256(content).hexdigest())


def variable(name: str) -> None:
    """Records that the value of an environment variable is used."""
    if observed := _NOW.get():
        observed.ask("variable", name)


def momentary() -> None:
    """Records the use of a value that may differ at another moment or on another machine."""
    if observed := _NOW.get():
        observed.lasts = False


def _ask(question: str, path: Path) -> str:
    recorded = answer(question, str(path))
    if observed := _NOW.get():
        observed.note(question, str(path), recorded)
    return recorded


def answer(question: str, about: str, salt: str = "", environ: Mapping[str, str] = os.environ) -> str:
    """Returns the current answer to a question. Raises KeyError for an unknown question."""
    if question == "variable":
        return _salted(environ.get(about), salt)
    if question == "variables":
        values = {name: value for name, value in environ.items() if name.startswith(about)}
        return _salted(json.dumps(sorted(values.items())), salt)
    return _ANSWERS[question](about)


def _salted(value: str | None, salt: str) -> str:
    return "" if value is None else hashlib.sha256(f"{salt}\0{value}".encode(errors="replace")).hexdigest()


def _kind(path: str) -> str:
    try:
        mode = os.stat(path).st_mode  # noqa: PTH116
    except (OSError, ValueError):
        return ""
    return "folder" if stat.S_ISDIR(mode) else "file" if stat.S_ISREG(mode) else "special"


def _mode(path: str) -> str:
    try:
        return f"{stat.S_IMODE(os.stat(path).st_mode):o}"  # noqa: PTH116
    except (OSError, ValueError):
        return ""


def _text(path: str) -> str:
    try:
        return regular_files.digest(Path(path), MAX_BYTES)
    except (OSError, ValueError, regular_files.FileTooLarge):
        return ""


def _yaml_files(folder: str) -> str:
    return json.dumps(sorted(_yaml_in(folder)))


def _yaml_below(folder: str) -> str:
    files = (os.path.join(top, name) for top, _, names in os.walk(folder) for name in names)  # noqa: PTH118
    return json.dumps(sorted(os.path.relpath(file, folder) for file in files if _is_yaml(file)))


def _folders_with_yaml(folder: str) -> str:
    below = (entry for entry in _entries(folder) if entry.is_dir())
    return json.dumps(sorted(entry.name for entry in below if _yaml_in(entry.path)))


def _holds_yaml(folder: str) -> str:
    below = [entry.path for entry in _entries(folder) if entry.is_dir()]
    is_there = any(_is_yaml(name) for place in below for _, _, names in os.walk(place) for name in names)
    return "yes" if is_there else ""


def _yaml_in(folder: str) -> list[str]:
    return [entry.name for entry in _entries(folder) if _is_yaml(entry.name)]


def _entries(folder: str) -> list["os.DirEntry[str]"]:
    """Returns the entries of a folder; [] if it cannot be read."""
    try:
        with os.scandir(folder) as entries:
            return list(entries)
    except (OSError, ValueError):
        return []


def _is_yaml(name: str) -> bool:
    return name.endswith(".yaml")


_ANSWERS: Mapping[str, Callable[[str], str]] = {
    "kind": _kind,
    "mode": _mode,
    "real": os.path.realpath,
    "text": _text,
    "YAML files": _yaml_files,
    "YAML below": _yaml_below,
    "folders with YAML": _folders_with_yaml,
    "holds YAML": _holds_yaml,
}
