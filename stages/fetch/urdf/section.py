"""Configuration of the source `urdf`."""

from typing import Annotated, Literal

from pydantic import Field

from linkwright.stages.fetch.source_section import Setting, SourceSection
from linkwright.stages.robot.section import Flag, Text, example


class UrdfSourceSection(SourceSection):
    """A URDF or a xacro file, and the meshes that it names."""

    kind: Literal["urdf"] = "urdf"
    """Kind of the source; `source=KIND` chooses it."""

    path: Annotated[Text, example("arm.urdf")]
    """The file, relative to the working directory. A file that ends in .xacro is expanded only with
    `source.trust=true`."""

    packages: Annotated[dict[Text, Text], example({"arm_description": "../arm"})] = Field(
        default_factory=dict
    )
    """Folders of ROS packages (`package://name/...`): name → folder, relative to the working directory.
    Other packages are found by ROS_PACKAGE_PATH and AMENT_PREFIX_PATH, and in folders around the file."""

    srdf: Annotated[Text, example("arm.srdf")] = "auto"
    """The SRDF of the robot, relative to the working directory: groups of joints, poses, pairs of links that
    do not collide, end effectors, passive joints, and whether the base is fixed. auto: the file beside the
    URDF or in ../srdf that has the URDF's name, else its robot's name, and ends in .srdf; none: no SRDF is
    read."""

    args: Annotated[dict[Text, Setting], example({"prefix": "left_"})] = Field(default_factory=dict)
    """Arguments of the xacro file: name → value."""

    trust: Flag = False
    """Whether a xacro file may be expanded. A xacro file is a program: allow it only for a file that you
    would run. Counts only on the command line, or if LINKWRIGHT_TRUST names the robot's file."""

    missing_meshes: Literal["refuse", "skip"] = "refuse"
    """Meshes that do not exist or cannot be read. refuse: an error; skip: build the robot without them."""

    bad_inertia: Literal["refuse", "recompute", "project"] = "refuse"
    """Inertias that no solid body can have. refuse: an error; recompute: from the link's mass and shapes, as
    a solid of even density; project: the nearest inertia that a solid body can have."""
