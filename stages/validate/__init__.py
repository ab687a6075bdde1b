"""The validate stage: an engine reads the files that were written, and checks compare them with the robot."""

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

    from stages.formats.mjcf_form import MjcfForm
    from stages.formats.urdf.form import UrdfForm
    from stages.formats.urdf.srdf_form import SrdfForm
    from stages.robot.actuation import Actuation
    from stages.robot.amendments import Amendments
    from stages.robot.check import Check
    from stages.robot.geometry import Geometry
    from stages.robot.model import Robot
    from stages.robot.scene import Scene
    from stages.robot.sensing import Sensing
    from stages.validate.compiled import FileKind
    from stages.validate.keys import ValidateKeys
    from stages.validate.own import OwnCheck

VERSION = 51
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
    "loop_ends": ("urdf",),
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

READ_BACK = (("srdf", ".srdf"), ("sdf", ".sdf"), ("usd", ".usda"))
"""Formats that no engine reads, with the endings of their files: rooms of this stage, each with a module
`read_back` that has the checks."""


def validate(
    folder: Path,
    robot: "Robot",
    keys: "ValidateKeys",
    actuation: "Actuation | None" = None,
    geometry: "Geometry | None" = None,
    form: "UrdfForm | None" = None,
    mjcf_form: "MjcfForm | None" = None,
    sensing: "Sensing | None" = None,
    amendments: "Amendments | None" = None,
    scene: "Scene | None" = None,
    own: "Sequence[OwnCheck]" = (),
    srdf: "SrdfForm | None" = None,
) -> "tuple[Check, ...]":
    """The checks of every model file in `folder`; with `validate=quick` only of its text, and that it
    compiles. A check that fails does not stop the others. `actuation`: what drives the robot in these files;
    `geometry`: its shapes, without their files, and which of them collide; `form`: how the URDF differs
    from the robot, by default as closed loops ask; `mjcf_form`: how the MJCF does, by default with links on
    fixed joints as part of others; `sensing`: what measures the robot; `amendments`: what
    the user's own XML changed in the files; `scene`: where these put the robot; `own`: the user's checks;
    `srdf`: what only the SRDF says."""
    from stages.formats import mjcf_written
    from stages.formats.urdf.as_written import form_with
    from stages.robot.actuation import NONE
    from stages.robot.amendments import UNCHANGED
    from stages.robot.sensing import NOTHING
    from stages.validate.asked import Asked, known_payload
    from stages.validate.expected import Expected
    from stages.validate.run import check_files, check_read_back, check_texts, readiness

    checks = {} if keys.validate.level == "quick" else CHECKS
    forms = form or form_with(robot), mjcf_form or mjcf_written.form_with(robot)
    known = (actuation or NONE, geometry, *forms, sensing or NOTHING, amendments or UNCHANGED)
    asked = Asked(keys.validate.level == "strict", known_payload(robot, keys.validate.payload))
    expected = Expected(known[0], geometry, forms[0], known[-1], scene, known[4], srdf)
    read_back = check_read_back(folder, robot, READ_BACK, expected, quick=not checks)
    found = list(check_texts(folder, robot.name, ENGINES, known[-1], form))
    found += [
        *check_files(folder, robot, ENGINES, checks, *known, scene, own if checks else (), asked),
        *read_back,
    ]
    if checks:
        found += readiness(folder, robot, found, ENGINES, geometry, forms[1])
    return tuple(found)


def measured(folder: Path, robot: str, level: str) -> dict[str, float]:
    """Figures of the finished files, with `validate=strict`: the machine's as much as the robot's."""
    if level != "strict":
        return {}
    from stages.validate.speed import steps_per_second

    speed = steps_per_second(folder, robot)
    return {} if speed is None else {"steps_per_second": speed}
