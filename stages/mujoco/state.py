"""Makes the state of a model at a keyframe."""

from typing import Any

import mujoco


def keyframe_index(model: Any, name: str) -> int:
    """Returns the index of the keyframe of this name; -1 without such a keyframe."""
    return int(mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_KEY, name))


def at_keyframe(model: Any, name: str = "home") -> Any:
    """Returns the data at the keyframe of this name, with its controls; at qpos0 without such a keyframe."""
    return at_keyframe_index(model, keyframe_index(model, name))


def at_keyframe_index(model: Any, key: int) -> Any:
    """Returns the data at the keyframe of this index, with its controls; at qpos0 for -1."""
    data = mujoco.MjData(model)
    if key >= 0:
        mujoco.mj_resetDataKeyframe(model, data, key)
    return data
