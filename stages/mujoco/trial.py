"""Simulates a model in a trial run, which shows whether it stays finite and its loops stay closed."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt

from linkwright.stages.mujoco.state import at_keyframe
from linkwright.stages.mujoco.warnings import collected_warnings
from linkwright.stages.robot.model.robot import Array

TRIAL_SECONDS = 2.0
"""Length of a trial run [s]."""

MAX_OPENING = 1e-3
"""Largest error [m, rad] of the equalities that close loops."""

MIN_IMPEDANCE = 0.999
"""Smallest impedance of an equality that must hold. Exported equalities have more; those of an MJCF source
may be soft."""

MAX_WORK = 1e7
"""Largest product of the number of steps and the square of the number of speeds. It shortens the trial runs
of robots with many speeds: with 100 speeds there are at most 1000 steps."""


@dataclass(frozen=True, slots=True)
class Trial:
    """The result of a trial run."""

    failed: str
    """The failure in words; "" without a failure."""

    time: float
    """Time [s] of the failure, or of the end."""

    joints: tuple[str, ...] = ()
    """The names of the joints where the failure began, the worst first."""

    opening: float = 0.0
    """The largest opening of a loop [m, rad]."""

    loop: str = ""
    """The name of the equality that opened most."""

    @property
    def joint(self) -> str:
        """The name of the joint where the failure began; "" if it is unknown."""
        return self.joints[0] if self.joints else ""


def trial_run(
    model: Any, seconds: float = TRIAL_SECONDS, opening: float = MAX_OPENING, start: Array | None = None
) -> Trial:
    """Simulates a model at its own time step for `seconds` [s] or until it fails, and returns the result.

    It starts from the keyframe `home` (else qpos0), with the controls there, and from the positions `start`
    (nq,) if given. The trial fails if MuJoCo warns, or if the error of a loop is above `opening` [m, rad] and
    above twice the largest error at the start.
    """
    data = at_keyframe(model)
    if start is not None:
        data.qpos[:] = start
    mujoco.mj_forward(model, data)
    closing = _closing(model)
    allowed = max(opening, 2.0 * _opening(data, closing)[0])
    steps = round(seconds / model.opt.timestep)
    steps = max(1, min(steps, int(MAX_WORK / max(1, model.nv) ** 2)))
    worst, loop = 0.0, -1
    with collected_warnings():
        for step in range(steps):
            mujoco.mj_step(model, data)
            time = (step + 1) * model.opt.timestep
            if failed := failure(model, data):
                return Trial(failed[0], time, failed[1], worst, _equality_name(model, loop))
            current, equality = _opening(data, closing)
            if current > worst:
                worst, loop = current, equality
            if worst > allowed:
                text = f"{_equality_name(model, loop)} opened by {worst:.2g}"
                return Trial(text, time, _loop_joints(model, loop), worst, _equality_name(model, loop))
    return Trial("", steps * model.opt.timestep, (), worst, _equality_name(model, loop))


def failure(model: Any, data: Any) -> tuple[str, tuple[str, ...]] | None:
    """Returns the failure since the data was reset, in words, and the names of the joints where it began;
    None without a failure."""
    warnings = [index for index, number in enumerate(data.warning.number.tolist()) if number]
    if warnings or not np.isfinite(data.qpos).all():
        return _failure_text(warnings), _joints(model, data, warnings)
    return None


def _closing(model: Any) -> npt.NDArray[np.bool_]:
    """Returns a mask (neq,) of the connects and welds that must hold; empty if there are none."""
    closes = np.isin(model.eq_type, (mujoco.mjtEq.mjEQ_CONNECT, mujoco.mjtEq.mjEQ_WELD))
    closing: npt.NDArray[np.bool_] = closes & (model.eq_solimp[:, 1] >= MIN_IMPEDANCE)
    return closing if closing.any() else closing[:0]


def _opening(data: Any, closing: npt.NDArray[np.bool_]) -> tuple[float, int]:
    """Returns the largest error [m, rad] of the equalities in the mask `closing`, and the index of that
    equality; (0, -1) without such equalities."""
    if not len(closing) or not data.ne:
        return 0.0, -1
    # The rows of equalities are the first rows of constraints.
    equalities = data.efc_id[: data.ne]
    is_closing = closing[equalities]
    if not is_closing.any():
        return 0.0, -1
    squares = np.bincount(equalities[is_closing], data.efc_pos[: data.ne][is_closing] ** 2)
    worst = int(squares.argmax())
    return float(np.sqrt(squares[worst])), worst


_FAILURES = {
    "mjWARN_BADQPOS": "its positions became infinite",
    "mjWARN_BADQVEL": "its speeds became infinite",
    "mjWARN_BADQACC": "its accelerations became infinite",
    "mjWARN_CONTACTFULL": "it has too many contacts",
    "mjWARN_CNSTRFULL": "it has too many constraints",
    "mjWARN_INERTIA": "its mass matrix is singular",
    "mjWARN_BADCTRL": "a control is not finite",
}
"""Warning of MuJoCo → the failure in words."""


def _failure_text(warnings: Sequence[int]) -> str:
    names = [mujoco.mjtWarning(index).name for index in warnings]
    return ", ".join(_FAILURES.get(name, name) for name in names) or "its positions became infinite"


def _joints(model: Any, data: Any, warnings: Sequence[int]) -> tuple[str, ...]:
    """Returns the name of the joint whose position, speed or acceleration is bad, by the first such warning;
    () without one."""
    bad = ("mjWARN_BADQPOS", "mjWARN_BADQVEL", "mjWARN_BADQACC")
    for index in warnings:
        if mujoco.mjtWarning(index).name not in bad:
            continue
        # MuJoCo gives the index of a position, or that of a speed for the other warnings.
        number = int(data.warning[index].lastinfo)
        if mujoco.mjtWarning(index).name == "mjWARN_BADQPOS":
            number = int(model.jnt_dofadr[np.searchsorted(model.jnt_qposadr, number, side="right") - 1])
        if 0 <= number < model.nv:
            return (model.joint(int(model.dof_jntid[number])).name,)
    return ()


def _loop_joints(model: Any, equality: int) -> tuple[str, ...]:
    """Returns the names of the joints on the loop that an equality closes: those above only one of its
    bodies, the nearest first."""
    ends = (int(model.eq_obj1id[equality]), int(model.eq_obj2id[equality]))
    if model.eq_objtype[equality] == mujoco.mjtObj.mjOBJ_SITE:
        ends = (int(model.site_bodyid[ends[0]]), int(model.site_bodyid[ends[1]]))
    names: dict[str, None] = {}
    paths = [_path_to_world(model, end) for end in ends]
    for path in paths:
        for body in path:
            if all(body in each_path for each_path in paths):
                break
            first = int(model.body_jntadr[body])
            for joint in range(first, first + int(model.body_jntnum[body])):
                names[model.joint(joint).name] = None
    return tuple(names)


def _path_to_world(model: Any, body: int) -> list[int]:
    """Returns a body and all bodies above it, up to the world."""
    path = []
    while body:
        path.append(body)
        body = int(model.body_parentid[body])
    return [*path, 0]


def _equality_name(model: Any, equality: int) -> str:
    return str(model.equality(equality).name) if equality >= 0 else ""
