"""`linkwright check DIR|FILE`: whether the files of a robot are right."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from linkwright.pipeline.checking.as_json import as_json, baseline
from linkwright.pipeline.checking.ask import checked
from linkwright.pipeline.checking.junit import as_junit
from linkwright.pipeline.checking.sarif import as_sarif
from linkwright.pipeline.checking.show import as_text
from linkwright.pipeline.errors import ConfigError, OutputError, reason
from linkwright.pipeline.terminal.output import say

HELP = """\
linkwright check: whether the files of a robot are right, as they are now.

usage: linkwright check [option ...] DIR|FILE

  linkwright check outputs/arm      all files of a build, after whatever was
                                    done to them
  linkwright check outputs/arm/arm.urdf
                                    one file of a build
  linkwright check some_robot.urdf  any URDF or MJCF, whoever made it
  linkwright check --json robots/arm > known.json
  linkwright check --baseline known.json robots/arm
                                    fails only for what was not found then
  linkwright check --sarif check.sarif --junit check.xml robots/arm
                                    for a code host, and for a CI server

The files are compared with robot.json, which lies beside them and says what the
robot is: masses, centers of mass and inertia of CAD's parts, poses, joints,
limits, loops, relations, keyframes, actuators, sensors, shapes. It alone
counts, so that it can be kept with the files in git. Without it a file is
checked by itself. Each check that does not pass names the file, the element and
the attribute, what was measured against what threshold, and what to do;
linkwright explain CODE says more. Files that need more time or memory than
their sizes explain, and what is no regular file, are refused.

options:
  --level quick|standard|strict
                    quick: the files compile; standard (the default): they are
                    the robot, and a simulation is stable; strict: a warning
                    fails, too
  --json            for programs, on the standard output
  --sarif FILE      also writes SARIF 2.1.0, with the line of each element
  --junit FILE      also writes JUnit XML
  --baseline FILE   what --json wrote earlier: what it has does not fail

exit status: 0 passed; 3 a check failed; 1 it cannot be read; 2 wrong usage
"""

_USAGE = "linkwright check DIR; linkwright check --help shows more"
_VALUED = ("--level", "--sarif", "--junit", "--baseline")
LEVELS = ("quick", "standard", "strict")


@dataclass(frozen=True, slots=True)
class _Asked:
    place: str
    json: bool
    values: dict[str, str]


def run(arguments: Sequence[str]) -> int:
    """Prints the verdict; the exit status. ConfigError for wrong usage, OutputError where something cannot be
    read or written."""
    asked = _parsed(arguments)
    known = baseline(asked.values["--baseline"]) if "--baseline" in asked.values else None
    verdict = replace(checked(asked.place, asked.values.get("--level", "standard")), known=known)
    if "--sarif" in asked.values:
        _write(asked.values["--sarif"], as_sarif(verdict).encode())
    if "--junit" in asked.values:
        _write(asked.values["--junit"], as_junit(verdict))
    if asked.json:
        print(as_json(verdict))
    else:
        say(as_text(verdict))
    return 0 if verdict.passed else 3


def _parsed(arguments: Sequence[str]) -> _Asked:
    waiting = list(arguments)
    places: list[str] = []
    values: dict[str, str] = {}
    as_json = False
    while waiting:
        word = waiting.pop(0)
        option, sign, value = word.partition("=")
        if option in _VALUED:
            if not sign and (not waiting or waiting[0].startswith("-")):
                raise ConfigError(f"{option} needs a value", "check", _USAGE)
            if option in values:
                raise ConfigError(f"{option} is there twice", "check", _USAGE)
            values[option] = value if sign else waiting.pop(0)
        elif word == "--json":
            as_json = True
        elif word.startswith("-"):
            raise ConfigError(f"there is no option {word}", "check", _USAGE)
        else:
            places.append(word)
    if values.get("--level", LEVELS[0]) not in LEVELS:
        msg = f"there is no level {values['--level']}"
        raise ConfigError(msg, "check --level", f"one of {', '.join(LEVELS)}")
    if len(places) != 1:
        msg = f"expected one folder or file, got {len(places)}"
        raise ConfigError(msg, "check", _USAGE)
    return _Asked(places[0], as_json, values)


def _write(file: str, data: bytes) -> None:
    try:
        Path(file).write_bytes(data)
    except OSError as error:
        raise OutputError(f"it cannot be written: {reason(error)}", file) from None
