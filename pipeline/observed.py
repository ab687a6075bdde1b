"""Records the questions that a build asks the file system and the environment before its first stage.

An unchanged build is recognised by asking the same questions again (`pipeline.run.unchanged`). So all code
that composes a configuration looks for files here, and records here which files and variables it reads. The
value of a variable is kept as a digest, since it may be a secret. Imports nothing heavy.
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
"""Largest size of a readable file [bytes]; YAML has a lower limit; XML has the same
(`pipeline.element_files`)."""

DOTENV = ".env"
"""The file in the working folder that may contain API keys and other variables."""

VARIABLE_NAMES = ("HOME", "PWD", "SOURCE_DATE_EPOCH", "USERPROFILE", "XDG_CACHE_HOME")
"""The names of variables that every build may read. A USD has the day of SOURCE_DATE_EPOCH."""

VARIABLE_PREFIXES = ("LINKWRIGHT_", "ONSHAPE_")
"""The prefixes of the names of further variables that every build may read."""

AnsweredQuestion = tuple[str, str, str]
"""(question, subject, answer): the subject is a path, or the name of a variable or a prefix of names. The
answers to "content" and to both questions about variables are digests."""

# os.path here and below: pathlib takes up to three times as long, and an unchanged build asks many questions.
_CONF_PREFIX = os.path.join(os.path.dirname(linkwright.conf.__file__), "")  # noqa: PTH118, PTH120
"""The prefix of the paths of files in `conf`: its folder, with a separator at the end."""


class Observations:
    """The questions of a build with their answers."""

    is_repeatable: bool
    """Whether the same answers lead to the same build. They do not if a file changed meanwhile, or if a value
    depends on the moment, such as `${now:%H}`."""

    def __init__(self, salt: str, environ: Mapping[str, str] = os.environ) -> None:
        """Asks the questions that every build asks. `salt` becomes part of the digests of variables."""
        self.is_repeatable = True
        self._salt = salt
        self._environ = environ
        self._answers: dict[tuple[str, str], str] = {}
        for name in VARIABLE_NAMES:
            self.observe("variable", name)
        for prefix in VARIABLE_PREFIXES:
            self.observe("variables with prefix", prefix)
        for question in ("content", "mode"):
            self.observe(question, DOTENV)

    @property
    def answers(self) -> tuple[AnsweredQuestion, ...]:
        """All questions with their answers, in the order in which each was first asked."""
        return tuple((question, subject, answer) for (question, subject), answer in self._answers.items())

    def observe(self, question: str, subject: str) -> None:
        """Asks a question, and records its answer."""
        self.record(question, subject, current_answer(question, subject, self._salt, self._environ))

    def record(self, question: str, subject: str, answer: str) -> None:
        """Records an answer, unless its subject is in `conf`, which is part of the program
        (`pipeline.run.program`)."""
        # A path with `..` may leave `conf`.
        if subject.startswith(_CONF_PREFIX) and ".." not in subject:
            return
        if self._answers.setdefault((question, subject), answer) != answer:
            self.is_repeatable = False


_CURRENT_OBSERVATIONS: ContextVar[Observations | None] = ContextVar("observations", default=None)
"""The observations of the block of `recording` that is running; None outside of such a block."""


@contextmanager
def recording(salt: str) -> Iterator[Observations]:
    """Records all questions that the block asks by the functions below, with their answers."""
    observations = Observations(salt)
    token = _CURRENT_OBSERVATIONS.set(observations)
    try:
        yield observations
    finally:
        _CURRENT_OBSERVATIONS.reset(token)


def have_same_answers(
    questions: Iterable[AnsweredQuestion], salt: str, environ: Mapping[str, str] = os.environ
) -> bool:
    """Tells whether all questions have the same answers now."""
    return all(
        current_answer(question, subject, salt, environ) == answer for question, subject, answer in questions
    )


def is_file(path: Path) -> bool:
    """Tells whether a file is at the path."""
    return _observed_answer("kind", path) == "file"


def is_folder(path: Path) -> bool:
    """Tells whether a folder is at the path."""
    return _observed_answer("kind", path) == "folder"


def real_path(path: Path) -> Path:
    """Returns the absolute path, with all symbolic links resolved."""
    return Path(_observed_answer("real path", path))


def yaml_files(folder: Path) -> list[str]:
    """Returns the names of the YAML files in a folder, sorted; [] if there is no such folder."""
    names: list[str] = json.loads(_observed_answer("YAML files", folder))
    return names


def yaml_files_below(folder: Path) -> list[str]:
    """Returns the paths of the YAML files in a folder and below it, relative to it, sorted."""
    paths: list[str] = json.loads(_observed_answer("YAML files below", folder))
    return paths


def folders_with_yaml(folder: Path) -> list[str]:
    """Returns the names of the folders directly in a folder that have YAML files directly in them, sorted."""
    names: list[str] = json.loads(_observed_answer("folders with YAML", folder))
    return names


def has_yaml_in_subfolders(folder: Path) -> bool:
    """Tells whether any folder in this folder has a YAML file, at any depth."""
    return _observed_answer("YAML in subfolders", folder) == "yes"


def record_content(path: Path, content: bytes) -> None:
    """Records the content of a file that was read."""
    if observations := _CURRENT_OBSERVATIONS.get():
        observations.record("content", str(path), hashlib.sha256(content).hexdigest())


def record_variable(name: str) -> None:
    """Records that the value of an environment variable is used."""
    if observations := _CURRENT_OBSERVATIONS.get():
        observations.observe("variable", name)


def record_momentary_value() -> None:
    """Records the use of a value that may differ at another moment or on another machine."""
    if observations := _CURRENT_OBSERVATIONS.get():
        observations.is_repeatable = False


def _observed_answer(question: str, path: Path) -> str:
    """Returns the answer to a question about a path, and records it."""
    answer = current_answer(question, str(path))
    if observations := _CURRENT_OBSERVATIONS.get():
        observations.record(question, str(path), answer)
    return answer


def current_answer(
    question: str, subject: str, salt: str = "", environ: Mapping[str, str] = os.environ
) -> str:
    """Returns the current answer to a question. Raises KeyError for an unknown question."""
    if question == "variable":
        return _salted_digest(environ.get(subject), salt)
    if question == "variables with prefix":
        values = {name: value for name, value in environ.items() if name.startswith(subject)}
        return _salted_digest(json.dumps(sorted(values.items())), salt)
    return _PATH_QUESTIONS[question](subject)


def _salted_digest(value: str | None, salt: str) -> str:
    """Returns a digest from which the value cannot be guessed without the salt; "" for None."""
    return "" if value is None else hashlib.sha256(f"{salt}\0{value}".encode(errors="replace")).hexdigest()


def _kind(path: str) -> str:
    """Returns the kind of what is at a path: "file", "folder" or "special"; "" if nothing is there."""
    try:
        mode = os.stat(path).st_mode  # noqa: PTH116
    except (OSError, ValueError):
        return ""
    return "folder" if stat.S_ISDIR(mode) else "file" if stat.S_ISREG(mode) else "special"


def _mode(path: str) -> str:
    """Returns the permissions of a file, in octal digits; "" if there is no file."""
    try:
        return f"{stat.S_IMODE(os.stat(path).st_mode):o}"  # noqa: PTH116
    except (OSError, ValueError):
        return ""


def _content_digest(path: str) -> str:
    """Returns the digest of a file's content; "" if it cannot be read."""
    try:
        return regular_files.digest(Path(path), MAX_BYTES)
    except (OSError, ValueError, regular_files.FileTooLarge):
        return ""


def _answer_yaml_files(folder: str) -> str:
    """Returns the answer to `yaml_files`, as a list in JSON."""
    return json.dumps(sorted(_yaml_names(folder)))


def _answer_yaml_files_below(folder: str) -> str:
    """Returns the answer to `yaml_files_below`, as a list in JSON."""
    files = (os.path.join(top, name) for top, _, names in os.walk(folder) for name in names)  # noqa: PTH118
    return json.dumps(sorted(os.path.relpath(file, folder) for file in files if _is_yaml(file)))


def _answer_folders_with_yaml(folder: str) -> str:
    """Returns the answer to `folders_with_yaml`, as a list in JSON."""
    subfolders = (entry for entry in _entries(folder) if entry.is_dir())
    return json.dumps(sorted(entry.name for entry in subfolders if _yaml_names(entry.path)))


def _answer_yaml_in_subfolders(folder: str) -> str:
    """Returns the answer to `has_yaml_in_subfolders`: "yes" or ""."""
    for entry in _entries(folder):
        if entry.is_dir() and any(_is_yaml(name) for _, _, names in os.walk(entry.path) for name in names):
            return "yes"
    return ""


def _yaml_names(folder: str) -> list[str]:
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


_PATH_QUESTIONS: Mapping[str, Callable[[str], str]] = {
    "kind": _kind,
    "mode": _mode,
    "real path": os.path.realpath,
    "content": _content_digest,
    "YAML files": _answer_yaml_files,
    "YAML files below": _answer_yaml_files_below,
    "folders with YAML": _answer_folders_with_yaml,
    "YAML in subfolders": _answer_yaml_in_subfolders,
}
"""Question about a path → the function that answers it."""
