"""Names and numbers of what is in a compiled model."""

from typing import Any

import mujoco

OBJ = mujoco.mjtObj


def name_of(model: Any, kind: Any, index: int) -> str:
    """The name of the thing of this kind (`mjtObj`) and number; empty where it has none."""
    return mujoco.mj_id2name(model, int(kind), int(index)) or ""


def index_of(model: Any, kind: Any, name: str) -> int:
    """The number of the thing of this kind (`mjtObj`) and name; -1 where there is none."""
    return int(mujoco.mj_name2id(model, int(kind), name))


def names_of(model: Any, kind: Any, count: int) -> list[str]:
    """The names of the first `count` things of this kind, empty where one has none."""
    return [name_of(model, kind, index) for index in range(count)]


def joint_index(model: Any, name: str) -> int:
    """The number of a joint; -1 where there is none of this name."""
    return index_of(model, OBJ.mjOBJ_JOINT, name)


def body_index(model: Any, name: str) -> int:
    """The number of a body; -1 where there is none of this name."""
    return index_of(model, OBJ.mjOBJ_BODY, name)


def site_index(model: Any, name: str) -> int:
    """The number of a site; -1 where there is none of this name."""
    return index_of(model, OBJ.mjOBJ_SITE, name)
