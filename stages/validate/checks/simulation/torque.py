"""Each joint holds the robot's weight over its range, with a payload if one is given, with what drives it."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from linkwright.stages.mujoco.names import joint_index
from linkwright.stages.robot.check import Check, Finding, Table
from linkwright.stages.robot.model.robot import Array, Configuration
from linkwright.stages.robot.motion.pose_samples import sampled_poses
from linkwright.stages.robot.motion.start_pose import home
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.findings import named
from linkwright.stages.validate.model.coordinates import HINGE
from linkwright.stages.validate.simulate.holding import holding, strength

HEADER = ("joint", "unit", "holds at home", "holds at most", "can hold", "share")

POSES = 64
"""So many poses stand for the robot's range, beside `home`."""

PLACED, FEWEST = 20_000, 8
"""The most links times poses: of a larger robot fewer poses stand for the range."""

REACH = 0.5
"""How far [m] slides without limits go."""


def check(compiled: CompiledModel) -> Iterator[Check]:
    """A warning, with a table of each joint that is driven. None for a robot that no joint holds."""
    model, robot, payload = compiled.model, compiled.robot, dict(compiled.asked.payload)
    forces = holding(model, robot, _poses(compiled), payload) if robot.dofs else {}
    if not forces:
        return
    rows: list[tuple[str | float | None, ...]] = []
    shares: list[tuple[float, str]] = []
    findings: list[Finding] = []
    for name, force in forces.items():
        able, largest, unit = (
            strength(model, joint_index(model, name)),
            _largest(compiled, name, force),
            _unit(model, name),
        )
        share = None if able is None else largest / max(able, 1e-9)
        rows.append((name, unit, *map(_rounded, (force[0], largest, able, share))))
        if able is None or share is None:
            continue
        shares.append((share, name))
        if share > 1.0:
            words = f"holding the weight takes up to {largest:.3g} {unit}, of {able:.3g} {unit} that it has"
            findings.append(Finding(named("joint", name), _key(model, name), words))
    worst, where = max(shares, default=(0.0, "none that is limited"))
    detail = f"to hold the weight{_with(compiled)}, as a share of what the joint can do; the most: {where}"
    result = compiled.within("torque margin", worst, 1.0, detail, findings, "warning")
    yield replace(result, table=Table(HEADER, tuple(rows)))


def _rounded(value: float | None) -> float | None:
    """Without the digits that differ between machines."""
    return None if value is None else round(float(value), 6) + 0.0


def _poses(compiled: CompiledModel) -> list[Configuration]:
    start = home(compiled.robot)
    poses = max(FEWEST, min(POSES, PLACED // len(compiled.robot.links)))
    drawn = sampled_poses(compiled.robot, poses, REACH, start)
    count = min(map(len, drawn.values()))
    return [start, *({name: _value(every[row]) for name, every in drawn.items()} for row in range(count))]


def _value(value: Any) -> Any:
    return float(value) if np.ndim(value) == 0 else tuple(map(float, value))


def _largest(compiled: CompiledModel, name: str, force: Array) -> float:
    """The largest force; of a robot that stands on its feet also what these carry, as the export stage has it
    of the weight alone."""
    own = compiled.written.actuation.of(name)
    stands = not compiled.robot.base.fixed and own is not None and own.load is not None
    return max(float(np.abs(force).max()), own.load if stands and own and own.load else 0.0)


def _unit(model: Any, name: str) -> str:
    return "N m" if model.jnt_type[joint_index(model, name)] == HINGE else "N"


def _key(model: Any, name: str) -> str:
    limited = model.jnt_actfrclimited[joint_index(model, name)]
    return "actuatorfrcrange" if limited else "forcerange of its actuator"


def _with(compiled: CompiledModel) -> str:
    carried = [f"{mass:g} kg at {name}" for name, mass in compiled.asked.payload]
    return f" with {', '.join(carried)}" if carried else ""
