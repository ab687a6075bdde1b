"""Reads the keyframes of a model that MuJoCo compiled: the values of its joints, and the values left out."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping

import mujoco
import numpy as np

from linkwright.stages.fetch.mjcf.compiled.extras import qpos_of
from linkwright.stages.fetch.mjcf.compiled.unsupported_fields import Omission
from linkwright.stages.formats.mjcf.model import MjcfNamedPose

_SCALAR_TYPES = (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE))
_QPOS_SIZES = {int(mujoco.mjtJoint.mjJNT_FREE): 7, int(mujoco.mjtJoint.mjJNT_BALL): 4}


def keyframes(model: mujoco.MjModel, joints: Mapping[int, int]) -> tuple[MjcfNamedPose, ...]:
    """Returns the keyframes. `joints`: MuJoCo's number of a kept joint → its number in our model."""
    poses = []
    scene_joints = [joint for joint in range(model.njnt) if joint not in joints]
    free_joints = [joint for joint in joints if model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_FREE]
    for key in range(model.nkey):
        qpos = model.key_qpos[key]
        values = {number: float(qpos[model.jnt_qposadr[joint]]) for joint, number in joints.items()}
        scalar_values = tuple(
            (number, values[number]) for joint, number in joints.items() if _is_scalar(model, joint)
        )
        moved_joints = tuple(number for joint, number in joints.items() if _is_moved(model, joint, qpos))
        floating = tuple((joints[joint], qpos_of(model, [joint], qpos)) for joint in free_joints)
        scene = qpos_of(model, scene_joints, qpos)
        poses.append(MjcfNamedPose(model.key(key).name, scalar_values, moved_joints, floating, scene))
    return tuple(poses)


def _is_scalar(model: mujoco.MjModel, joint: int) -> bool:
    return int(model.jnt_type[joint]) in _SCALAR_TYPES


def _is_moved(model: mujoco.MjModel, joint: int, qpos: np.ndarray) -> bool:
    """Tells whether a ball or free joint is not at qpos0."""
    first, size = int(model.jnt_qposadr[joint]), _QPOS_SIZES.get(int(model.jnt_type[joint]), 0)
    values, default_values = qpos[first : first + size].copy(), model.qpos0[first : first + size]
    if size and values[-4:] @ default_values[-4:] < 0:
        values[-4:] *= -1  # the same rotation
    return not np.allclose(values, default_values, rtol=0, atol=1e-9)


def keyframe_omissions(model: mujoco.MjModel, driven: Collection[int]) -> Iterator[Omission]:
    """Yields the omitted values of keyframes: speeds, times, poses of mocap bodies, and activations. The
    activations of the actuators `driven` are no loss: they follow from the pose."""
    activations = [
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
    default_poses = {"mpos": model.body_pos[mocap].ravel(), "mquat": model.body_quat[mocap].ravel()}
    keyframes_by_word: dict[str, list[str]] = {}
    for key in range(model.nkey):
        values = {
            "time": model.key_time[key],
            "qvel": model.key_qvel[key],
            "act": model.key_act[key][activations],
            **{
                name: getattr(model, f"key_{name}")[key].ravel() - default_poses[name]
                for name in default_poses
            },
        }
        for word, value in values.items():
            if np.abs(value).max(initial=0.0) > 1e-9:
                keyframes_by_word.setdefault(word, []).append(model.key(key).name)
    for word, names in keyframes_by_word.items():
        yield Omission(f"key {word}", False, tuple(names))
