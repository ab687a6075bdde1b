"""What sensors on frames and links of the MJCF read is what Pinocchio works out from the URDF."""

import mujoco
import numpy as np

from tests.support.building import sample_robot
from tests.support.exports import compiled, exported
from tests.support.pinocchio import pin

GRAVITY = np.array([0.0, 0.0, -9.81])


def test_imus_and_frames_of_the_sample_agree_with_pinocchio():
    robot = sample_robot()
    places = [*(link.name for link in robot.links), *(frame.name for frame in robot.frames)]
    imu = {"type": "imu", "measure": ["gyro", "velocimeter", "accelerometer", "quat"]}
    frame = {"type": "frame", "measure": ["pos", "linvel", "angvel"]}
    sensors = {f"i_{name}": {**imu, "frame": name} for name in places}
    sensors |= {f"f_{name}": {**frame, "frame": name} for name in places}
    outcome = exported(robot, sensors=sensors, scene={"pose": {"xyz": [0, 0, 0]}})
    model = compiled(outcome)
    other = pin.buildModelFromXML(outcome.files["robot.urdf"].decode())
    state = other.createData()
    data = mujoco.MjData(model)
    rng = np.random.default_rng(4)
    for _ in range(3):
        data.qpos[:] = rng.uniform(-0.5, 0.5, model.nq)
        data.qvel[:] = rng.uniform(-2, 2, model.nv)
        mujoco.mj_forward(model, data)
        q, v, a = pin.neutral(other), np.zeros(other.nv), np.zeros(other.nv)
        for index in range(model.njnt):
            joint = other.joints[other.getJointId(model.joint(index).name)]
            value = data.qpos[index]
            q[joint.idx_q : joint.idx_q + joint.nq] = (
                [value] if joint.nq == 1 else [np.cos(value), np.sin(value)]
            )
            v[joint.idx_v], a[joint.idx_v] = data.qvel[index], data.qacc[index]
        pin.forwardKinematics(other, state, q, v, a)
        pin.updateFramePlacements(other, state)
        local, world = pin.ReferenceFrame.LOCAL, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        for name in places:
            at = other.getFrameId(name)
            pose, own = state.oMf[at], pin.getFrameVelocity(other, state, at, local)
            acceleration = pin.getFrameClassicalAcceleration(other, state, at, local).linear
            seen = pin.getFrameVelocity(other, state, at, world)
            w, x, y, z = data.sensor(f"i_{name}_quat").data
            same(pin.Quaternion(w, x, y, z).matrix(), pose.rotation)
            same(data.sensor(f"i_{name}_gyro").data, own.angular)
            same(data.sensor(f"i_{name}_velocimeter").data, own.linear)
            same(data.sensor(f"i_{name}_accelerometer").data, acceleration - pose.rotation.T @ GRAVITY)
            same(data.sensor(f"f_{name}_pos").data, pose.translation)
            same(data.sensor(f"f_{name}_linvel").data, seen.linear)
            same(data.sensor(f"f_{name}_angvel").data, seen.angular)


def same(actual, expected):
    """To 1e-9 of what is large: the qacc of both may be hundreds."""
    assert np.abs(actual - expected).max() <= 1e-9 * max(1.0, np.abs(expected).max())
