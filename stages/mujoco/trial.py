"""A trial run: whether a robot's MuJoCo model stays whole and finite while it is simulated."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt

from linkwright.stages.mujoco.state import at_keyframe
from linkwright.stages.mujoco.warnings import listening
from linkwright.stages.robot.model.robot import Array

SECONDS = 2.0
"""The length of a trial run."""

OPEN = 1e-3
"""How far [m, rad] the equalities that close loops may open."""

RIGID = 0.999
"""The impedance from which on an equality is to hold: ours do, and one of an MJCF source may be soft."""

EFFORT = 1e7
"""Bound of steps times the square of the speeds' number: a robot of more than 100 runs for a shorter time."""


@dataclass(frozen=True, slots=True)
class Trial:
    """The outcome of a trial run. `failed`: what went wrong, "" for nothing; `time` [s] when, or the end.
    `joints`: the names of the joints that it began with, worst first; `opening`: the largest distance of
    a loop from closed [m, rad], and `loop`: the equality that was."""

    failed: str
    time: float
    joints: tuple[str, ...] = ()
    opening: float = 0.0
    loop: str = ""

    @property
    def joint(self) -> str:
        """The name of the joint that the failure began with, "" for none."""
        return self.joints[0] if self.joints else ""


def trial_run(
    model: Any, seconds: float = SECONDS, opening: float = OPEN, start: Array | None = None
) -> Trial:
    """Simulates a model from its keyframe `home`, with the controls there, or from the positions `start`, at
    its own time step. It fails where MuJoCo warns, and where a loop opens by more than `opening` [m, rad], or
    twice what it is then."""
    data = at_keyframe(model)
    if start is not None:
        data.qpos[:] = start
    mujoco.mj_forward(model, data)
    closing = _closing(model)
    allowed = max(opening, 2.0 * _opening(data, closing)[0])
    steps = round(seconds / model.opt.timestep)
    steps = max(1, min(steps, int(EFFORT / max(1, model.nv) ** 2)))
    most, loop = 0.0, -1
    with listening():
        for done in range(steps):
            mujoco.mj_step(model, data)
            time = (done + 1) * model.opt.timestep
            if found := failure(model, data):
                return Trial(found[0], time, found[1], most, _name(model, loop))
            now, which = _opening(data, closing)
            if now > most:
                most, loop = now, which
            if most > allowed:
                text = f"{_name(model, loop)} opened by {most:.2g}"
                return Trial(text, time, _of_equality(model, loop), most, _name(model, loop))
    return Trial("", steps * model.opt.timestep, (), most, _name(model, loop))


def failure(model: Any, data: Any) -> tuple[str, tuple[str, ...]] | None:
    """What went wrong since the data was reset, in words, and the names of the joints that it began with;
    None for nothing."""
    warned = [index for index, number in enumerate(data.warning.number.tolist()) if number]
    if warned or not np.isfinite(data.qpos).all():
        return _words(warned), _joints(model, data, warned)
    return None


def _closing(model: Any) -> npt.NDArray[np.bool_]:
    """By equality: whether it is a connect or weld that is to hold; none at all where no equality is."""
    closes = np.isin(model.eq_type, (mujoco.mjtEq.mjEQ_CONNECT, mujoco.mjtEq.mjEQ_WELD))
    closing: npt.NDArray[np.bool_] = closes & (model.eq_solimp[:, 1] >= RIGID)
    return closing if closing.any() else closing[:0]


def _opening(data: Any, closes: npt.NDArray[np.bool_]) -> tuple[float, int]:
    """The largest error of the equalities that `closes` says [m, rad], and its number; -1 without any."""
    if not len(closes) or not data.ne:
        return 0.0, -1
    # The rows of equalities come first.
    equalities = data.efc_id[: data.ne]
    closing = closes[equalities]
    if not closing.any():
        return 0.0, -1
    squares = np.bincount(equalities[closing], data.efc_pos[: data.ne][closing] ** 2)
    worst = int(squares.argmax())
    return float(np.sqrt(squares[worst])), worst


_WARNINGS = {
    "mjWARN_BADQPOS": "its positions became infinite",
    "mjWARN_BADQVEL": "its speeds became infinite",
    "mjWARN_BADQACC": "its accelerations became infinite",
    "mjWARN_CONTACTFULL": "it has too many contacts",
    "mjWARN_CNSTRFULL": "it has too many constraints",
    "mjWARN_INERTIA": "its mass matrix is singular",
    "mjWARN_BADCTRL": "a control is not finite",
}


def _words(warned: Sequence[int]) -> str:
    names = [mujoco.mjtWarning(index).name for index in warned]
    return ", ".join(_WARNINGS.get(name, name) for name in names) or "its positions became infinite"


def _joints(model: Any, data: Any, warned: Sequence[int]) -> tuple[str, ...]:
    """The joint that MuJoCo names with the warning."""
    bad = ("mjWARN_BADQPOS", "mjWARN_BADQVEL", "mjWARN_BADQACC")
    for index in warned:
        if mujoco.mjtWarning(index).name not in bad:
            continue
        number = int(data.warning[index].lastinfo)
        if mujoco.mjtWarning(index).name == "mjWARN_BADQPOS":
            number = int(model.jnt_dofadr[np.searchsorted(model.jnt_qposadr, number, side="right") - 1])
        if 0 <= number < model.nv:
            return (model.joint(int(model.dof_jntid[number])).name,)
    return ()


def _of_equality(model: Any, equality: int) -> tuple[str, ...]:
    """The joints above both bodies of an equality, the nearest first, those of the world's own left out."""
    ends = (int(model.eq_obj1id[equality]), int(model.eq_obj2id[equality]))
    if model.eq_objtype[equality] == mujoco.mjtObj.mjOBJ_SITE:
        ends = (int(model.site_bodyid[ends[0]]), int(model.site_bodyid[ends[1]]))
    names: dict[str, None] = {}
    ways = [_way(model, end) for end in ends]
    for way in ways:
        for body in way:
            if all(body in other for other in ways):
                break
            first = int(model.body_jntadr[body])
            for joint in range(first, first + int(model.body_jntnum[body])):
                names[model.joint(joint).name] = None
    return tuple(names)


def _way(model: Any, body: int) -> list[int]:
    way = []
    while body:
        way.append(body)
        body = int(model.body_parentid[body])
    return [*way, 0]


def _name(model: Any, equality: int) -> str:
    return str(model.equality(equality).name) if equality >= 0 else ""
