"""The validate stage: an engine reads the files that were written, and checks compare them with the robot."""

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

    from linkwright.stages.formats.written import Written
    from linkwright.stages.robot.check import Check
    from linkwright.stages.validate.compiled import FileKind
    from linkwright.stages.validate.own import OwnCheck
    from linkwright.stages.validate.section import ValidateSections

VERSION = 52
"""Grows with every change of what this stage makes of the same input."""

ENGINES = ("mujoco_engine",)
"""The engines: modules of `stages/validate/engines`, each an `Engine`."""

CHECKS: "dict[str, tuple[FileKind, ...]]" = {
    "links_and_joints": ("mjcf", "urdf", "scene"),
    "closed_at_start": ("mjcf", "urdf"),
    "masses": ("mjcf", "urdf"),
    "poses": ("mjcf", "urdf"),
    "placement": ("mjcf",),
    "joints": ("mjcf", "urdf"),
    "motion": ("mjcf", "urdf"),
    "parity": ("mjcf", "urdf"),
    "relations": ("mjcf", "urdf"),
    "loops": ("mjcf", "urdf"),
    "keyframes": ("mjcf", "scene"),
    "actuators": ("mjcf", "scene"),
    "gravity_compensation": ("mjcf",),
    "sensors": ("mjcf",),
    "source_elements": ("mjcf", "scene"),
    "self_contact": ("mjcf",),
    "false_contact": ("mjcf",),
    "contact_filter": ("mjcf",),
    "contact_properties": ("mjcf",),
    "scene": ("scene",),
    "surroundings": ("scene",),
    "options": ("simulated",),
    "inertial": ("simulated",),
    "mass_ratio": ("simulated",),
    "start": ("simulated",),
    "trial": ("simulated",),
    "rest": ("simulated",),
    "control_noise": ("simulated",),
    "time_step": ("simulated",),
    "energy": ("simulated",),
    "torque": ("simulated",),
    "shapes": ("mjcf",),
    "colliders": ("mjcf",),
    "bare_links": ("mjcf",),
    "hinge_axes": ("mjcf",),
    "reach": ("mjcf",),
    "urdf_shapes": ("urdf",),
}
"""The checks of a compiled model, in the order of the report, and of which files: modules of
`stages/validate/checks`, each with a `CODE` and a function `check` (a `CheckFunction`). What the scene has of
the robot is the MJCF's, so that what is true of the one needs no second look. Where the first check finds
that a link or joint is missing, the others, which look for each by its name, are left out."""

READ_BACK = {
    ".srdf": "srdf.read_back",
    ".sdf": "read.sdf",
    ".usda": "read.usd",
}
"""Formats that no engine reads, by the endings of their files: modules of this stage, each with a `CODE` and
a function `check_file`."""


def validate(
    folder: Path, written: "Written", keys: "ValidateSections", own: "Sequence[OwnCheck]" = ()
) -> "tuple[Check, ...]":
    """The checks of every model file in `folder`; with `validate=quick` only of its text, and that it
    compiles. A check that fails does not stop the others. `own`: the user's checks."""
    from linkwright.stages.validate.asked import Asked, known_payload
    from linkwright.stages.validate.run import check_files, check_read_back, check_texts, readiness

    checks = {} if keys.validate.level == "quick" else CHECKS
    payload = known_payload(written.robot, keys.validate.payload)
    asked = Asked(keys.validate.level == "strict", payload)
    read_back = check_read_back(folder, written, READ_BACK, quick=not checks)
    found = list(check_texts(folder, written, ENGINES))
    found += [*check_files(folder, written, ENGINES, checks, own if checks else (), asked), *read_back]
    if checks:
        found += readiness(folder, written, found, ENGINES)
    return tuple(found)


def measured(folder: Path, robot: str, level: str) -> dict[str, float]:
    """Figures of the finished files, with `validate=strict`: the machine's as much as the robot's."""
    if level != "strict":
        return {}
    from linkwright.stages.validate.speed import steps_per_second

    speed = steps_per_second(folder, robot)
    return {} if speed is None else {"steps_per_second": speed}
