"""Completes the configuration with the settings of the MJCF source and the targets."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

from linkwright.stages.export.configuration.mujoco_section import DEFAULTS, FlagsSection
from linkwright.stages.export.ground.standing import stands_in_source
from linkwright.stages.robot.errors import Diagnostic
from linkwright.stages.robot.model.mjcf_extras import NO_EXTRAS
from linkwright.stages.robot.model.robot import Robot
from linkwright.stages.targets.diagnostic import replacement_diagnostic
from linkwright.stages.targets.options import PASSIVE_FLAGS, flags_of, options_of, targets_replacing

if TYPE_CHECKING:
    from linkwright.stages.export.section import ExportSection, ExportSections


def settle(keys: "ExportSections", robot: Robot) -> "ExportSections":
    """Returns the keys with all of MuJoCo's options: the user's have precedence over those of the targets, of
    the source, and the defaults. The ground is left out if the source has one, and the keys of formats have
    the values that a target needs."""
    extras, targets = robot.mjcf or NO_EXTRAS, keys.target.chosen
    scene, option = keys.scene, keys.scene.option
    target_options, target_flags = keys.target.options_and_flags
    flags = flags_of(targets, {**dict(extras.flag), **target_flags, **option.flag.explicit()})
    # Not validated: a source may have a flag that the section does not know.
    flag_section = FlagsSection().model_copy(update=flags)
    options = {**DEFAULTS, **dict(extras.option), **target_options, **option.explicit()}
    settled_option = option.model_copy(update={**options_of(targets, options), "flag": flag_section})
    ground = keys.ground
    if stands_in_source(robot, keys):
        ground = ground.model_copy(update={"kind": "none"})
    scene = scene.model_copy(update={"option": settled_option})
    return keys.model_copy(update={"scene": scene, "ground": ground, "export": _formats(keys)})


def _formats(keys: "ExportSections") -> "ExportSection":
    """Returns the formats. Frames get a tiny inertial if a target assumes 1 kg for links without one."""
    urdf = keys.export.urdf
    if urdf is None or not targets_replacing(keys.target.chosen, "frames"):
        return keys.export
    urdf = urdf.model_copy(update={"frame_inertia": "tiny"})
    formats: ExportSection = keys.export.model_copy(update={"urdf": urdf})
    return formats


def report_changes(keys: "ExportSections", robot: Robot) -> Iterator[Diagnostic]:
    """Reports each setting of the user's keys that a target sets or replaces (I-TARGET)."""
    extras, option, target = robot.mjcf or NO_EXTRAS, keys.scene.option, keys.target
    user = {**option.explicit(), **option.flag.explicit()}
    old_values = {**DEFAULTS, **dict(extras.option), **dict(extras.flag), **user}
    for name in target.chosen:
        new_values = {
            key: value
            for target_name, key, value in target.settings
            if target_name == name and key not in user
        }
        new_values = {
            key: value for key, value in new_values.items() if str(old_values.get(key)) != str(value)
        }
        if new_values:
            pairs = (f"{key} ({old_values.get(key, 'unset')} → {value})" for key, value in new_values.items())
            first = next(iter(new_values))
            hint = f"target.{name}.{first}=null leaves it, and scene.option comes first"
            yield replacement_diagnostic(f"MuJoCo's options: {', '.join(pairs)}", [name], hint)
    targets = targets_replacing(target.chosen, "solver PGS")
    if targets and old_values.get("solver") == "PGS":
        yield replacement_diagnostic(
            "MuJoCo's option solver: PGS → Newton, which looks for the same forces", targets
        )
    for name, thing in PASSIVE_FLAGS.items():
        targets = targets_replacing(target.chosen, thing)
        if targets and old_values.get(name) == "enable":
            yield replacement_diagnostic(
                f"MuJoCo's flag {name}: enable → left out, which moves nothing", targets
            )
    urdf = keys.export.urdf
    targets = targets_replacing(target.chosen, "frames")
    if targets and urdf is not None and urdf.frame_inertia != "tiny" and robot.frames:
        yield replacement_diagnostic(f"export.urdf.frame_inertia: {urdf.frame_inertia} → tiny", targets)
