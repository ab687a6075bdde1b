"""`linkwright explain CODE|KEY|MOTOR`: the entry of a diagnostic, a key, a motor or a variable of the
environment."""

import textwrap
from collections.abc import Sequence
from pathlib import Path

from linkwright.pipeline.errors import ConfigError
from linkwright.pipeline.motor_files import library
from linkwright.pipeline.reference import SCHEMA
from linkwright.pipeline.reference.codes import explanations, level, remedy
from linkwright.pipeline.reference.environment import VARIABLES
from linkwright.pipeline.reference.key_entries import KeyEntry, entries, matching, nearest
from linkwright.pipeline.terminal.output import say

HELP = """\
linkwright explain: the meaning of a code, a key, a motor or an environment
variable.

usage: linkwright explain CODE|KEY|MOTOR|VARIABLE
       linkwright explain --schema

  linkwright explain W-LIMIT        a code of a diagnostic or check: its
                                    meaning, and what to do
  linkwright explain joints.elbow.damping
                                    a key: its type, unit, default, allowed
                                    values, an example
  linkwright explain mesh           a section: its keys
  linkwright explain sts3215        a motor of the library: its values, and
                                    their sources
  linkwright explain --schema       the path of the JSON Schema of robot files,
                                    for editors

exit status: 0 explained; 2 no such code, key, motor or variable
"""

_WIDTH = 80
_FACTS = ("type", "unit", "default", "allowed", "example")


def run(arguments: Sequence[str]) -> int:
    """Prints the entry; the exit status. ConfigError where nothing has that name."""
    if len(arguments) != 1:
        msg = f"expected one code, key or variable, got {' '.join(arguments) or 'nothing'}"
        raise ConfigError(msg, "explain", "linkwright explain W-LIMIT; linkwright explain --help")
    (asked,) = arguments
    if asked == "--schema":
        print(SCHEMA)
    else:
        say(explained(asked))
    return 0


def names() -> list[str]:
    """Everything that can be explained."""
    keys = (entry.key for entry in entries())
    return [*explanations(), *keys, *(one.name for one in VARIABLES), *library([Path.cwd()])]


def explained(asked: str) -> str:
    """The entry for a code, a key or a variable."""
    code = asked.upper()
    if code in explanations():
        return _code(code)
    variable = next((one for one in VARIABLES if one.name == code), None)
    if variable is not None:
        return _entry(variable.name, variable.meaning)
    motors = library([Path.cwd()])
    if asked in motors:
        return _motor(asked, motors[asked])
    found = matching(asked.partition("=")[0].strip("."), entries())
    if not found:
        near = nearest(asked, names()) or nearest(code, names())
        hint = f"did you mean {' or '.join(near)}?" if near else "linkwright --help lists the keys"
        raise ConfigError("there is no such code, key, motor or variable", asked, hint)
    return "\n\n".join(_key(entry) for entry in found)


def _code(code: str) -> str:
    found = explanations()[code]
    title = f"{code} ({level(code)}, reported by {found.stages})"
    if level(code) == "check":
        title = f"{code} (a check: {found.stages} where it does not pass)"
    return _entry(title, found.meaning, *([f"→ {remedy(code)}"] if remedy(code) else []))


def _motor(name: str, file: Path) -> str:
    """The entry of a motor; ConfigError where its file is wrong."""
    # Late: only values of motors need the plan, which imports pydantic.
    from linkwright.pipeline.config.plan import Plan
    from linkwright.stages.export.configuration.motor_section import QUANTITIES

    tree = {"source": {"kind": "sample"}, "actuators": {"*": {"motor": name}}}
    motor = Plan.parse(tree, folders=[Path.cwd()]).motors[name]
    lines = [_entry(f"{name} (a motor: actuators.<glob>.motor={name})", motor.title, motor.notes or "")]
    for quantity, one in motor.values.items():
        unit = "" if QUANTITIES[quantity] == "-" else f" {QUANTITIES[quantity]}"
        lines.append(f"  {quantity:<15} {one.value:g}{unit} ({one.kind})")
        lines.append(textwrap.fill(one.source, _WIDTH, initial_indent=" " * 6, subsequent_indent=" " * 6))
    return "\n".join(lines)


def _key(entry: KeyEntry) -> str:
    title = f"{entry.key} (of source={entry.source})" if entry.source else entry.key
    meaning = f"Not supported yet. {entry.meaning}" if entry.later else entry.meaning
    facts = {name: getattr(entry, name) for name in _FACTS}
    lines = [_entry(title, meaning), *(f"  {name:<8} {value}" for name, value in facts.items() if value)]
    label = "keys"
    for key in _inside(entry):
        lines.append(f"  {label:<8} {key}")
        label = ""
    return "\n".join(lines)


def _inside(entry: KeyEntry) -> list[str]:
    """The supported keys in a section."""
    found = [
        one.key
        for one in entries()
        if one.key.startswith(f"{entry.key}.") and not one.is_section and not one.later
    ]
    return list(dict.fromkeys(found)) if entry.is_section else []


def _entry(title: str, *paragraphs: str) -> str:
    wrapped = [textwrap.fill(one, _WIDTH, initial_indent="  ", subsequent_indent="  ") for one in paragraphs]
    return "\n".join([title, *wrapped])
