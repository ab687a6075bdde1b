"""Configuration of the URDF writer."""

from typing import Annotated, Literal

from stages.robot.keys import Keys, Later


class UrdfFormatKeys(Keys):
    """The URDF."""

    meshes: Annotated[Literal["relative"], Later("package")] = "relative"
    """How the URDF names mesh files. relative: by paths relative to its own folder."""

    fixed_joints: Annotated[Literal["keep"], Later("merge")] = "keep"
    """Fixed joints. keep: each frame is a link on a fixed joint."""


KEYS = UrdfFormatKeys
