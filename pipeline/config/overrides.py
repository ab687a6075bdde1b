"""Converts overrides as the user types them to overrides for Hydra.

`mesh=hull` chooses a group's option and stays; `mesh.tolerance=1` becomes `++mesh.tolerance=1`, so
that only the plan validates keys; `joints.*.damping=1`, whose path Hydra's grammar does not allow,
becomes `++joints={*:{damping:1}}`.
"""

import re
from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from linkwright.pipeline.config import grammar
from linkwright.pipeline.terminal import pasted, suggested
from linkwright.stages.robot.errors import Diagnostic

CODE = "E-OVERRIDE"

VERBS = ("new", "check", "diff", "view", "explain", "bundle", "cache", "jobs", "job")
"""Verbs of the command line, also those that are decided but not supported yet: never read as overrides."""

_NAME = r"[A-Za-z_$][\w$-]*"
_PATH = re.compile(rf"{_NAME}(\.({_NAME}|0|[1-9]\d*))*", re.ASCII)
_GROUP = re.compile(r"[A-Za-z_][\w-]*(/[A-Za-z_][\w-]*)*(@.*)?", re.ASCII)

ALLOWED_HYDRA_KEYS = re.compile(
    r"hydra(/launcher|\.launcher(\..*)?|\.sweep\.(dir|subdir)|/sweeper(/.*)?|\.sweeper\.(?!params).*"
    r"|[./](job|hydra)_logging(\..*)?|\.verbose)"
)
"""Keys of Hydra that may be overridden in a sweep."""

ValueParser = Callable[[str], list[str]]
"""Hydra's parser: an override → its values as text, several in a sweep.

Raises ValueError, with the problem and perhaps a hint, if the override cannot be read.
"""


@dataclass(frozen=True, slots=True)
class Override:
    """An argument of the command line that sets a key or chooses options."""

    typed: str
    """The argument as the user typed it."""
    key: str
    """The key, without `+` and `~`."""
    values: tuple[str, ...]
    """The values as text, several in a sweep."""
    hydra: str
    """The override for Hydra."""

    @property
    def swept(self) -> bool:
        """Tells whether the override has several values."""
        return len(self.values) > 1

    @property
    def texts(self) -> list[str]:
        """The override for Hydra, once with each of the values."""
        sign = self.hydra.partition("=")[0]
        return [f"{sign}={value}" for value in self.values] or [f"{sign}=null"]

    @property
    def names_below(self) -> list[str]:
        """The names below the first part of a key that Hydra cannot write: of `joints.*.damping`, whose value
        for Hydra is `{*:{damping:1}}`, `*` and `damping`; [] if Hydra has the key as it is."""
        is_nested = self.hydra.partition("=")[0].lstrip("+~") != self.key
        return _segments(self.key)[1:] if is_nested else []

    @property
    def first(self) -> str:
        """The override for Hydra with only the first value."""
        return self.texts[0] if self.swept else self.hydra

    def text_in(self, job: Sequence[str]) -> str | None:
        """Returns the override of a job that sets this key, or None. For Hydra, `joints.*.damping` and
        `joints.*.friction` are the same key `joints`: only their values differ."""
        sign = self.hydra.partition("=")[0]
        texts = [text for text in job if text.partition("=")[0] == sign]
        if len(texts) > 1:
            texts = [text for text in texts if text.partition("=")[2] in self.values] or texts
        return texts[0] if texts else None

    @property
    def for_hydra_itself(self) -> bool:
        """Tells whether the override sets Hydra's own configuration."""
        return self.key == "hydra" or self.key.startswith(("hydra.", "hydra/"))


def read(
    arguments: Sequence[str],
    groups: Collection[str],
    values: ValueParser,
    multirun: bool,
    optional_groups: Collection[str] = (),
) -> tuple[list[Override], list[Diagnostic]]:
    """Reads the arguments of a command line; returns their overrides, and the problems of invalid arguments.

    `groups`: those in the defaults list; `optional_groups`: groups in no defaults list, for which Hydra needs
    a `+`.
    """
    overrides: list[Override] = []
    problems: list[Diagnostic] = []
    for argument, words in suggested.join_arguments(arguments):
        if len(words) > 1:
            hint = suggested.command(arguments, multirun)
            problems.append(Diagnostic(CODE, suggested.split_message(argument), " ".join(words), hint))
        try:
            needs_plus = argument.partition("=")[0] in optional_groups
            override = _read(
                f"+{argument}" if needs_plus else argument, arguments, {*groups, *optional_groups}, values
            )
            override = replace(override, typed=words[0])
            if override.swept and not multirun:
                raise _RefusedError("several values, but no sweep", _several_values_hint(argument, override))
        except _RefusedError as error:
            message, hint = error.args
            if suggested.has_url(argument) and message != suggested.NO_KEY:
                message, hint = _QUOTE_TWICE, suggested.paste(arguments, multirun)
            problems.append(Diagnostic(CODE, message, argument, hint))
        else:
            overrides.append(override)
    return overrides, problems


def hydra_problem(override: Override, multirun: bool) -> Diagnostic | None:
    """Returns the problem of an override that sets a key of Hydra, or None."""
    if not override.for_hydra_itself:
        return None
    if not ALLOWED_HYDRA_KEYS.fullmatch(override.key):
        hint = "--config-dir adds folders of your own; the key `output` sets the output folder"
        return Diagnostic(CODE, "this part of Hydra is set by linkwright", override.typed, hint)
    if not multirun:
        text = "has no effect: a single build does not run under Hydra"
        return Diagnostic(CODE, text, override.typed, "add -m for a sweep, or leave it out")
    if override.swept:
        return Diagnostic(CODE, "cannot be swept", override.typed, "give one value, for all jobs")
    return None


class _RefusedError(Exception):
    """An argument that is not accepted; `args`: message and hint."""


_NOT_WRITABLE = "this key cannot be written on the command line"
_QUOTE_TWICE = "a URL needs quotes, and around them quotes for the shell"


@dataclass(frozen=True, slots=True)
class _Argument:
    """An argument, split into its parts. `sign`: `+`, `++`, `~` or ""; `equal`: `=` or ""."""

    sign: str
    key: str
    equal: str
    value: str

    @property
    def text(self) -> str:
        return f"{self.sign}{self.key}{self.equal}{self.value}"

    @property
    def names(self) -> list[str]:
        return _segments(self.key.partition("@")[0])

    @property
    def is_assignment(self) -> bool:
        """Tells whether the argument sets, adds or deletes a key. A URL does not, even if it contains `=`."""
        is_url = re.match(r"\w+://", self.text)
        return not is_url and any(self.names[:1]) and (bool(self.equal) or self.sign == "~")

    @property
    def is_for_hydra(self) -> bool:
        return self.key.startswith(("hydra.", "hydra/"))


def _read(argument: str, arguments: Sequence[str], groups: Collection[str], values: ValueParser) -> Override:
    typed = _with_converted_value(_split(argument))
    if not typed.is_assignment:
        raise _RefusedError(*suggested.assignment(typed.text, arguments, VERBS))
    if typed.sign == "~":
        return Override(typed.text, typed.key, (), typed.text)
    if "/" in typed.names[0] and not typed.key.startswith("hydra/"):
        raise _RefusedError("there is no such group", f"groups: {', '.join(sorted(groups))}")
    if _is_group(typed.key, typed.value, groups):
        return _read_option(typed, values)
    if typed.is_for_hydra:
        return Override(typed.text, typed.key, _parsed_values(typed.text, typed.text, values), typed.text)
    if _PATH.fullmatch(typed.key):
        return _read_plain_key(typed, values)
    return _read_key_with_names(typed, values)


def _with_converted_value(typed: _Argument) -> _Argument:
    """Returns the argument with its value in Hydra's grammar."""
    try:
        return replace(typed, value=grammar.converted(typed.value))
    except grammar.NotWritableError:
        raise _RefusedError(_NOT_WRITABLE, f"write it in YAML: {typed.key}: {typed.value}") from None


def _read_option(typed: _Argument, values: ValueParser) -> Override:
    """Returns the override that chooses options of a group; a glob chooses the options that it matches."""
    options = _parsed_values(typed.text, typed.text, values)
    is_glob = re.match(r"\s*glob\(", typed.value)
    hydra = f"{typed.sign}{typed.key}={','.join(options)}" if is_glob else typed.text
    return Override(typed.text, typed.key, options, hydra)


def _read_plain_key(typed: _Argument, values: ValueParser) -> Override:
    hydra = f"{typed.sign or '++'}{typed.key}={typed.value}"
    return Override(typed.text, typed.key, _parsed_values(typed.text, hydra, values), hydra)


def _read_key_with_names(typed: _Argument, values: ValueParser) -> Override:
    """Returns the override of a key with a part that is not a word, such as `joints.*.damping`: it sets the
    first part to a mapping."""
    head, *path = _segments(typed.key)
    parsed = _parsed_values(typed.text, f"++x={typed.value}", values)
    if not _PATH.fullmatch(head) or not all(map(grammar.is_writable, path)):
        raise _RefusedError(_NOT_WRITABLE, f"write it in YAML: {_yaml_line(typed.key, typed.value)}")
    hydra = f"++{head}={','.join(_nested_mapping(path, value) for value in parsed)}"
    return Override(typed.text, typed.key, tuple(values(hydra)), hydra)


def _split(argument: str) -> _Argument:
    match = re.match(r"(\+\+|\+|~)?", argument)
    sign = match.group() if match else ""
    rest = argument[len(sign) :]
    # An = inside quotes belongs to a name: joints."a=b".damping=1, joints['a=b'].damping=1
    quoted = re.match(r"""(?:"[^"]*"|\['[^']*'\]|[^="])*""", rest)
    end = quoted.end() if quoted else 0
    if rest[end : end + 1] != "=":
        end = rest.find("=") if "=" in rest else len(rest)
    return _Argument(sign, rest[:end].strip(), rest[end : end + 1], rest[end + 1 :])


def _is_group(key: str, value: str, groups: Collection[str]) -> bool:
    return (
        key.partition("@")[0] in groups and bool(_GROUP.fullmatch(key)) and not value.lstrip().startswith("{")
    )


def _parsed_values(argument: str, hydra: str, values: ValueParser) -> tuple[str, ...]:
    try:
        return tuple(values(hydra))
    except ValueError as error:
        key, _, value = argument.partition("=")
        message, *hint = error.args
        if not hint and value.lstrip()[:1] in ("{", "["):
            hint = ["example of a mapping: 'joints={\"elbow*\": {damping: 1, limits: [-1, 1]}}'"]
        if value.startswith("~"):
            value = str(Path(value).expanduser())
        raise _RefusedError(
            f"cannot be read: {message}", *(hint or [f"quote the value: {pasted.override(key, value)}"])
        ) from None


_SEGMENT = re.compile(r"""\["([^"]*)"\]|\['([^']*)'\]|"([^"]*)"|((?:(?!\[["'])[^."])+)""")


def _segments(key: str) -> list[str]:
    """Returns the names of a path; a quoted name may contain dots: joints."a.b".damping,
    joints["a.b"].damping."""
    return ["".join(groups) for groups in _SEGMENT.findall(key)]


def _nested_mapping(path: Iterable[str], value: str) -> str:
    names = [grammar.name(part) for part in path]
    return "".join(f"{{{name}:" for name in names) + value + "}" * len(names)


def _yaml_line(key: str, value: str) -> str:
    head, *path = _segments(key)
    names = [name if re.fullmatch(_NAME, name) else f'"{name}"' for name in path]
    return f"{head}: " + "".join(f"{{{name}: " for name in names) + value + "}" * len(names)


def _several_values_hint(argument: str, override: Override) -> str:
    key, _, value = argument.partition("=")
    if value.startswith("glob("):
        return "for a sweep add -m"
    several = pasted.word(f"{key}=[{value}]")
    return f"for a sweep add -m; for one text {pasted.override(key, value)}; for a list {several}"
