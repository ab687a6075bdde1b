"""Configuration of the URDF writer."""

from typing import Annotated, Literal

from stages.robot.keys import Keys, Later


class UrdfKeys(Keys):
    """The URDF."""

    meshes: Annotated[Literal["relative"], Later("package")] = "relative"
    """How mesh files are named. relative: to the URDF's own folder."""

    fixed_joints: Annotated[Literal["keep"], Later("merge")] = "keep"
    """keep: frames are links on fixed joints."""


KEYS = UrdfKeys
