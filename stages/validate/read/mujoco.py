"""Reads the robot of a file that MuJoCo compiled, whatever its format."""

from typing import Any

import mujoco
import numpy as np

from linkwright.stages.mujoco.names import body_index, joint_index, site_index
from linkwright.stages.robot.model.poses import inverse
from linkwright.stages.robot.model.robot import Array, Configuration, Dof
from linkwright.stages.robot.motion.kinematics import rest_configuration
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.model.coordinates import (
    body_from_link,
    frame_pose,
    link_pose,
    root_pose,
    set_values,
)
from linkwright.stages.validate.model.mass_properties import MassProperties, express_in_frame
from linkwright.stages.validate.model.poses import placed
from linkwright.stages.validate.same.read_robot import Poses, ReadRobot


class ReadCompiled(ReadRobot):
    """Reads the robot of a file that MuJoCo compiled."""

    def __init__(self, compiled: CompiledModel) -> None:
        self.compiled, self.model = compiled, compiled.model
        self.file, self.robot, self.fixed_dofs = compiled.path.name, compiled.robot, {}
        self._posed: tuple[Configuration, Any] | None = None
        loops = {dof.name: dof.saved for loop in self.robot.loops for dof in loop.dofs}
        self.file_configuration = {**loops, **rest_configuration(self.robot)}

    def data_at(self, q: Configuration) -> Any:
        """Returns MuJoCo's data at the values `q`."""
        if self._posed is None or self._posed[0] is not q:
            data = mujoco.MjData(self.model)
            set_values(self.model, data, self.robot, q, self.compiled.urdf)
            self._posed = q, data
        return self._posed[1]

    def frame_name(self, frame: str) -> str:
        """Returns the name of a frame in the file."""
        return frame

    def poses(self, q: Configuration) -> Poses:
        robot, model, data = self.robot, self.model, self.data_at(q)
        root_from_world = inverse(root_pose(model, data, robot))
        return Poses(
            {link.name: root_from_world @ link_pose(model, data, robot, link.name) for link in robot.links},
            {
                frame.name: root_from_world
                @ frame_pose(model, data, self.frame_name(frame.name), self.compiled.urdf)
                for frame in robot.frames
            },
        )

    def parent(self, link: str) -> str:
        model, names = self.model, {other.name for other in self.robot.links}
        body = body_index(model, link)
        if body < 0:
            site = site_index(model, link)
            holder = int(model.site_bodyid[site]) if site >= 0 else 0
        else:
            holder = int(model.body_parentid[body])
        while holder > 0 and model.body(holder).name not in names:
            holder = int(model.body_parentid[holder])
        name = str(model.body(holder).name)
        return name if name in names else ""

    def axis(self, dof: Dof) -> Array | None:
        return np.array(self.model.jnt_axis[joint_index(self.model, dof.name)])

    def body_mass_properties(self, body: int, link_from_body: Array) -> MassProperties:
        """Returns the mass properties of a body, in the frame of a link."""
        model = self.model
        axes = placed(model.body_iquat[body], model.body_ipos[body])
        tensor = axes[:3, :3] @ np.diag(model.body_inertia[body]) @ axes[:3, :3].T
        return express_in_frame(
            MassProperties(float(model.body_mass[body]), axes[:3, 3], tensor), link_from_body
        )

    def mass_properties(self, link: str) -> MassProperties:
        place = inverse(body_from_link(self.robot, link))
        return self.body_mass_properties(body_index(self.model, link), place)
