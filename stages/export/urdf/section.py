"""Defines the configuration of the URDF writer."""

from typing import Annotated, Literal

from pydantic import AfterValidator

from linkwright.stages.export.configuration.format_section import FormatSection
from linkwright.stages.robot.section import Text, example, invalid


def _as_package(name: str) -> str:
    """Returns the name if a `package://` path can have it; raises a validation error otherwise."""
    if not (name[0].isalpha() and name.isascii() and name.replace("_", "").replace("-", "").isalnum()):
        raise invalid("must be the name of a package: a letter, then letters, digits, _ or -")
    return name


class UrdfFormatSection(FormatSection):
    """The URDF."""

    files = ("<name>.urdf", "<name>.srdf")

    meshes: Literal["relative", "package"] = "relative"
    """How the URDF names mesh files and textures. relative: by paths relative to its own folder; package: as
    `package://<package>/assets/...`, for ROS, where the package holds the folder `assets`."""

    package: Annotated[Text, AfterValidator(_as_package), example("my_arm_description")] | None = None
    """The package of `meshes: package`; null: the robot's name."""

    fixed_joints: Literal["keep", "merge"] = "keep"
    """Links on fixed joints. keep: they stay links; merge: each becomes part of its parent, with its mass,
    inertia and shapes, except for links that are fixed to a link `world`. Frames are links on fixed joints in
    both cases."""

    frame_inertia: Literal["none", "tiny"] = "none"
    """The inertial of links without mass: frames, and both sides of a loop. none: no inertial; tiny: 1e-12 kg
    and 1e-12 kg m², for readers that assume 1 kg if there is no inertial, as PyBullet does."""
