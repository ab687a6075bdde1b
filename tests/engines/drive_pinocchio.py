"""The URDF in Pinocchio, which has no integrator: the motion is by its forward dynamics, with RK4."""

import numpy as np
import pinocchio as pin
from told import run, tree

STEP = 2e-4
"""[s]"""


class Pinocchio:
    def __init__(self, path):
        self.model = pin.buildModelFromUrdf(str(path))
        self.data = self.model.createData()

    def _bodies(self):
        frames = enumerate(self.model.frames)
        return [(index, frame) for index, frame in frames if frame.type == pin.FrameType.BODY]

    def _q(self, values):
        q = pin.neutral(self.model)
        for name, value in values.items():
            joint = self.model.joints[self.model.getJointId(name)]
            # A continuous joint is kept as (cos, sin).
            kept = [value] if joint.nq == 1 else [np.cos(value), np.sin(value)]
            q[joint.idx_q : joint.idx_q + joint.nq] = kept
        return q

    def _values(self, q):
        made = {}
        for name, joint in zip(list(self.model.names)[1:], list(self.model.joints)[1:], strict=True):
            numbers = q[joint.idx_q : joint.idx_q + joint.nq]
            made[name] = numbers[0] if joint.nq == 1 else np.arctan2(numbers[1], numbers[0])
        return made

    def masses(self):
        """A joint has the inertia of all links that are fixed to each other below it, each of which but the
        first has its own in its frame; the root has its own too."""
        made = {frame.name: frame.inertia.mass for _, frame in self._bodies()}
        for joint in range(1, self.model.njoints):
            below = [frame.name for _, frame in self._bodies() if frame.parentJoint == joint]
            made[below[0]] = self.model.inertias[joint].mass - sum(made[name] for name in below[1:])
        return made

    def poses(self, values):
        pin.framesForwardKinematics(self.model, self.data, self._q(values))
        return {frame.name: self.data.oMf[index].homogeneous for index, frame in self._bodies()}

    def _push(self, q, v):
        return pin.aba(self.model, self.data, q, v, -self.model.damping * v)

    def motion(self, values, seconds, samples):
        q, v, h = self._q(values), np.zeros(self.model.nv), STEP
        move, steps, made = pin.integrate, round(seconds / STEP), []
        for step in range(1, steps + 1):
            k1 = self._push(q, v)
            k2 = self._push(move(self.model, q, h / 2 * v), v + h / 2 * k1)
            k3 = self._push(move(self.model, q, h / 2 * (v + h / 2 * k1)), v + h / 2 * k2)
            k4 = self._push(move(self.model, q, h * (v + h / 2 * k2)), v + h * k3)
            q = move(self.model, q, h * (v + h / 6 * (k1 + k2 + k3)))
            v = v + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
            if step % (steps // samples) == 0:
                made.append(self._values(q))
        return made


def main(folder, reference, rows):
    tree(lambda: Pinocchio(folder / reference["files"]["urdf"]), "urdf", reference["urdf"], rows)
    return pin.__version__


if __name__ == "__main__":
    run(main)
