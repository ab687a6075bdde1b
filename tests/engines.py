"""Two independent engines over exported files: Pinocchio on the URDF, MuJoCo on the MJCF.

Both answer by names: {link: world pose (4, 4)}, and matrices in the order of given joint names.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path

import mujoco
import numpy as np
import pinocchio as pin

GRAVITY = np.array([0.0, 0.0, -9.81])


class Pinocchio:
    """The URDF, its root held where it is. Mimic joints move on their own, as in a bare tree."""

    def __init__(self, urdf: bytes) -> None:
        self.model = pin.buildModelFromXML(urdf.decode())
        self.data = self.model.createData()

    def _q(self, values: Mapping[str, float]) -> np.ndarray:
        q = pin.neutral(self.model)
        for name, value in values.items():
            joint = self.model.joints[self.model.getJointId(name)]
            # A continuous joint is kept as (cos, sin).
            q[joint.idx_q : joint.idx_q + joint.nq] = (
                [value] if joint.nq == 1 else [np.cos(value), np.sin(value)]
            )
        return q

    def _order(self, joints: Sequence[str]) -> list[int]:
        return [self.model.joints[self.model.getJointId(name)].idx_v for name in joints]

    def poses(self, values: Mapping[str, float]) -> dict[str, np.ndarray]:
        pin.framesForwardKinematics(self.model, self.data, self._q(values))
        return {
            frame.name: self.data.oMf[index].homogeneous
            for index, frame in enumerate(self.model.frames)
            if frame.type == pin.FrameType.BODY
        }

    def mass_matrix(self, values: Mapping[str, float], joints: Sequence[str]) -> np.ndarray:
        upper = np.triu(pin.crba(self.model, self.data, self._q(values)))
        full = upper + np.triu(upper, 1).T
        order = self._order(joints)
        return full[np.ix_(order, order)]

    def gravity(self, values: Mapping[str, float], joints: Sequence[str]) -> np.ndarray:
        """∂U/∂q: what holds it still."""
        self.model.gravity.linear = GRAVITY
        return pin.computeGeneralizedGravity(self.model, self.data, self._q(values))[self._order(joints)]


class Mujoco:
    """The MJCF, from a folder that holds it."""

    def __init__(self, path: Path) -> None:
        self.model = mujoco.MjModel.from_xml_path(str(path))
        self.data = mujoco.MjData(self.model)

    def _set(self, values: Mapping[str, float]) -> None:
        mujoco.mj_resetData(self.model, self.data)
        for name, value in values.items():
            self.data.qpos[self.model.joint(name).qposadr[0]] = value
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_comPos(self.model, self.data)
        mujoco.mj_crb(self.model, self.data)
        mujoco.mj_rne(self.model, self.data, 0, self.data.qfrc_bias)

    def _order(self, joints: Sequence[str]) -> list[int]:
        return [int(self.model.joint(name).dofadr[0]) for name in joints]

    def poses(self, values: Mapping[str, float]) -> dict[str, np.ndarray]:
        self._set(values)
        found = {}
        for index in range(1, self.model.nbody):
            pose = np.eye(4)
            pose[:3, :3] = self.data.xmat[index].reshape(3, 3)
            pose[:3, 3] = self.data.xpos[index]
            found[self.model.body(index).name] = pose
        return found

    def mass_matrix(self, values: Mapping[str, float], joints: Sequence[str]) -> np.ndarray:
        """Without armature, which is not part of the mechanism."""
        self._set(values)
        full = np.zeros((self.model.nv, self.model.nv))
        for column, unit in zip(full, np.eye(self.model.nv), strict=True):
            mujoco.mj_mulM(self.model, self.data, column, unit)
        order = self._order(joints)
        return full[np.ix_(order, order)] - np.diag(self.model.dof_armature[order])

    def gravity(self, values: Mapping[str, float], joints: Sequence[str]) -> np.ndarray:
        self._set(values)
        return np.array(self.data.qfrc_bias[self._order(joints)])
