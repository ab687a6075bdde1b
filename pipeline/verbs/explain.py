"""`linkwright explain CODE|KEY|MOTOR`: explains a diagnostic, a key, a motor or an environment variable."""

import functools
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
from linkwright.pipeline.verbs.launcher_lines import LauncherLines, launcher_lines

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
    """Prints the entry and returns the exit status. Raises ConfigError if nothing has that name."""
    if len(arguments) != 1:
        msg = f"expected one code, key or variable, got {' '.join(arguments) or 'nothing'}"
        raise ConfigError(msg, "explain", "linkwright explain W-LIMIT; linkwright explain --help")
    (name,) = arguments
    if name == "--schema":
        print(SCHEMA)
    else:
        say(explained(name))
    return 0


def names() -> list[str]:
    """Returns the names of everything that can be explained."""
    keys = (entry.key for entry in entries())
    variables = (variable.name for variable in VARIABLES)
    return [*explanations(), *keys, *variables, *library([Path.cwd()]), "hydra/launcher"]


def explained(name: str) -> str:
    """Returns the entry for a code, a key, a motor or a variable; raises ConfigError if there is none."""
    code = name.upper()
    if code in explanations():
        return _code(code)
    variable = next((entry for entry in VARIABLES if entry.name == code), None)
    if variable is not None:
        return _entry(variable.name, variable.meaning)
    motors = library([Path.cwd()])
    if name in motors:
        return _motor(name)
    launchers = launcher_lines(name)
    if launchers:
        return "\n\n".join(_launcher(launcher) for launcher in launchers)
    matches = matching(name.partition("=")[0].strip("."), entries())
    if not matches:
        candidates = nearest(name, names()) or nearest(code, names())
        hint = (
            f"did you mean {' or '.join(candidates)}?" if candidates else "linkwright --help lists the keys"
        )
        raise ConfigError("there is no such code, key, motor or variable", name, hint)
    return "\n\n".join(_key(entry) for entry in matches)


def _code(code: str) -> str:
    explanation = explanations()[code]
    title = f"{code} ({level(code)}, reported by {explanation.stages})"
    if level(code) == "check":
        title = f"{code} (a check: {explanation.stages} where it does not pass)"
    return _entry(title, explanation.meaning, *([f"→ {remedy(code)}"] if remedy(code) else []))


def _motor(name: str) -> str:
    """Returns the entry of a motor; raises ConfigError if its file is wrong."""
    # Late: only values of motors need the plan, which imports pydantic.
    from linkwright.pipeline.verbs.motor_lines import motor_lines

    title, notes, lines = motor_lines(name)
    heading = _entry(f"{name} (a motor: actuators.<glob>.motor={name})", title, notes)
    wrap = functools.partial(textwrap.fill, width=_WIDTH, initial_indent=" " * 6, subsequent_indent=" " * 6)
    return "\n".join([heading, *(line for value, source in lines for line in (value, wrap(source)))])


def _launcher(launcher: LauncherLines) -> str:
    heading = _entry(f"{launcher.title} (of sweeps: linkwright -m)", launcher.meaning)
    return "\n".join([heading, *(f"  {line}" for line in launcher.keys)])


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
    """Returns the supported keys in a section."""
    keys = [
        inner.key
        for inner in entries()
        if inner.key.startswith(f"{entry.key}.") and not inner.is_section and not inner.later
    ]
    return list(dict.fromkeys(keys)) if entry.is_section else []


def _entry(title: str, *paragraphs: str) -> str:
    wrapped = [
        textwrap.fill(paragraph, _WIDTH, initial_indent="  ", subsequent_indent="  ")
        for paragraph in paragraphs
    ]
    return "\n".join([title, *wrapped])
