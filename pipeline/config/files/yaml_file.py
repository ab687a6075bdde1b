"""Checks YAML files of users before they are parsed.

A few lines of YAML can expand to more than the memory holds, since an alias repeats its value, and deep
nesting ends a recursive parser. So the events of a file are counted first, which is about a hundred times
faster than parsing.
"""

import re
from pathlib import Path
from typing import Any

import yaml

from linkwright.pipeline import observed
from linkwright.stages.robot.system import regular_files

LARGEST = 4 << 20
"""Larger files are not read [bytes]."""

MOST_VALUES = 20_000
"""Most values (with keys) in a file after its aliases are expanded: a robot of 500 joints with all of their
keys has half as many."""

DEEPEST = 32
"""Levels of nesting."""

_EVENTS = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


class _Strict(yaml.SafeLoader):  # type: ignore[misc]
    """Refuses a key that stands twice in a mapping, as OmegaConf does."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        keys = [key.value for key, _ in node.value if isinstance(key, yaml.ScalarNode) and key.value != "<<"]
        if len(set(keys)) < len(keys):
            raise yaml.constructor.ConstructorError(None, None, "found a key twice", node.start_mark)
        found: dict[Any, Any] = super().construct_mapping(node, deep=deep)
        return found


class RefusedError(yaml.MarkedYAMLError):  # type: ignore[misc]
    """A YAML file above the limits, with a `hint`."""

    def __init__(self, problem: str, mark: yaml.Mark | None, hint: str) -> None:
        super().__init__(problem=problem, problem_mark=mark)
        self.hint = hint


def read(path: Path) -> Any:
    """The content of a file, as plain data.

    OSError, UnicodeDecodeError or yaml.YAMLError (RefusedError is one) where it cannot be read.
    """
    return yaml.load(text(path), Loader=_Strict)


def text(path: Path) -> str:
    """The text of a file within the limits. Raises as `read`, but not for invalid YAML, which the parser
    reports."""
    try:
        content = regular_files.content(path, LARGEST)
    except regular_files.FileTooLarge as error:
        why = f"it has {error.size} bytes, and at most {LARGEST} are read"
        raise RefusedError(why, _mark(path, 0, 0), "choose the YAML file of the robot") from None
    observed.read(path, content)
    found = content.decode("utf-8")
    judge(found, path)
    return found


def problem(error: Exception) -> str:
    """What is wrong with a file that cannot be read, in words that quote nothing of it: a link, or a path in
    a robot's file, may name any file. Of what the parser expected, and of marks such as `:`, it says all."""
    if isinstance(error, UnicodeDecodeError):
        return "not UTF-8 text"
    if isinstance(error, OSError):
        return f"cannot be read: {error.strerror or type(error).__name__}"
    if isinstance(error, RefusedError):
        return f"cannot be read: {error.problem}"
    if isinstance(error, yaml.MarkedYAMLError):
        words = _QUOTED.sub(_if_harmless, f"{error.problem or error.context}")
        return f"not valid YAML: {_DUPLICATE.sub('found a key twice', words)}"
    if isinstance(error, yaml.reader.ReaderError):
        return "not valid YAML: found a control character"
    return "not valid YAML"


def where(error: Exception) -> str:
    """File, line and column of an error, as far as it names them."""
    if isinstance(error, yaml.MarkedYAMLError) and (mark := error.problem_mark or error.context_mark):
        return f"{mark.name}, line {mark.line + 1}, column {mark.column + 1}"
    return str(error.name) if isinstance(error, yaml.reader.ReaderError) else ""


_QUOTED = re.compile(r""" ?('(?:[^'\\]|\\.)*'|"(?:[^"\\]|\\.)*")""")
_DUPLICATE = re.compile(r"found duplicate key.*", re.DOTALL)


def _if_harmless(quoted: re.Match[str]) -> str:
    """A quoted text where it is the parser's, or a mark, else nothing."""
    inside = quoted[1][1:-1]
    return quoted[0] if re.fullmatch(r"<[a-z ]+>|\\t|[^\w\s]", inside) else ""


def require_mapping(content: str, name: str) -> None:
    """RefusedError where the text of the file `name` begins with a value that is no mapping: what cannot be a
    robot's file is not taken for a key of it."""
    try:
        for event in yaml.parse(content, Loader=_EVENTS):
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


def judge(content: str, path: Path) -> None:
    """RefusedError where the text of the file at `path` is above the limits."""
    try:
        _Count(path).all(content, _EVENTS)
    except RefusedError:
        raise
    except yaml.YAMLError:
        _judge_again(content, path)


def _judge_again(content: str, path: Path) -> None:
    """Counts with the parser that loads files. libyaml looks ahead for `:` and ends at its own limit of
    levels before it reports the first of them, where that parser would recurse."""
    try:
        _Count(path).all(content, yaml.SafeLoader)
    except RefusedError:
        raise
    except yaml.YAMLError:
        return


class _Count:
    """Counts values and levels while events arrive; for each anchor its values and its depth."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._anchors: dict[str, tuple[int, int]] = {}
        self._open: list[tuple[str | None, int, int]] = []

    def all(self, content: str, loader: Any) -> None:
        for event in yaml.parse(content, Loader=loader):
            if isinstance(event, yaml.AliasEvent):
                self._repeated(event)
            elif isinstance(event, yaml.ScalarEvent):
                self._anchors |= {event.anchor: (1, 0)} if event.anchor else {}
                self._add(1, 0, event)
            elif isinstance(event, yaml.CollectionStartEvent):
                self._open.append((event.anchor, 1, 1))
                self._add(0, 0, event)
            elif isinstance(event, yaml.CollectionEndEvent):
                anchor, values, height = self._open.pop()
                self._anchors |= {anchor: (values, height)} if anchor else {}
                self._add(values, height, event)

    def _repeated(self, event: yaml.AliasEvent) -> None:
        if any(anchor == event.anchor for anchor, *_ in self._open):
            raise self._refused(f"*{event.anchor} contains itself", event, "remove the alias")
        self._add(*self._anchors.get(event.anchor, (1, 0)), event)

    def _add(self, values: int, height: int, event: yaml.Event) -> None:
        """Adds `values` with `height` levels to the open collection."""
        if len(self._open) + height > DEEPEST:
            problem = f"it is nested deeper than {DEEPEST} levels"
            raise self._refused(problem, event, "no key of a robot is that deep: check the brackets")
        total = values + sum(inside for _, inside, _ in self._open)
        if total > MOST_VALUES:
            problem = f"it expands to more than {MOST_VALUES} values"
            hint = "check its aliases (*name): each repeats the value of its anchor"
            raise self._refused(problem, event, hint)
        if self._open:
            anchor, inside, most = self._open[-1]
            self._open[-1] = (anchor, inside + values, max(most, height + 1))

    def _refused(self, problem: str, event: yaml.Event, hint: str) -> RefusedError:
        mark = event.start_mark
        return RefusedError(problem, _mark(self._path, mark.line, mark.column), hint)


def _mark(path: Path, line: int, column: int) -> yaml.Mark:
    return yaml.Mark(str(path), 0, line, column, None, None)
