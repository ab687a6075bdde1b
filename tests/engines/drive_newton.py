"""MJCF, URDF and USD in Newton on the CPU, moved by its MuJoCo solver, with its MuJoCo: what Newton makes of
a file is the same for its MuJoCo Warp, which a driver of its own has."""

from importlib.metadata import version

import newton
import numpy as np
import warp as wp
from told import MOTION, apart, run, tree

STEP = 2e-4
"""[s] of a bare tree, with RK4."""

FAR = 100.0
"""[m, rad] from where joints are."""


def read(path, kind, floating, **more):
    builder = newton.ModelBuilder()
    newton.solvers.SolverMuJoCo.register_custom_attributes(builder)
    add = {"mjcf": builder.add_mjcf, "urdf": builder.add_urdf, "usda": builder.add_usd}[kind]
    add(str(path), floating=floating, **more)
    return builder


class Newton:
    def __init__(self, path, kind, zero):
        """`zero`: where each joint of the file starts: of an MJCF, values in Newton count from its `ref`."""
        self.zero = zero
        more = {"skip_equality_constraints": True} if kind == "mjcf" else {}
        self.builder = read(path, kind, floating=False, **more)
        self.model = self.builder.finalize(device="cpu")
        self.joints = {
            label.rsplit("/", 1)[-1]: start
            for label, start, size in zip(
                self.builder.joint_label, self.builder.joint_q_start, self.builder.joint_dof_dim, strict=True
            )
            if sum(size) == 1
        }
        self.links = [label.rsplit("/", 1)[-1] for label in self.builder.body_label]

    def masses(self):
        return dict(zip(self.links, self.model.body_mass.numpy().astype(float), strict=True))

    def _q(self, values):
        q = self.model.joint_q.numpy()
        for name, value in values.items():
            q[self.joints[name]] = value - self.zero.get(name, 0.0)
        return wp.array(q, dtype=float, device="cpu")

    def poses(self, values):
        state = self.model.state()
        newton.eval_fk(self.model, self._q(values), self.model.joint_qd, state)
        return dict(zip(self.links, map(matrix, state.body_q.numpy().astype(float)), strict=True))

    def motion(self, values, seconds, samples):
        builder = self.builder
        for which in ("armature", "friction", "target_ke", "target_kd"):
            setattr(builder, f"joint_{which}", [0.0] * builder.joint_dof_count)
        builder.joint_limit_lower = [-FAR] * builder.joint_dof_count
        builder.joint_limit_upper = [FAR] * builder.joint_dof_count
        model = builder.finalize(device="cpu")
        solver = newton.solvers.SolverMuJoCo(
            model, use_mujoco_cpu=True, disable_contacts=True, integrator="rk4"
        )
        solver.mj_data.eq_active[:] = 0
        made = []
        for q in moved(model, solver, self._q(values), None, STEP, round(seconds / STEP)):
            made.append({name: q[at] + self.zero.get(name, 0.0) for name, at in self.joints.items()})
        every = len(made) // samples
        return made[every - 1 :: every]


def matrix(numbers):
    x, y, z, w = numbers[3:]
    pose = np.eye(4)
    pose[:3, 3] = numbers[:3]
    pose[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return pose


def moved(model, solver, q, controls, step, steps):
    """Values of joints after each step."""
    now, after, control = model.state(), model.state(), model.control()
    now.joint_q.assign(q)
    newton.eval_fk(model, now.joint_q, now.joint_qd, now)
    if controls is not None:
        control.mujoco.ctrl.assign(np.array(controls, np.float32))
    for _ in range(steps):
        now.clear_forces()
        solver.step(now, after, control, None, step)
        now, after = after, now
        yield now.joint_q.numpy().astype(float).copy()


def scene(folder, reference, rows):
    """From `home` under its controls, in the scene: actuators, contacts, limits and loops."""
    tree = reference["mjcf"]
    # Else loops are joints, with values of their own.
    loops = {"ctrl_direct": True, "convert_mjc_equality_constraints": False}
    for start, wanted in reference["scene"].items():
        free = len(wanted["start"]) - len(tree["zero"])
        zero = np.array([0.0] * free + tree["zero"])

        def go(wanted=wanted, free=free, zero=zero):
            builder = read(folder / reference["files"]["scene"], "mjcf", None, **loops)
            model = builder.finalize(device="cpu")
            solver = newton.solvers.SolverMuJoCo(model, use_mujoco_cpu=True)
            q = wp.array(turned(wanted["start"] - zero, free, (4, 5, 6, 3)), dtype=float, device="cpu")
            steps = len(wanted["hundred"]) - 1
            # Controls are MuJoCo's, and do not count from `ref`.
            run = moved(model, solver, q, wanted["controls"], wanted["timestep"], steps)
            return [turned(q, free, (6, 3, 4, 5)) + zero for q in run]

        found = rows.trying("scene", f"{start}: 100 steps", go)
        if found is not None:
            rows.measured("scene", f"{start}: 100 steps", apart(found, wanted["hundred"][1:]), MOTION)


def turned(q, free, order):
    """A free base's quaternion in another order."""
    return np.concatenate([q[:3], q[list(order)], q[7:]]) if free else q


def main(folder, reference, rows):
    wp.config.quiet = True
    for kind, told in (("mjcf", "mjcf"), ("urdf", "urdf"), ("usda", "urdf")):
        if kind in reference["files"]:
            path, expected = folder / reference["files"][kind], reference[told]
            zero = dict(zip(expected["joints"], expected["zero"], strict=True))
            tree(lambda p=path, k=kind, z=zero: Newton(p, k, z), kind, expected, rows, kind != "usda")
    scene(folder, reference, rows)
    return version("newton")


if __name__ == "__main__":
    run(main)
