"""A compiled model made to run in another way than its file says, and states to run it from."""

import hashlib
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import mujoco
import numpy as np

from stages.robot.model import Array

DEEP = 5e-4
"""Contacts at the start may be so deep [m], the skin of soft contact: deeper ones push the robot apart."""


@contextmanager
def with_options(model: Any, **options: Any) -> Iterator[None]:
    """The model with these members of its `option`, for as long as the context lasts."""
    before = {name: getattr(model.opt, name) for name in options}
    try:
        for name, value in options.items():
            setattr(model.opt, name, value)
        yield
    finally:
        for name, value in before.items():
            setattr(model.opt, name, value)


def flags(*names: str) -> int:
    """The bits of these flags that turn something off, as far as the installed MuJoCo has them."""
    bits = (getattr(mujoco.mjtDisableBit, f"mjDSBL_{name}", 0) for name in names)
    return sum(int(bit) for bit in bits)


PASSIVE = ("PASSIVE", "SPRING", "DAMPER")
"""Springs, dampers, fluids and the compensation of gravity: one flag in older versions of MuJoCo, two in
newer ones."""


def at_keyframe(model: Any, name: str = "home") -> Any:
    """The data at a keyframe, with its controls; at qpos0 where there is none of this name."""
    data = mujoco.MjData(model)
    key = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_KEY, name)
    if key >= 0:
        mujoco.mj_resetDataKeyframe(model, data, key)
    return data


def touching(model: Any, data: Any) -> list[tuple[int, int, float]]:
    """(body, other body, depth [m]) of the bodies in contact, the deepest first, each pair with its deepest
    contact; the world, 0, is always the other."""
    found: dict[tuple[int, int], float] = {}
    for contact in data.contact[: data.ncon]:
        body, other = sorted((int(model.geom_bodyid[geom]) for geom in contact.geom), reverse=True)
        found[body, other] = max(found.get((body, other), 0.0), -float(contact.dist))
    return sorted(((*pair, depth) for pair, depth in found.items()), key=lambda one: -one[2])


def drawn(name: str, count: int) -> Array:
    """`count` numbers spread evenly over -1 to 1, always the same ones for a name (PCG64): the order of what
    has names does not matter."""
    seed = int.from_bytes(hashlib.sha256(name.encode()).digest()[:16], "big")
    return 2.0 * np.random.Generator(np.random.PCG64(seed)).random(count) - 1.0
