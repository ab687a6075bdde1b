"""The scene in MuJoCo Warp on the CPU."""

from importlib.metadata import version

import mujoco
import mujoco_warp as mjw
from told import run, scene


class Warp:
    def __init__(self, model):
        self.plain = model
        self.model = mjw.put_model(model)

    def _at(self, qpos, controls=0.0):
        data = mujoco.MjData(self.plain)
        data.qpos[:], data.ctrl[:] = qpos, controls
        mujoco.mj_forward(self.plain, data)
        return mjw.put_data(self.plain, data, nconmax=CONTACTS, njmax=ROWS)

    def masses(self):
        return self.model.body_mass.numpy().reshape(-1)[: self.plain.nbody]

    def poses(self, qpos):
        data = self._at(qpos)
        mjw.kinematics(self.model, data)
        return data.xpos.numpy()[0], data.xmat.numpy()[0].reshape(-1, 3, 3)

    def motion(self, qpos, controls, steps):
        """The values after each step."""
        data = self._at(qpos, controls)
        for _ in range(steps):
            mjw.step(self.model, data)
            yield data.qpos.numpy()[0].copy()


CONTACTS, ROWS = 200, 600
"""Contacts and rows of constraints that there is room for."""


def main(folder, reference, rows):
    read = lambda: mujoco.MjModel.from_xml_path(str(folder / reference["files"]["scene"]))  # noqa: E731
    scene(Warp, read, reference, rows)
    return f"{version('mujoco-warp')} with mujoco {version('mujoco')}"


if __name__ == "__main__":
    run(main)
