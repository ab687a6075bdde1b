"""Reads the keyframes of a model that MuJoCo compiled: the values of its joints, and the values left out."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping

import mujoco
import numpy as np

from linkwright.stages.fetch.mjcf.compiled.extras import qpos_of
from linkwright.stages.fetch.mjcf.compiled.unsupported_fields import Omission
from linkwright.stages.formats.mjcf.model import MjcfNamedPose

_SCALAR = (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE))
_SIZES = {int(mujoco.mjtJoint.mjJNT_FREE): 7, int(mujoco.mjtJoint.mjJNT_BALL): 4}


def keyframes(model: mujoco.MjModel, joints: Mapping[int, int]) -> tuple[MjcfNamedPose, ...]:
    """Returns the keyframes. `joints`: MuJoCo's number of a kept joint → its number in our model."""
    poses = []
    scene_joints = [joint for joint in range(model.njnt) if joint not in joints]
    afloat = [joint for joint in joints if model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_FREE]
    for key in range(model.nkey):
        qpos = model.key_qpos[key]
        values = {number: float(qpos[model.jnt_qposadr[joint]]) for joint, number in joints.items()}
        scalar = tuple(
            (number, values[number]) for joint, number in joints.items() if _is_scalar(model, joint)
        )
        moved_joints = tuple(number for joint, number in joints.items() if _is_moved(model, joint, qpos))
        floating = tuple((joints[joint], qpos_of(model, [joint], qpos)) for joint in afloat)
        scene = qpos_of(model, scene_joints, qpos)
        poses.append(MjcfNamedPose(model.key(key).name, scalar, moved_joints, floating, scene))
    return tuple(poses)


def _is_scalar(model: mujoco.MjModel, joint: int) -> bool:
    return int(model.jnt_type[joint]) in _SCALAR


def _is_moved(model: mujoco.MjModel, joint: int, qpos: np.ndarray) -> bool:
    """Tells whether a ball or free joint is not at qpos0."""
    first, size = int(model.jnt_qposadr[joint]), _SIZES.get(int(model.jnt_type[joint]), 0)
    numbers, usual = qpos[first : first + size].copy(), model.qpos0[first : first + size]
    if size and numbers[-4:] @ usual[-4:] < 0:
        numbers[-4:] *= -1  # the same rotation
    return not np.allclose(numbers, usual, rtol=0, atol=1e-9)


def left_of_keyframes(model: mujoco.MjModel, driven: Collection[int]) -> Iterator[Omission]:
    """Yields the omitted values of keyframes: speeds, times, poses of mocap bodies, and activations. The
    activations of the actuators `driven` are no loss: they follow from the pose."""
    states = [
        number
        for index in range(len(model.actuator_trntype))
        if index not in driven and model.actuator_actadr[index] >= 0
        for number in range(
            int(model.actuator_actadr[index]),
            int(model.actuator_actadr[index] + model.actuator_actnum[index]),
        )
    ]
    mocap = [body for body in range(model.nbody) if model.body_mocapid[body] >= 0]
    # In the order of their numbers among the mocap bodies.
    mocap.sort(key=lambda body: int(model.body_mocapid[body]))
    usual = {"mpos": model.body_pos[mocap].ravel(), "mquat": model.body_quat[mocap].ravel()}
    set_by: dict[str, list[str]] = {}
    for key in range(model.nkey):
        values = {
            "time": model.key_time[key],
            "qvel": model.key_qvel[key],
            "act": model.key_act[key][states],
            **{name: getattr(model, f"key_{name}")[key].ravel() - usual[name] for name in usual},
        }
        for word, value in values.items():
            if np.abs(value).max(initial=0.0) > 1e-9:
                set_by.setdefault(word, []).append(model.key(key).name)
    for word, names in set_by.items():
        yield Omission(f"key {word}", False, tuple(names))
