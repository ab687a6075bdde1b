"""What a build asks of the file system and of the environment before its first stage, with each answer.

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

LARGEST = 16 << 20
"""A larger file counts as unreadable [bytes]; of YAML and XML less is read."""

DOTENV = ".env"

VARIABLES = ("HOME", "PWD", "USERPROFILE", "XDG_CACHE_HOME")
PREFIXES = ("LINKWRIGHT_", "ONSHAPE_")
"""The variables that every build may read."""

Answer = tuple[str, str, str]
"""A question, what it is about, and its answer."""

_OURS = os.path.join(os.path.dirname(linkwright.conf.__file__), "")  # noqa: PTH118, PTH120


class Observed:
    """The questions of a build with their answers. `salt` goes into the digests of variables.

    `lasts`: whether the same answers lead to the same build; not where a file changed meanwhile, or where a
    value is that of a moment, as `${now:%H}`.
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
        """All questions with their answers, in the order of the first time that each was asked."""
        return tuple((question, about, answer) for (question, about), answer in self._answers.items())

    def ask(self, question: str, about: str) -> None:
        self.note(question, about, answer(question, about, self.salt, self._environ))

    def note(self, question: str, about: str, said: str) -> None:
        """Keeps an answer. The files of `conf` are a part of the program (see `pipeline.run.program`)."""
        if about.startswith(_OURS) and ".." not in about:
            return
        if self._answers.setdefault((question, about), said) != said:
            self.lasts = False


_NOW: ContextVar[Observed | None] = ContextVar("observed", default=None)


@contextmanager
def recording(salt: str) -> Iterator[Observed]:
    """Inside, the questions below are kept with their answers."""
    observed = Observed(salt)
    token = _NOW.set(observed)
    try:
        yield observed
    finally:
        _NOW.reset(token)


def still_true(answers: Iterable[Answer], salt: str, environ: Mapping[str, str] = os.environ) -> bool:
    """Whether every question has the same answer now."""
    return all(answer(question, about, salt, environ) == said for question, about, said in answers)


def is_file(path: Path) -> bool:
    """Whether a file is at the path."""
    return _asked("kind", path) == "file"


def is_folder(path: Path) -> bool:
    """Whether a folder is at the path."""
    return _asked("kind", path) == "folder"


def real(path: Path) -> Path:
    """The path without links."""
    return Path(_asked("real", path))


def yaml_files(folder: Path) -> list[str]:
    """The names of the YAML files in a folder, sorted; none where there is no such folder."""
    names: list[str] = json.loads(_asked("YAML files", folder))
    return names


def yaml_below(folder: Path) -> list[str]:
    """The paths of the YAML files in a folder and below it, relative to it, sorted."""
    paths: list[str] = json.loads(_asked("YAML below", folder))
    return paths


def folders_with_yaml(folder: Path) -> list[str]:
    """The names of the folders in a folder that have YAML files, sorted."""
    names: list[str] = json.loads(_asked("folders with YAML", folder))
    return names


def holds_yaml(folder: Path) -> bool:
    """Whether a YAML file is anywhere below a folder of this folder."""
    return _asked("holds YAML", folder) == "yes"


def read(path: Path, content: bytes) -> None:
    """Notes the content of a file that was read."""
    if observed := _NOW.get():
        observed.note("text", str(path), hashlib.sha256(content).hexdigest())


def variable(name: str) -> None:
    """Notes that the value of a variable of the environment is used."""
    if observed := _NOW.get():
        observed.ask("variable", name)


def momentary() -> None:
    """Notes that a value is used that another moment, or another machine, may change."""
    if observed := _NOW.get():
        observed.lasts = False


def _asked(question: str, path: Path) -> str:
    said = answer(question, str(path))
    if observed := _NOW.get():
        observed.note(question, str(path), said)
    return said


def answer(question: str, about: str, salt: str = "", environ: Mapping[str, str] = os.environ) -> str:
    """The answer to a question now. KeyError for a question that does not exist."""
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
        return regular_files.digest(Path(path), LARGEST)
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
    found = any(_is_yaml(name) for place in below for _, _, names in os.walk(place) for name in names)
    return "yes" if found else ""


def _yaml_in(folder: str) -> list[str]:
    return [entry.name for entry in _entries(folder) if _is_yaml(entry.name)]


def _entries(folder: str) -> list["os.DirEntry[str]"]:
    """The entries of a folder; none where it cannot be read."""
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
