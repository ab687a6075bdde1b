"""`linkwright check DIR|FILE`: checks whether the files of a robot are right."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from linkwright.pipeline.checking.as_document import as_document, baseline
from linkwright.pipeline.checking.ask import checked
from linkwright.pipeline.checking.junit import as_junit
from linkwright.pipeline.checking.sarif import as_sarif
from linkwright.pipeline.checking.show import as_text
from linkwright.pipeline.errors import ConfigError, OutputError, reason
from linkwright.pipeline.json_documents.document import CommandDocument
from linkwright.pipeline.reference.exit_status import BUILT, UNMET
from linkwright.pipeline.terminal.output import say

HELP = """\
linkwright check: checks whether the files of a robot are right as they are now.

usage: linkwright check [option ...] DIR|FILE

  linkwright check outputs/arm      all files of a build, with all edits since
  linkwright check outputs/arm/arm.urdf
                                    one file of a build
  linkwright check some_robot.urdf  any URDF or MJCF, whoever made it
  linkwright check --target mjx some_robot.xml
                                    whether MJX takes the file
  linkwright check --json robots/arm > known.json
  linkwright check --baseline known.json robots/arm
                                    fails only for new findings
  linkwright check --sarif check.sarif --junit check.xml robots/arm
                                    for a code host, and for a CI server

The files are compared with the robot.json beside them, which describes the
robot: masses, centers of mass and inertia of CAD's parts, poses, joints,
limits, loops, relations, keyframes, actuators, sensors, shapes. Nothing else is
needed, so it can be kept with the files in git. Without a robot.json a file is
checked by itself. Each check that does not pass names the file, the element and
the attribute, the measured value and its threshold, and what to do; linkwright
explain CODE says more. Files that need more time or memory than their sizes
explain are refused, and so are pipes and devices.

options:
  --level quick|standard|strict
                    quick: the files compile; standard (the default): they
                    describe the same robot, and a simulation is stable;
                    strict: a warning fails, too
  --target NAME     checks only whether that engine takes the file, as a build
                    with target=NAME does, and names each thing that it does
                    not take: mjx, mjwarp, mujoco (or mujoco:3.11), newton,
                    isaac, gazebo, pybullet, drake; several with commas between
  --json            prints one JSON document
  --sarif FILE      also writes SARIF 2.1.0, with the line of each element
  --junit FILE      also writes JUnit XML
  --baseline FILE   an earlier output of --json: its findings do not fail again
"""

_USAGE = "linkwright check DIR; linkwright check --help shows more"
_OPTIONS_WITH_VALUE = ("--level", "--target", "--sarif", "--junit", "--baseline")
TARGETS = (
    *("mjx", "mjwarp", "mujoco", *(f"mujoco:{version}" for version in ("3.11", "3.16", "3.17", "4.0"))),
    *("newton", "isaac", "gazebo", "pybullet", "drake"),
)
"""The engines of `stages.targets.engines`, whose import takes longer than this verb's help."""
LEVELS = ("quick", "standard", "strict")


@dataclass(frozen=True, slots=True)
class _CheckRequest:
    """The parsed arguments; `values`: option → value."""

    place: str
    json: bool
    values: dict[str, str]

    @property
    def targets(self) -> list[str]:
        """The requested engines."""
        return [name.strip() for name in self.values.get("--target", "").split(",") if name.strip()]


def run(arguments: Sequence[str]) -> int | CommandDocument:
    """Prints the verdict and returns the exit status, or returns its document. Raises ConfigError for wrong
    usage, and OutputError if a file cannot be read or written."""
    request = _parsed(arguments)
    issues = baseline(request.values["--baseline"]) if "--baseline" in request.values else None
    checks = checked(request.place, request.values.get("--level", "standard"), request.targets)
    verdict = replace(checks, baseline=issues)
    if "--sarif" in request.values:
        _write(request.values["--sarif"], as_sarif(verdict).encode())
    if "--junit" in request.values:
        _write(request.values["--junit"], as_junit(verdict))
    if request.json:
        return as_document(verdict)
    say(as_text(verdict))
    return BUILT if verdict.passed else UNMET


def _parsed(arguments: Sequence[str]) -> _CheckRequest:
    remaining = list(arguments)
    places: list[str] = []
    values: dict[str, str] = {}
    as_json = False
    while remaining:
        word = remaining.pop(0)
        option, sign, value = word.partition("=")
        if option in _OPTIONS_WITH_VALUE:
            if not sign and (not remaining or remaining[0].startswith("-")):
                raise ConfigError(f"{option} needs a value", "check", _USAGE)
            if option in values:
                raise ConfigError(f"{option} is there twice", "check", _USAGE)
            values[option] = value if sign else remaining.pop(0)
        elif word == "--json":
            as_json = True
        elif word.startswith("-"):
            raise ConfigError(f"there is no option {word}", "check", _USAGE)
        else:
            places.append(word)
    if values.get("--level", LEVELS[0]) not in LEVELS:
        msg = f"there is no level {values['--level']}"
        raise ConfigError(msg, "check --level", f"one of {', '.join(LEVELS)}")
    request = _CheckRequest(places[0] if places else "", as_json, values)
    for name in request.targets:
        if name not in TARGETS:
            raise ConfigError(f"there is no target {name}", "check --target", f"one of {', '.join(TARGETS)}")
    if len(places) != 1:
        msg = f"expected one folder or file, got {len(places)}"
        raise ConfigError(msg, "check", _USAGE)
    return request


def _write(file: str, data: bytes) -> None:
    try:
        Path(file).write_bytes(data)
    except OSError as error:
        raise OutputError(f"it cannot be written: {reason(error)}", file) from None
