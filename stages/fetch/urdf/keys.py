"""Configuration of the source `urdf`."""

from typing import Literal

from pydantic import Field

from stages.fetch.source_keys import Setting, SourceKeys
from stages.robot.keys import Flag, Text


class UrdfSourceKeys(SourceKeys):
    """A URDF, or a xacro file that makes one, and the meshes that it names."""

    kind: Literal["urdf"] = "urdf"
    """Tells the sources apart."""

    path: Text
    """The file, relative to the working directory. One that ends in .xacro is expanded where `trust` says
    so."""

    packages: dict[Text, Text] = Field(default_factory=dict)
    """Folders of packages (`package://name/...`), before where ROS_PACKAGE_PATH, AMENT_PREFIX_PATH and the
    folders around the file have them: name → folder, relative to the working directory."""

    args: dict[Text, Setting] = Field(default_factory=dict)
    """Arguments of the xacro file: name → value."""

    trust: Flag = False
    """Whether a xacro file may be expanded: it is a program, so only where you would run it. Counts on the
    command line alone."""

    missing_meshes: Literal["refuse", "skip"] = "refuse"
    """Meshes that are not there or cannot be read: refuse the robot, or build it without them."""

    bad_inertia: Literal["refuse", "recompute", "project"] = "refuse"
    """Inertias that no body can have: refuse the robot; recompute: from the link's mass and shapes, solid;
    project: take the nearest that a body can have."""


KEYS = UrdfSourceKeys
