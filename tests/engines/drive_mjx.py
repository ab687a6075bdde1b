"""The scene in MJX on the CPU, in single precision as it is used for learning."""

from importlib.metadata import version

import jax
import mujoco
import numpy as np
from mujoco import mjx
from told import run, scene


class Mjx:
    def __init__(self, model):
        self.model = mjx.put_model(model)
        self.step = jax.jit(mjx.step)
        self.kinematics = jax.jit(mjx.kinematics)

    def masses(self):
        return np.asarray(self.model.body_mass)

    def poses(self, qpos):
        data = self.kinematics(self.model, mjx.make_data(self.model).replace(qpos=qpos))
        return np.asarray(data.xpos), np.asarray(data.xmat).reshape(-1, 3, 3)

    def motion(self, qpos, controls, steps):
        """The values after each step."""
        data = mjx.make_data(self.model).replace(qpos=qpos, ctrl=controls)
        for _ in range(steps):
            data = self.step(self.model, data)
            yield np.asarray(data.qpos)


def main(folder, reference, rows):
    read = lambda: mujoco.MjModel.from_xml_path(str(folder / reference["files"]["scene"]))  # noqa: E731
    scene(Mjx, read, reference, rows)
    return f"{version('mujoco-mjx')} with jax {version('jax')}"


if __name__ == "__main__":
    run(main)
