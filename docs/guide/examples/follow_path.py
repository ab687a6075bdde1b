"""The arm's tool draws a circle: `python follow_path.py outputs/sample/scene.xml`."""

import sys

import mujoco
import numpy as np

RADIUS, PERIOD = 0.05, 6.0  # of the circle [m, s]

model = mujoco.MjModel.from_xml_path(sys.argv[1])
data, plan = mujoco.MjData(model), mujoco.MjData(model)  # the simulated arm, and where it should be
data.qpos = plan.qpos = model.key("home").qpos
mujoco.mj_forward(model, plan)
start = plan.site("tool").xpos.copy()
driven = np.eye(model.nv)[model.jnt_dofadr[model.actuator_trnid[:, 0]]]  # (servos, dofs)


def jacobian(site):
    rows = np.zeros((3, model.nv))
    mujoco.mj_jacSite(model, plan, rows, None, plan.site(site).id)
    rows[:, model.joint("lift").dofadr] = 0  # the lift stays where it is
    return rows


worst = 0.0
while data.time < PERIOD:
    angle = 2 * np.pi * data.time / PERIOD
    target = start + RADIUS * np.array([0, np.sin(angle), np.cos(angle) - 1])
    # Inverse kinematics: the tool goes to the target, and the loop of the parallel rod stays closed.
    loop = jacobian("rod_upper_pivot_a") - jacobian("rod_upper_pivot_b")
    gap = plan.site("rod_upper_pivot_b").xpos - plan.site("rod_upper_pivot_a").xpos
    rows, error = np.vstack([jacobian("tool"), loop]), np.append(target - plan.site("tool").xpos, gap)
    plan.qpos += rows.T @ np.linalg.solve(rows @ rows.T + 1e-6 * np.eye(6), error)
    mujoco.mj_forward(model, plan)
    # The servos, and the forces in the loop, hold the weight; each servo gets as much more as it would sag.
    holding = np.linalg.lstsq(np.vstack([driven, loop]).T, plan.qfrc_bias)[0][: model.nu]
    data.ctrl = plan.actuator_length + holding / model.actuator_gainprm[:, 0]
    mujoco.mj_step(model, data)
    worst = max(worst, np.linalg.norm(data.site("tool").xpos - target))
print(f"at most {1000 * worst:.1f} mm from the path")
