"""The validate stage: an engine reads the files that were written, and checks compare them with the robot.

- asked: What a configuration asks of the checks.
- compiled: A model file as an engine compiled it: what an engine returns, and what a check works with.
- contact_errors: Where the contact of a robot with itself is not that of what is seen of it, over poses
  within its limits.
- findings: What a check says of what it does not accept: element of the file, attribute, found and expected.
- own: The user's own checks: functions that are called with a compiled model, and what they find.
- run: The run of a validation: every engine reads its files, and every check looks at what it compiled.
- section: Configuration of the validate stage: how much is checked.
"""

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
    "mechanism.links_and_joints": ("mjcf", "urdf", "scene"),
    "mechanism.closed_at_start": ("mjcf", "urdf"),
    "mechanism.masses": ("mjcf", "urdf"),
    "mechanism.poses": ("mjcf", "urdf"),
    "mechanism.placement": ("mjcf",),
    "mechanism.joints": ("mjcf", "urdf"),
    "mechanism.motion": ("mjcf", "urdf"),
    "mechanism.parity": ("mjcf", "urdf"),
    "mechanism.relations": ("mjcf", "urdf"),
    "mechanism.loops": ("mjcf", "urdf"),
    "world.keyframes": ("mjcf", "scene"),
    "world.actuators": ("mjcf", "scene"),
    "simulation.gravity_compensation": ("mjcf",),
    "world.sensors": ("mjcf",),
    "world.source_elements": ("mjcf", "scene"),
    "contact.self_contact": ("mjcf",),
    "contact.false_contact": ("mjcf",),
    "contact.contact_filter": ("mjcf",),
    "contact.contact_properties": ("mjcf",),
    "world.scene": ("scene",),
    "world.surroundings": ("scene",),
    "world.options": ("simulated",),
    "mechanism.inertial": ("simulated",),
    "mechanism.mass_ratio": ("simulated",),
    "contact.start": ("simulated",),
    "simulation.trial": ("simulated",),
    "simulation.rest": ("simulated",),
    "simulation.control_noise": ("simulated",),
    "simulation.time_step": ("simulated",),
    "simulation.energy": ("simulated",),
    "simulation.torque": ("simulated",),
    "contact.shapes": ("mjcf",),
    "contact.colliders": ("mjcf",),
    "contact.bare_links": ("mjcf",),
    "mechanism.hinge_axes": ("mjcf",),
    "contact.reach": ("mjcf",),
    "mechanism.urdf_shapes": ("urdf",),
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
    from linkwright.stages.validate.simulate.speed import steps_per_second

    speed = steps_per_second(folder, robot)
    return {} if speed is None else {"steps_per_second": speed}
