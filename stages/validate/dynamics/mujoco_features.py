"""Tests what the installed MuJoCo does, since versions differ."""

import functools
import itertools
import math
from typing import Any

import mujoco
import numpy as np

from linkwright.stages.formats.xml import parse
from linkwright.stages.mujoco.compile import compiled_text
from linkwright.stages.mujoco.names import index_of
from linkwright.stages.robot.model.robot import Array
from linkwright.stages.validate.model.poses import rotation

_PROBES = [
    (np.array(moments), np.array(quat))
    for moments in ((1.0, 0.9, 0.6), (1.0, 0.99, 0.1), (1.0, 0.55, 0.5))
    for quat in itertools.product((0.3, 1.0), (-0.7, 0.2), (0.4, 0.9), (-0.1, 0.5))
]
"""Tensors on which MuJoCo's error is measured: principal moments, and the quaternion (not normalised) of
their axes."""

_PROBE_MARGIN = 16
"""Factor on the largest error of the probes. The worst of thousands of tensors had four times the error of
these; the rest is a margin."""

_ROUNDING = 1e-12
"""Relative error of a tensor that rounding alone may cause."""

_SOLID = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
_MIMIC_URDF = f"""<robot name="r"><link name="a"/><link name="b">{_SOLID}</link><link name="c">{_SOLID}</link>
<joint name="p" type="continuous"><parent link="a"/><child link="b"/></joint>
<joint name="q" type="continuous"><parent link="a"/><child link="c"/><mimic joint="p"/></joint></robot>"""


def principal_axes_error(size: float) -> float:
    """Returns the relative error that MuJoCo's search for principal axes may leave in an inertia tensor; 0 if
    the error is only rounding. `size`: the largest entry of the tensor [kg m²].

    Up to and including 3.13, MuJoCo stops the search at 1e-6 rad and at 1e-12 kg m². It searches only in a
    URDF, which gives the tensor; the MJCFs that are written here give the axes.
    """
    return _largest_error(math.floor(math.log10(size)))


@functools.cache
def _largest_error(exponent: int) -> float:
    worst = max(_diagonalization_error(moments * 10.0**exponent, quat) for moments, quat in _PROBES)
    return _PROBE_MARGIN * worst if worst > _ROUNDING else 0.0


def _diagonalization_error(moments: Array, quat: Array) -> float:
    """Returns the relative error of a tensor that MuJoCo splits into principal moments and axes."""
    axes_rotation = rotation(quat / np.linalg.norm(quat))
    tensor = axes_rotation @ np.diag(moments) @ axes_rotation.T
    actual_moments, vectors, axes = np.empty(3), np.empty(9), np.empty(4)
    mujoco.mju_eig3(actual_moments, vectors, axes, tensor.ravel())
    actual_rotation = rotation(axes)
    actual_tensor = actual_rotation @ np.diag(actual_moments) @ actual_rotation.T
    return float(np.abs(actual_tensor - tensor).max() / np.abs(tensor).max())


@functools.cache
def reads_mimic() -> bool:
    """Tells whether MuJoCo turns a URDF's <mimic> into an equality, as it does since 3.13."""
    return bool(compiled_text(_MIMIC_URDF.encode(), {}).neq)


def mimics(model: Any, urdf: bytes) -> dict[tuple[int, int], Array]:
    """Maps (follower, driver) of each <mimic> to the coefficients of the equality that MuJoCo makes, or would
    make, of it."""
    coefficients: dict[tuple[int, int], Array] = {}
    for mimic in parse(urdf).iterfind("joint/mimic"):
        follower = index_of(model, mujoco.mjtObj.mjOBJ_JOINT, mimic.getparent().get("name"))
        driver = index_of(model, mujoco.mjtObj.mjOBJ_JOINT, mimic.get("joint"))
        numbers = float(mimic.get("offset", 0)), float(mimic.get("multiplier", 1))
        coefficients[follower, driver] = np.array([*numbers, 0.0, 0.0, 0.0])
    return coefficients
