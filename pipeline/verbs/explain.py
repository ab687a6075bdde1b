"""`linkwright explain CODE|KEY|MOTOR`: explains a diagnostic, a key, a motor or an environment variable."""

import functools
import textwrap
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from linkwright.pipeline.errors import ConfigError
from linkwright.pipeline.json_documents.document import CommandDocument
from linkwright.pipeline.json_documents.explain import EntryDocument, ExplainDocument
from linkwright.pipeline.motor_files import library
from linkwright.pipeline.options import JSON
from linkwright.pipeline.reference import ROBOT_JSON_SCHEMA, SCHEMA, exit_status, schemas
from linkwright.pipeline.reference.codes import explanations, level, remedy
from linkwright.pipeline.reference.environment import VARIABLES
from linkwright.pipeline.reference.key_entries import KeyEntry, entries, matching, nearest
from linkwright.pipeline.terminal.output import say
from linkwright.pipeline.verbs.launcher_lines import launcher_lines

HELP = """\
linkwright explain: the meaning of a code, a key, a motor or an environment
variable.

usage: linkwright explain [--json] CODE|KEY|MOTOR|VARIABLE
       linkwright explain --schema [NAME]

  linkwright explain W-LIMIT        a code of a diagnostic or check: its
                                    meaning, and what to do
  linkwright explain joints.elbow.damping
                                    a key: its type, unit, default, allowed
                                    values, an example
  linkwright explain mesh           a section: its keys
  linkwright explain sts3215        a motor of the library: its values, and
                                    their sources
  linkwright explain exit           the exit status of every command
  linkwright explain --schema       the path of the JSON Schema of robot files,
                                    for editors
  linkwright explain --schema build
                                    the path of the JSON Schema of what a
                                    command prints with --json: build, sweep,
                                    jobs, error, bundle, cache, check, diff,
                                    doctor, explain, new; or of robot_json

With --json one JSON document is printed.
"""

EXIT = "exit"
"""The name of the exit status of all commands."""

ROBOT = "robot"
"""The name of the JSON Schema of robot files."""

_WIDTH = 80
_FACTS = ("type", "unit", "default", "allowed", "example")


def run(arguments: Sequence[str]) -> int | CommandDocument:
    """Prints the entry and returns the exit status, or returns the document of the entry. Raises ConfigError
    if nothing has that name."""
    words = [argument for argument in arguments if argument != JSON]
    entries_of_name: tuple[EntryDocument, ...]
    if words[:1] == ["--schema"] and len(words) <= 2:
        entries_of_name = (_schema(words[1] if len(words) == 2 else ROBOT),)
    elif len(words) == 1:
        entries_of_name = documents(words[0])
    else:
        msg = f"expected one code, key or variable, got {' '.join(words) or 'nothing'}"
        raise ConfigError(msg, "explain", "linkwright explain W-LIMIT; linkwright explain --help")
    if JSON in arguments:
        return ExplainDocument(0, entries_of_name)
    if entries_of_name[0].path:
        print(entries_of_name[0].path)  # in one line, also on a narrow terminal
    else:
        say(as_text(entries_of_name))
    return 0


def names() -> list[str]:
    """Returns the names of everything that can be explained."""
    keys = (entry.key for entry in entries())
    variables = (variable.name for variable in VARIABLES)
    return [*explanations(), *keys, *variables, *library([Path.cwd()]), "hydra/launcher", EXIT]


def explained(name: str) -> str:
    """Returns the explanation of a code, a key, a motor or a variable as text; raises ConfigError if there is
    none."""
    return as_text(documents(name))


def as_text(documents: Iterable[EntryDocument]) -> str:
    """Returns entries as text."""
    return "\n\n".join(map(_text, documents))


def documents(name: str) -> tuple[EntryDocument, ...]:
    """Returns the entries for a code, a key, a motor or a variable; raises ConfigError if there is none."""
    code = name.upper()
    if code in explanations():
        explanation = explanations()[code]
        texts = explanation.meaning, remedy(code), level(code), explanation.stages
        return (EntryDocument("code", code, *texts),)
    if name.lower() == EXIT:
        meanings = exit_status.table()
        return (EntryDocument("exit_status", EXIT, meanings),)
    variable = next((entry for entry in VARIABLES if entry.name == code), None)
    if variable is not None:
        return (EntryDocument("variable", variable.name, variable.meaning),)
    if name in library([Path.cwd()]):
        return (_motor(name),)
    launchers = launcher_lines(name)
    if launchers:
        return tuple(
            EntryDocument("launcher", launcher.title, launcher.meaning, keys=launcher.keys)
            for launcher in launchers
        )
    matches = matching(name.partition("=")[0].strip("."), entries())
    if not matches:
        candidates = nearest(name, names()) or nearest(code, names())
        hint = (
            f"did you mean {' or '.join(candidates)}?" if candidates else "linkwright --help lists the keys"
        )
        raise ConfigError("there is no such code, key, motor or variable", name, hint)
    return tuple(map(_key, matches))


def _schema(name: str) -> EntryDocument:
    """Returns the entry of a JSON Schema; raises ConfigError if there is none of that name."""
    paths = {ROBOT: SCHEMA, "robot_json": ROBOT_JSON_SCHEMA, **schemas()}
    if name not in paths:
        raise ConfigError(f"there is no schema {name}", "explain --schema", f"one of {', '.join(paths)}")
    return EntryDocument("schema", name, f"The JSON Schema {name}.", path=str(paths[name]))


def _motor(name: str) -> EntryDocument:
    """Returns the entry of a motor; raises ConfigError if its file is wrong."""
    # Late: only values of motors need the plan, which imports pydantic.
    from linkwright.pipeline.verbs.motor_lines import motor_lines

    title, notes, lines = motor_lines(name)
    values = tuple(text.strip() for line in lines for text in line)
    return EntryDocument("motor", name, f"{title}\n{notes}".strip(), values=values)


def _key(entry: KeyEntry) -> EntryDocument:
    return EntryDocument(
        kind="key",
        name=entry.key,
        meaning=entry.meaning,
        source=entry.source,
        type=entry.type,
        unit=entry.unit,
        default=entry.default,
        allowed=entry.allowed,
        words=entry.words,
        example=entry.example,
        is_later=entry.later,
        keys=tuple(_inner_keys(entry)),
    )


def _inner_keys(entry: KeyEntry) -> list[str]:
    """Returns the supported keys in a section."""
    keys = [
        inner.key
        for inner in entries()
        if inner.key.startswith(f"{entry.key}.") and not inner.is_section and not inner.later
    ]
    return list(dict.fromkeys(keys)) if entry.is_section else []


def _text(entry: EntryDocument) -> str:
    """Returns an entry as text."""
    if entry.kind == "code":
        title = f"{entry.name} ({entry.level}, reported by {entry.stages})"
        if entry.level == "check":
            title = f"{entry.name} (a check: {entry.stages} where it does not pass)"
        return _entry(title, entry.meaning, *([f"→ {entry.hint}"] if entry.hint else []))
    if entry.kind == "motor":
        heading = _entry(
            f"{entry.name} (a motor: actuators.<glob>.motor={entry.name})", *entry.meaning.split("\n", 1)
        )
        return "\n".join([heading, *_value_lines(entry.values)])
    if entry.kind == "launcher":
        heading = _entry(f"{entry.name} (of sweeps: linkwright -m)", entry.meaning)
        return "\n".join([heading, *(f"  {line}" for line in entry.keys)])
    if entry.kind == "exit_status":
        return _entry("exit status", *entry.meaning.splitlines())
    return _key_text(entry) if entry.kind == "key" else _entry(entry.name, entry.meaning)


def _value_lines(values: Sequence[str]) -> Iterator[str]:
    """Yields the lines of a motor's values, each followed by its source."""
    wrap = functools.partial(textwrap.fill, width=_WIDTH, initial_indent=" " * 6, subsequent_indent=" " * 6)
    for value, source in zip(values[::2], values[1::2], strict=True):
        yield f"  {value}"
        yield wrap(source)


def _key_text(entry: EntryDocument) -> str:
    title = f"{entry.name} (of source={entry.source})" if entry.source else entry.name
    meaning = f"Not supported yet. {entry.meaning}" if entry.is_later else entry.meaning
    facts = {name: getattr(entry, name) for name in _FACTS}
    lines = [_entry(title, meaning), *(f"  {name:<8} {value}" for name, value in facts.items() if value)]
    label = "keys"
    for key in entry.keys:
        lines.append(f"  {label:<8} {key}")
        label = ""
    return "\n".join(lines)


def _entry(title: str, *paragraphs: str) -> str:
    wrapped = [
        textwrap.fill(paragraph, _WIDTH, initial_indent="  ", subsequent_indent="  ")
        for paragraph in paragraphs
    ]
    return "\n".join([title, *wrapped])
