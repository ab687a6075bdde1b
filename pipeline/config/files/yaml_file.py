"""Checks YAML files of users before they are parsed.

A few lines of YAML can expand to more than the memory holds, since an alias repeats its value, and deep
nesting ends a recursive parser. So the events of a file are counted first, which is about a hundred times
faster than parsing.
"""

import pickle
import re
from functools import lru_cache
from pathlib import Path
from typing import Any

import yaml

from linkwright.pipeline import observed
from linkwright.stages.robot.system import regular_files

MAX_BYTES = 4 << 20
"""Largest size of a file that is read [bytes]."""

MAX_VALUES = 20_000
"""Largest number of values, with keys, in a file after its aliases are expanded. A robot of 500 joints with
all of their keys has half as many."""

MAX_DEPTH = 32
"""Largest number of levels of nesting."""

_EVENT_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


class _StrictLoader(yaml.SafeLoader):  # type: ignore[misc]
    """A YAML loader that refuses a key that occurs twice in a mapping, as OmegaConf does."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        keys = [key.value for key, _ in node.value if isinstance(key, yaml.ScalarNode) and key.value != "<<"]
        if len(set(keys)) < len(keys):
            raise yaml.constructor.ConstructorError(None, None, "found a key twice", node.start_mark)
        mapping: dict[Any, Any] = super().construct_mapping(node, deep=deep)
        return mapping


class RefusedError(yaml.MarkedYAMLError):  # type: ignore[misc]
    """A YAML file above the limits, with a `hint`."""

    def __init__(self, problem: str, mark: yaml.Mark | None, hint: str) -> None:
        super().__init__(problem=problem, problem_mark=mark)
        self.hint = hint


def read(path: Path) -> Any:
    """Returns the content of a file as plain data.

    Raises OSError, UnicodeDecodeError or yaml.YAMLError (which includes RefusedError) if it cannot be read.
    """
    return pickle.loads(_parsed(text(path)))


@lru_cache(maxsize=64)
def _parsed(content: str) -> bytes:
    """Parses a text, and returns its content pickled: the jobs of a sweep read the same files, and each may
    change its copy."""
    return pickle.dumps(yaml.load(content, Loader=_StrictLoader))


def text(path: Path) -> str:
    """Returns the text of a file within the limits. Raises the errors of `read`, except for invalid YAML,
    which the parser reports."""
    try:
        content = regular_files.content(path, MAX_BYTES)
    except regular_files.FileTooLarge as error:
        why = f"it has {error.size} bytes, and at most {MAX_BYTES} are read"
        raise RefusedError(why, _mark(path, 0, 0), "choose the YAML file of the robot") from None
    observed.record_content(path, content)
    decoded = content.decode("utf-8")
    check_limits(decoded, path)
    return decoded


def problem(error: Exception) -> str:
    """Describes why a file cannot be read, without quoting its content: a link, or a path in a robot's file,
    may name any file. What the parser expected, and marks such as `:`, are quoted."""
    if isinstance(error, UnicodeDecodeError):
        return "not UTF-8 text"
    if isinstance(error, OSError):
        return f"cannot be read: {error.strerror or type(error).__name__}"
    if isinstance(error, RefusedError):
        return f"cannot be read: {error.problem}"
    if isinstance(error, yaml.MarkedYAMLError):
        words = _QUOTED.sub(_harmless_quote, f"{error.problem or error.context}")
        words = _TAB.sub("found a tab", words)
        return f"not valid YAML: {_DUPLICATE.sub('found a key twice', words)}"
    if isinstance(error, yaml.reader.ReaderError):
        return "not valid YAML: found a control character"
    return "not valid YAML"


def where(error: Exception) -> str:
    """Returns file, line and column of an error, as far as it names them."""
    if isinstance(error, yaml.MarkedYAMLError) and (mark := error.problem_mark or error.context_mark):
        return f"{mark.name}, line {mark.line + 1}, column {mark.column + 1}"
    return str(error.name) if isinstance(error, yaml.reader.ReaderError) else ""


_QUOTED = re.compile(r""" ?('(?:[^'\\]|\\.)*'|"(?:[^"\\]|\\.)*")""")
_DUPLICATE = re.compile(r"found duplicate key.*", re.DOTALL)
_TAB = re.compile(r"found character '\\t' that cannot start any token|found a tab character.*", re.DOTALL)


def _harmless_quote(quoted: re.Match[str]) -> str:
    """Returns a quoted text if it is the parser's own word or a punctuation mark, else ""."""
    content = quoted[1][1:-1]
    return quoted[0] if re.fullmatch(r"<[a-z ]+>|\\t|[^\w\s]", content) else ""


def require_mapping(content: str, name: str) -> None:
    """Raises RefusedError if the text of the file `name` begins with a value that is not a mapping, and hence
    cannot be a robot's file."""
    try:
        for event in yaml.parse(content, Loader=_EVENT_LOADER):
            if isinstance(event, yaml.MappingStartEvent | yaml.StreamEndEvent):
                return
            empty = isinstance(event, yaml.ScalarEvent) and event.value in ("", "~", "null")
            if isinstance(event, yaml.NodeEvent) and not empty:
                mark = yaml.Mark(name, 0, event.start_mark.line, event.start_mark.column, None, None)
                raise RefusedError("it is not a mapping of keys", mark, "write it as keys: `name: value`")
    except RefusedError:
        raise
    except yaml.YAMLError:
        return


def check_limits(content: str, path: Path) -> None:
    """Raises RefusedError if the text of the file at `path` is above the limits."""
    try:
        _Counter(path).all(content, _EVENT_LOADER)
    except RefusedError:
        raise
    except yaml.YAMLError:
        _check_in_python(content, path)


def _check_in_python(content: str, path: Path) -> None:
    """Checks the limits again, with the parser that loads files.

    libyaml looks ahead for `:`, and stops at its own limit of levels before it reports any of them; the
    parser in Python would recurse there.
    """
    try:
        _Counter(path).all(content, yaml.SafeLoader)
    except RefusedError:
        raise
    except yaml.YAMLError:
        return


class _Counter:
    """Counts values and levels of a document; keeps the number of values and the depth of each anchor."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._anchors: dict[str, tuple[int, int]] = {}
        self._open_collections: list[tuple[str | None, int, int]] = []
        """The anchor, the number of values and the height of each open collection, outermost first."""

    def all(self, content: str, loader: Any) -> None:
        """Counts a text; raises RefusedError above the limits."""
        for event in yaml.parse(content, Loader=loader):
            if isinstance(event, yaml.AliasEvent):
                self._add_alias(event)
            elif isinstance(event, yaml.ScalarEvent):
                self._anchors |= {event.anchor: (1, 0)} if event.anchor else {}
                self._add(1, 0, event)
            elif isinstance(event, yaml.CollectionStartEvent):
                self._open_collections.append((event.anchor, 1, 1))
                self._add(0, 0, event)
            elif isinstance(event, yaml.CollectionEndEvent):
                anchor, values, height = self._open_collections.pop()
                self._anchors |= {anchor: (values, height)} if anchor else {}
                self._add(values, height, event)

    def _add_alias(self, event: yaml.AliasEvent) -> None:
        if any(anchor == event.anchor for anchor, *_ in self._open_collections):
            raise self._refused(f"*{event.anchor} contains itself", event, "remove the alias")
        self._add(*self._anchors.get(event.anchor, (1, 0)), event)

    def _add(self, values: int, height: int, event: yaml.Event) -> None:
        """Adds `values` with `height` levels to the open collection."""
        if len(self._open_collections) + height > MAX_DEPTH:
            problem = f"it is nested deeper than {MAX_DEPTH} levels"
            raise self._refused(problem, event, "no key of a robot is that deep: check the brackets")
        total = values + sum(values_inside for _, values_inside, _ in self._open_collections)
        if total > MAX_VALUES:
            problem = f"it expands to more than {MAX_VALUES} values"
            hint = "check its aliases (*name): each repeats the value of its anchor"
            raise self._refused(problem, event, hint)
        if self._open_collections:
            anchor, values_inside, max_height = self._open_collections[-1]
            self._open_collections[-1] = (anchor, values_inside + values, max(max_height, height + 1))

    def _refused(self, problem: str, event: yaml.Event, hint: str) -> RefusedError:
        mark = event.start_mark
        return RefusedError(problem, _mark(self._path, mark.line, mark.column), hint)


def _mark(path: Path, line: int, column: int) -> yaml.Mark:
    return yaml.Mark(str(path), 0, line, column, None, None)
