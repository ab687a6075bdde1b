"""The configuration with what an MJCF source says where the configuration says nothing."""

from typing import TYPE_CHECKING

from linkwright.stages.export.configuration.mujoco_section import DEFAULTS
from linkwright.stages.export.ground.standing import stands_in_source
from linkwright.stages.robot.model.mjcf_extras import NO_EXTRAS
from linkwright.stages.robot.model.robot import Robot

if TYPE_CHECKING:
    from linkwright.stages.export.section import ExportSections


def settled(keys: "ExportSections", robot: Robot) -> "ExportSections":
    """The keys with MuJoCo's options, those of the source before our defaults, and without a ground of ours
    where the source has one."""
    extras = robot.mjcf or NO_EXTRAS
    scene, option = keys.scene, keys.scene.option
    flags = option.flag.model_copy(update={**dict(extras.flag), **option.flag.given()})
    options = {**DEFAULTS, **dict(extras.option), **option.given()}
    given = option.model_copy(update={**options, "flag": flags})
    ground = keys.ground
    if stands_in_source(robot, keys):
        ground = ground.model_copy(update={"kind": "none"})
    return keys.model_copy(update={"scene": scene.model_copy(update={"option": given}), "ground": ground})
