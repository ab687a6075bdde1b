"""URDF, SDF and MJCF in PyBullet, told what its users must tell it: inertias of the file, a held base."""

from importlib.metadata import version

import numpy as np
import pybullet
from told import run, tree

STEP = 2e-5
"""[s]"""

FAR = 100.0
"""[m, rad] from where joints are."""


class Bullet:
    def __init__(self, path, kind):
        self.path, self.kind = path, kind
        pybullet.resetSimulation()
        pybullet.setGravity(0, 0, -9.81)
        pybullet.setTimeStep(STEP)
        if kind == "urdf":
            inertia = pybullet.URDF_USE_INERTIA_FROM_FILE
            self.robot = pybullet.loadURDF(str(path), useFixedBase=True, flags=inertia)
        else:
            load = {"sdf": pybullet.loadSDF, "mjcf": pybullet.loadMJCF}[kind]
            (self.robot,) = load(str(path))
        base, _ = pybullet.getBodyInfo(self.robot)
        self.links, self.joints, self.moving = {base.decode(): -1}, {}, []
        for joint in range(pybullet.getNumJoints(self.robot)):
            told = pybullet.getJointInfo(self.robot, joint)
            self.links[told[12].decode()] = joint
            self.joints[told[1].decode()] = joint
            self.moving += [joint] * (told[2] != pybullet.JOINT_FIXED)

    def masses(self):
        """A base that is held has none, so it is loaded once more without that."""
        robot = self.robot
        if self.kind == "urdf":
            robot = pybullet.loadURDF(str(self.path), flags=pybullet.URDF_USE_INERTIA_FROM_FILE)
        made = {name: pybullet.getDynamicsInfo(robot, link)[0] for name, link in self.links.items()}
        if robot != self.robot:
            pybullet.removeBody(robot)
        return made

    def _set(self, values):
        for name, value in values.items():
            pybullet.resetJointState(self.robot, self.joints[name], value, 0.0)

    def poses(self, values):
        self._set(values)
        made = {}
        for name, link in self.links.items():
            made[name] = np.eye(4)
            place, turn = self._base() if link < 0 else self._link(link)
            made[name][:3, :3] = np.array(pybullet.getMatrixFromQuaternion(turn)).reshape(3, 3)
            made[name][:3, 3] = place
        return made

    def _link(self, link):
        return pybullet.getLinkState(self.robot, link, computeForwardKinematics=True)[4:6]

    def _base(self):
        """The frame of the base; PyBullet tells its centre of mass."""
        place, turn = pybullet.getBasePositionAndOrientation(self.robot)
        center, turned = pybullet.getDynamicsInfo(self.robot, -1)[3:5]
        return pybullet.multiplyTransforms(place, turn, *pybullet.invertTransform(center, turned))

    def motion(self, values, seconds, samples):
        for link in range(-1, pybullet.getNumJoints(self.robot)):
            pybullet.setCollisionFilterGroupMask(self.robot, link, 0, 0)
            pybullet.changeDynamics(self.robot, link, linearDamping=0, angularDamping=0)
        for joint in self.moving:
            pybullet.changeDynamics(self.robot, joint, jointLowerLimit=-FAR, jointUpperLimit=FAR)
            pybullet.setJointMotorControl2(self.robot, joint, pybullet.VELOCITY_CONTROL, force=0)
        self._set(values)
        steps, made = round(seconds / STEP), []
        for step in range(1, steps + 1):
            pybullet.stepSimulation()
            if step % (steps // samples) == 0:
                made.append({name: self._value(name) for name in values})
        return made

    def _value(self, name):
        return pybullet.getJointState(self.robot, self.joints[name])[0]


def main(folder, reference, rows):
    pybullet.connect(pybullet.DIRECT)
    for kind in ("urdf", "sdf", "mjcf"):
        if kind in reference["files"]:
            path = folder / reference["files"][kind]
            told = reference["mjcf" if kind == "mjcf" else "urdf"]
            tree(lambda path=path, kind=kind: Bullet(path, kind), kind, told, rows, frames=kind == "urdf")
    return version("pybullet")


if __name__ == "__main__":
    run(main)
