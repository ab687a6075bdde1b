"""Two independent engines over exported files: Pinocchio on the URDF, MuJoCo on the MJCF.

Both answer by names: {link: world pose (4, 4)}, and matrices in the order of given dof names. A ball's
value is a quaternion (w, x, y, z): its frame's motion from parent to child; it has three columns, the
angular velocity of the child relative to the parent in the child's frame. The URDF has a ball as three
turns `<name>_x`, `<name>_y`, `<name>_z`, R = Rx Ry Rz, away from whose singularity values must be.
"""

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

from tests.support.pinocchio import pin

GRAVITY = np.array([0.0, 0.0, -9.81])


class Pinocchio:
    """The URDF, its root held where it is. Mimic joints move on their own, as in a bare tree. The value of a
    free joint is a position and a quaternion (x, y, z, w, i, j, k)."""

    def __init__(self, urdf):
        self.model = pin.buildModelFromXML(urdf.decode())
        self.data = self.model.createData()

    def _turns(self, name):
        """The joints of a dof: itself, or a ball's three turns."""
        return [name] if self.model.existJointName(name) else [f"{name}_{axis}" for axis in "xyz"]

    def _q(self, values):
        q = pin.neutral(self.model)
        for name, value in values.items():
            if isinstance(value, tuple) and len(value) == 7:
                first = self.model.joints[self.model.getJointId(name)].idx_q
                q[first : first + 7] = [*value[:3], *np.roll(value[3:], -1)]
                continue
            numbers = _rotation(value).as_euler("XYZ") if isinstance(value, tuple) else [value]
            for turn, number in zip(self._turns(name), numbers, strict=True):
                joint = self.model.joints[self.model.getJointId(turn)]
                # A continuous joint is kept as (cos, sin).
                q[joint.idx_q : joint.idx_q + joint.nq] = (
                    [number] if joint.nq == 1 else [np.cos(number), np.sin(number)]
                )
        return q

    def _order(self, dofs):
        turns = [turn for name in dofs for turn in self._turns(name)]
        return [self.model.joints[self.model.getJointId(turn)].idx_v for turn in turns]

    def _rates(self, values, dofs):
        """What takes the speeds of `dofs` to those of the joints: (n, n), blocks on the diagonal."""
        order = [(name, len(self._turns(name))) for name in dofs]
        made = np.eye(sum(width for _, width in order))
        at = 0
        for name, width in order:
            if width == 3:
                value = values.get(name, (1.0, 0.0, 0.0, 0.0))
                _, y, z = _rotation(value).as_euler("XYZ")
                # ω in the child's frame = Rzᵀ Ryᵀ x ẋ + Rzᵀ y ẏ + z ż.
                after = Rotation.from_euler("z", z).inv()
                spin = np.column_stack(
                    [
                        after.apply(Rotation.from_euler("y", y).inv().apply([1, 0, 0])),
                        after.apply([0, 1, 0]),
                        [0, 0, 1],
                    ]
                )
                made[at : at + 3, at : at + 3] = np.linalg.inv(spin)
            at += width
        return made

    def poses(self, values):
        pin.framesForwardKinematics(self.model, self.data, self._q(values))
        return {"world": np.eye(4)} | {
            frame.name: self.data.oMf[index].homogeneous
            for index, frame in enumerate(self.model.frames)
            if frame.type == pin.FrameType.BODY
        }

    def mass_matrix(self, values, dofs):
        upper = np.triu(pin.crba(self.model, self.data, self._q(values)))
        full = upper + np.triu(upper, 1).T
        order, rates = self._order(dofs), self._rates(values, dofs)
        return rates.T @ full[np.ix_(order, order)] @ rates

    def gravity(self, values, dofs):
        """∂U/∂q: what holds it still."""
        self.model.gravity.linear = GRAVITY
        torque = pin.computeGeneralizedGravity(self.model, self.data, self._q(values))
        return self._rates(values, dofs).T @ torque[self._order(dofs)]


class Mujoco:
    """The MJCF, from a folder that holds it.

    `start`: values of balls in the pose that the file's bodies stand in (identity unless named). A link
    `world` is the world body.
    """

    def __init__(self, path, start=None):
        self.model = mujoco.MjModel.from_xml_path(str(path))
        self.data = mujoco.MjData(self.model)
        self.start = start or {}

    def _set(self, values):
        mujoco.mj_resetData(self.model, self.data)
        for name, value in values.items():
            at = self.model.joint(name).qposadr[0]
            if isinstance(value, tuple):
                start = _rotation(self.start.get(name, (1.0, 0.0, 0.0, 0.0)))
                self.data.qpos[at : at + 4] = np.roll((start.inv() * _rotation(value)).as_quat(), 1)
            else:
                self.data.qpos[at] = value
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_comPos(self.model, self.data)
        mujoco.mj_makeM(self.model, self.data)
        mujoco.mj_rne(self.model, self.data, 0, self.data.qfrc_bias)

    def _order(self, dofs):
        order = []
        for name in dofs:
            joint = self.model.joint(name)
            width = 3 if joint.type[0] == mujoco.mjtJoint.mjJNT_BALL else 1
            order += range(int(joint.dofadr[0]), int(joint.dofadr[0]) + width)
        return order

    def poses(self, values):
        """Poses of bodies, and of the sites of links without a body, by their places on their bodies:
        MuJoCo's own kinematics takes frames for the same that differ by up to 1e-6."""
        self._set(values)
        model, data, bodies = self.model, self.data, []
        for index in range(model.nbody):
            pose = np.eye(4)
            pose[:3, :3] = data.xmat[index].reshape(3, 3)
            pose[:3, 3] = data.xpos[index]
            bodies.append(pose)
        placed = {}
        for index in range(model.nsite):
            pose = np.eye(4)
            pose[:3, :3] = _rotation(model.site_quat[index]).as_matrix()
            pose[:3, 3] = model.site_pos[index]
            placed[model.site(index).name] = bodies[model.site_bodyid[index]] @ pose
        return placed | {model.body(index).name: pose for index, pose in enumerate(bodies)}

    def mass_matrix(self, values, dofs):
        """Without armature, which is not part of the mechanism."""
        self._set(values)
        full = np.zeros((self.model.nv, self.model.nv))
        for column, unit in zip(full, np.eye(self.model.nv), strict=True):
            mujoco.mj_mulM(self.model, self.data, column, unit)
        order = self._order(dofs)
        return full[np.ix_(order, order)] - np.diag(self.model.dof_armature[order])

    def gravity(self, values, dofs):
        self._set(values)
        return np.array(self.data.qfrc_bias[self._order(dofs)])


def _rotation(value):
    return Rotation.from_quat(np.roll(np.asarray(value, dtype=float), -1))
