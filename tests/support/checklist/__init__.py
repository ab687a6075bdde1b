"""What a model of the grade of MuJoCo Menagerie must meet: points that a file, or what MuJoCo compiles of it,
has or has not. Each is a function of a build that names the faults it finds; none when all is well.

Nothing here asks the product: files are read as XML and JSON, and simulated by MuJoCo.
"""

import json
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import mujoco
import numpy as np
from lxml import etree


@dataclass(frozen=True)
class Built:
    """The folder of a build, and what its source says of it: the total mass [kg]. `cad`: whether the masses
    are those of CAD, not of a file that somebody wrote."""

    folder: Path
    mass: float | None = None
    cad: bool = True

    @cached_property
    def report(self):
        return json.loads((self.folder / "report.json").read_text())

    @cached_property
    def robot(self):
        return json.loads((self.folder / "robot.json").read_text())

    @property
    def as_its_file(self):
        """Whether the source is an MJCF, whose order, bodies, colliders and options stay."""
        return "mjcf" in self.robot

    @property
    def path(self):
        return self.folder / f"{self.robot['name']}.xml"

    @cached_property
    def xml(self):
        return etree.parse(str(self.path)).getroot()

    @cached_property
    def scene_xml(self):
        return etree.parse(str(self.folder / "scene.xml")).getroot()

    @cached_property
    def model(self):
        """The robot alone."""
        return mujoco.MjModel.from_xml_path(str(self.path))

    @cached_property
    def scene(self):
        """The robot in its world."""
        return mujoco.MjModel.from_xml_path(str(self.folder / "scene.xml"))

    @cached_property
    def messages(self):
        """The messages of the build's diagnostics, a line each."""
        return "\n".join(diagnostic["message"] for diagnostic in self.report["diagnostics"])

    @property
    def dofs(self):
        """The dofs of the tree and of the loops, by name."""
        return {
            dof["name"]: dof for joint in self.robot["joints"] + self.robot["loops"] for dof in joint["dofs"]
        }

    def at_home(self):
        """The scene at `home`, with its controls."""
        data = mujoco.MjData(self.scene)
        mujoco.mj_resetDataKeyframe(self.scene, data, self.scene.key("home").id)
        mujoco.mj_forward(self.scene, data)
        return data


def roles(model):
    """The geoms that are seen and those that collide, by their group."""
    return np.flatnonzero(model.geom_group == 2), np.flatnonzero(model.geom_group == 3)


def names(model, kind, count):
    return [getattr(model, kind)(index).name for index in range(count)]
