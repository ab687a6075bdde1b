"""How far two models that MuJoCo compiled move apart from the same start, under the same controls."""

from copy import copy
from dataclasses import dataclass

import mujoco
import numpy as np

LIMIT = 1e-6
"""Joint values [m, rad] that differ by no more are the same motion."""

SECONDS = 1.0

ROUNDING = 1e-12
"""Robot files have their numbers to this share."""

CHAOS = 100.0
"""Distances up to this many times that of the original from itself with rounded masses are its own chaos."""

SEEDS = 8
"""Roundings of the original that are tried at most."""

WIDTHS = {0: (7, 6), 1: (4, 3), 2: (1, 1), 3: (1, 1)}
"""Numbers of a joint in `qpos` and in `qvel`, by MuJoCo's type."""


@dataclass(frozen=True, slots=True)
class Apart:
    """How far a run is from the original [m, rad], from which start, and how far the original is from itself
    at most where its masses and meshes are rounded otherwise."""

    off: float
    start: str
    own: float

    @property
    def same(self):
        return self.off <= LIMIT

    @property
    def chaotic(self):
        """Whether the original itself depends on the last digits so much."""
        return not self.same and self.off <= CHAOS * self.own


class Pair:
    """A model and what was made of it, whose joints and actuators are those of the same names."""

    def __init__(self, original, made):
        self.original, self.made = original, made
        self.qpos, self.qvel = self._joints()
        self.act, self.ctrl = self._actuators()
        self.mocap = [
            (int(original.body_mocapid[body]), int(made.body_mocapid[self._body(body)]))
            for body in range(original.nbody)
            if original.body_mocapid[body] >= 0
        ]

    def _body(self, body):
        """A body by its name; without a name by that which the reader gives it, else by its place."""
        name = self.original.body(body).name
        for called in (name, f"body_{body}"):
            index = mujoco.mj_name2id(self.made, mujoco.mjtObj.mjOBJ_BODY, called) if called else -1
            if index >= 0:
                return int(index)
        return body

    def _joints(self):
        """Each number in `qpos` and in `qvel`."""
        original, made = self.original, self.made
        qpos = []
        qvel = []
        for joint in range(original.njnt):
            other = self._joint(joint)
            positions, speeds = WIDTHS[int(original.jnt_type[joint])]
            first, second = int(original.jnt_qposadr[joint]), int(made.jnt_qposadr[other])
            qpos += [(first + place, second + place) for place in range(positions)]
            first, second = int(original.jnt_dofadr[joint]), int(made.jnt_dofadr[other])
            qvel += [(first + place, second + place) for place in range(speeds)]
        return qpos, qvel

    def _joint(self, joint):
        """A joint by its name; without a name by its place on its body."""
        original, made = self.original, self.made
        name = original.joint(joint).name
        index = mujoco.mj_name2id(made, mujoco.mjtObj.mjOBJ_JOINT, name) if name else -1
        if index >= 0:
            return int(index)
        body = int(original.jnt_bodyid[joint])
        return int(made.jnt_bodyid.tolist().index(self._body(body))) + joint - int(original.body_jntadr[body])

    def _actuators(self):
        """Each number in `act` and in `ctrl`; what was lost is left out."""
        original, made = self.original, self.made
        act = []
        ctrl = []
        for index in range(original.nu):
            name = original.actuator(index).name
            other = mujoco.mj_name2id(made, mujoco.mjtObj.mjOBJ_ACTUATOR, name) if name else index
            if 0 <= other < made.nu:
                ctrl.append((index, int(other)))
                first, second = int(original.actuator_actadr[index]), int(made.actuator_actadr[other])
                act += [
                    (first + place, second + place) for place in range(int(original.actuator_actnum[index]))
                ]
        return act, ctrl

    def start(self, key):
        """Both at qpos0 (-1) or at a keyframe of the original."""
        was, now = mujoco.MjData(self.original), mujoco.MjData(self.made)
        if key >= 0:
            mujoco.mj_resetDataKeyframe(self.original, was, key)
        for name, pairs in (("qpos", self.qpos), ("qvel", self.qvel), ("act", self.act)):
            for first, other in pairs:
                getattr(now, name)[other] = getattr(was, name)[first]
        for first, other in self.mocap:
            now.mocap_pos[other], now.mocap_quat[other] = was.mocap_pos[first], was.mocap_quat[first]
        was.ctrl[:] = now.ctrl[:] = 0
        return was, now

    def controls(self, seed, steps):
        """(steps, nu): zero without a seed, else constant for 20 steps each, within the ranges."""
        model = self.original
        if seed is None or not model.nu:
            return np.zeros((steps, model.nu))
        low, high = np.where(model.actuator_ctrllimited[:, None], model.actuator_ctrlrange, (-1.0, 1.0)).T
        pieces = np.random.default_rng(seed).uniform(low, high, (steps // 20 + 1, model.nu))
        return np.repeat(pieces, 20, axis=0)[:steps]

    def apart(self, key, seed):
        """The largest difference of a joint's value over the run; infinite where only one of the two has
        values that are no numbers."""
        was, now = self.start(key)
        steps = max(1, round(SECONDS / self.original.opt.timestep))
        columns, other = (list(side) for side in zip(*self.qpos, strict=True))
        worst = 0.0
        for controls in self.controls(seed, steps):
            was.ctrl[:] = controls
            for own, its in self.ctrl:
                now.ctrl[its] = controls[own]
            mujoco.mj_step(self.original, was)
            mujoco.mj_step(self.made, now)
            off = float(np.abs(was.qpos[columns] - now.qpos[other]).max())
            if not np.isfinite(off):
                return worst if np.isnan(was.qpos).any() and np.isnan(now.qpos).any() else np.inf
            worst = max(worst, off)
        return worst


def rounded(original, seed):
    """The model with other last digits of its masses and of the vertices of its meshes, which MuJoCo has in
    single precision."""
    made, rng = copy(original), np.random.default_rng(seed)
    made.body_mass[:] *= 1 + ROUNDING * rng.uniform(-1, 1, made.body_mass.shape)
    made.body_inertia[:] *= 1 + ROUNDING * rng.uniform(-1, 1, made.body_inertia.shape)
    if len(made.mesh_vert):
        single = np.finfo(np.float32).eps * np.abs(made.mesh_vert).max()
        made.mesh_vert[:] += rng.uniform(-single, single, made.mesh_vert.shape).astype(np.float32)
    return made


def runs(original, made):
    """How far runs from qpos0 and from each keyframe are apart, without controls and with seeded ones, and
    their starts."""
    pair = Pair(original, made)
    for key in range(-1, original.nkey):
        for seed in (None, 1) if original.nu else (None,):
            start = "qpos0" if key < 0 else f"keyframe {original.key(key).name or key}"
            yield pair.apart(key, seed), start + ("" if seed is None else " with controls")


def farthest(original, made):
    """The run that is the furthest from the original."""
    off, start = max(runs(original, made))
    own = 0.0
    for seed in range(SEEDS):
        if off > max(LIMIT, CHAOS * own):
            own = max(own, *(distance for distance, _ in runs(original, rounded(original, seed))))
    return Apart(off, start, own)
