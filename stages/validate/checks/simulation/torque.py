"""Checks that the actuators can hold the robot's weight, and a payload, over the range of the joints."""

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
from linkwright.stages.validate.simulate.holding import holding_forces, strength

HEADER = ("joint", "unit", "holds at home", "holds at most", "can hold", "share")
"""Columns of the table. The share is that of `can hold` which `holds at most` takes."""

POSES = 64
"""Number of poses sampled in the robot's range, in addition to `home`."""

MAX_LINK_POSES, MIN_POSES = 20_000, 8
"""Largest product of links and poses, which bounds the time for large robots; and the smallest number of
poses in spite of it."""

SLIDE_TRAVEL = 0.5
"""Travel [m] of slides without limits."""


def check(compiled: CompiledModel) -> Iterator[Check]:
    """Compares the force that holds the weight with the strength of each driven joint, in a table. Yields
    nothing for robots whose joints hold no weight."""
    model, robot, payload = compiled.model, compiled.robot, dict(compiled.options.payload)
    forces = holding_forces(model, robot, _poses(compiled), payload) if robot.dofs else {}
    if not forces:
        return
    rows: list[tuple[str | float | None, ...]] = []
    shares: list[tuple[float, str]] = []
    findings: list[Finding] = []
    for name, force in forces.items():
        available, largest, unit = (
            strength(model, joint_index(model, name)),
            _largest_load(compiled, name, force),
            _unit(model, name),
        )
        # A joint without strength has a huge share instead of a division by zero.
        share = None if available is None else largest / max(available, 1e-9)
        rows.append((name, unit, *map(_rounded, (force[0], largest, available, share))))
        if available is None or share is None:
            continue
        shares.append((share, name))
        if share > 1.0:
            message = (
                f"it needs up to {largest:.3g} {unit} to hold the weight, and has {available:.3g} {unit}"
            )
            findings.append(Finding(named("joint", name), _force_limit_attribute(model, name), message))
    largest_share, worst_joint = max(shares, default=(0.0, "no joint with a limit"))
    load = f"load of the weight{_payload_text(compiled)}"
    detail = f"{load}, as a share of the joint's strength; largest: {worst_joint}"
    result = compiled.within("torque margin", largest_share, 1.0, detail, findings, "warning")
    yield replace(result, table=Table(HEADER, tuple(rows)))


def _rounded(value: float | None) -> float | None:
    """Rounds off the digits that differ between machines; adding 0.0 turns -0.0 into 0.0."""
    return None if value is None else round(float(value), 6) + 0.0


def _poses(compiled: CompiledModel) -> list[Configuration]:
    """Returns `home`, and poses sampled in the robot's range."""
    start = home(compiled.robot)
    poses = max(MIN_POSES, min(POSES, MAX_LINK_POSES // len(compiled.robot.links)))
    samples = sampled_poses(compiled.robot, poses, SLIDE_TRAVEL, start)
    count = min(map(len, samples.values()))
    return [start, *({name: _value(values[row]) for name, values in samples.items()} for row in range(count))]


def _value(value: Any) -> Any:
    return float(value) if np.ndim(value) == 0 else tuple(map(float, value))


def _largest_load(compiled: CompiledModel, name: str, force: Array) -> float:
    """Returns the largest force that holds the weight. For a robot on its feet it is at least the load of the
    joint, which the export stage computes from the weight on the feet."""
    drive = compiled.written.actuation.actuator_of(name)
    load = drive.load if drive is not None and not compiled.robot.base.fixed else None
    return max(float(np.abs(force).max()), load or 0.0)


def _unit(model: Any, name: str) -> str:
    return "N m" if model.jnt_type[joint_index(model, name)] == HINGE else "N"


def _force_limit_attribute(model: Any, name: str) -> str:
    """Returns the attribute that limits the force on a joint."""
    limited = model.jnt_actfrclimited[joint_index(model, name)]
    return "actuatorfrcrange" if limited else "forcerange of its actuator"


def _payload_text(compiled: CompiledModel) -> str:
    carried = [f"{mass:g} kg at {name}" for name, mass in compiled.options.payload]
    return f" with {', '.join(carried)}" if carried else ""
