"""Looks up names and indices of the elements of a compiled model."""

from typing import Any

import mujoco

OBJ = mujoco.mjtObj
"""MuJoCo's kinds of elements."""

_COUNTS = {
    OBJ.mjOBJ_BODY: "nbody",
    OBJ.mjOBJ_JOINT: "njnt",
    OBJ.mjOBJ_GEOM: "ngeom",
    OBJ.mjOBJ_EQUALITY: "neq",
}
"""Kind of element → the field of MjModel with the number of its elements."""


def name_of(model: Any, kind: Any, index: int) -> str:
    """Returns the name of the element of this kind (`mjtObj`) and index; "" without a name."""
    return mujoco.mj_id2name(model, int(kind), int(index)) or ""


def index_of(model: Any, kind: Any, name: str) -> int:
    """Returns the index of the element of this kind (`mjtObj`) and name; -1 without such an element."""
    return int(mujoco.mj_name2id(model, int(kind), name))


def names_of(model: Any, kind: Any, count: int) -> list[str]:
    """Returns the names of the first `count` elements of this kind (`mjtObj`), "" for those without a
    name."""
    return [name_of(model, kind, index) for index in range(count)]


def joint_index(model: Any, name: str) -> int:
    """Returns the index of the joint of this name; -1 without such a joint."""
    return index_of(model, OBJ.mjOBJ_JOINT, name)


def body_index(model: Any, name: str) -> int:
    """Returns the index of the body of this name; -1 without such a body."""
    return index_of(model, OBJ.mjOBJ_BODY, name)


def site_index(model: Any, name: str) -> int:
    """Returns the index of the site of this name; -1 without such a site."""
    return index_of(model, OBJ.mjOBJ_SITE, name)


def actuator_count(model: Any) -> int:
    """Returns the number of actuators. From MuJoCo 3.14 on an actuator may have several controls, and
    `model.nu` is the number of controls."""
    return int(getattr(model, "nactuator", model.nu))


def controls_of(model: Any, actuator: int) -> range:
    """Returns the indices of an actuator's controls in `ctrl` and in the arrays of their ranges. Before
    MuJoCo 3.14 an actuator has a single control, which has the index of the actuator."""
    if not hasattr(model, "actuator_ctrladr"):
        return range(actuator, actuator + 1)
    first = int(model.actuator_ctrladr[actuator])
    return range(first, first + int(model.actuator_ctrlnum[actuator]))


def count_of(model: Any, kind: Any) -> int:
    """Returns the number of elements of this kind (`mjtObj`): bodies, joints, geoms, equalities or
    actuators."""
    if kind == OBJ.mjOBJ_ACTUATOR:
        return actuator_count(model)
    return int(getattr(model, _COUNTS[OBJ(int(kind))]))
