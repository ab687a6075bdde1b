"""A simulation starts with nothing inside something else: at `home`, and at qpos0, where a reset leads to.

What earlier stages have reported is known and a warning: colliders that overlap at `home`, since they are
larger than their parts, and links of a fixed robot that reach into the ground. All else is an error.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import mujoco

from stages.robot.check import Check, CheckLevel, Finding
from stages.robot.geometry import Touch
from stages.robot.start_pose import HOME
from stages.validate.compiled import CompiledModel
from stages.validate.findings import named
from stages.validate.running import DEEP, at_keyframe, touching

CODE = "C-START"


@dataclass(frozen=True, slots=True)
class Overlap:
    """Two bodies in each other, the world last, and how deep [m]."""

    first: str
    second: str
    depth: float

    @property
    def finding(self) -> Finding:
        words = f"it is {1e3 * self.depth:.3g} mm inside {'the ground' if self.ground else self.second}"
        hint = (
            "see scene.pose and keyframes"
            if self.ground
            else "see contact.exclude, keyframes and its colliders"
        )
        return Finding(named("body", self.first), "pos" if self.ground else "geom", f"{words}: {hint}")

    @property
    def ground(self) -> bool:
        return self.second == "world"


def check(compiled: CompiledModel) -> Iterator[Check]:
    """An error at `home`; at qpos0 a warning, where there is a `home` to start from."""
    model = compiled.model
    has_home = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_KEY, HOME) >= 0
    if not model.ngeom:
        return
    if has_home:
        found = overlaps(model, at_keyframe(model, HOME))
        reported = {(one.link_a, one.link_b): one.depth for one in _touching(compiled)}
        deeper = [one for one in found if one.depth > _known(one, reported) + DEEP]
        if compiled.robot.base.fixed:
            deeper = [one for one in deeper if not one.ground]
        yield _result(compiled, HOME, found, "error" if deeper else "warning")
    yield _result(
        compiled, "qpos0", overlaps(model, mujoco.MjData(model)), "warning" if has_home else "error"
    )


def _touching(compiled: CompiledModel) -> tuple[Touch, ...]:
    return compiled.geometry.touching if compiled.geometry is not None else ()


def _known(one: Overlap, reported: Mapping[tuple[str, str], float]) -> float:
    """How deep [m] two bodies are reported to be in each other."""
    return max(reported.get(pair, 0.0) for pair in ((one.first, one.second), (one.second, one.first)))


def _result(compiled: CompiledModel, where: str, found: list[Overlap], level: CheckLevel) -> Check:
    deep = [one for one in found if one.depth > DEEP]
    worst = max((one.depth for one in found), default=0.0)
    detail = f"the deepest contact at {where} [m]"
    if deep:
        words = [f"{one.first} and {one.second} by {1e3 * one.depth:.3g} mm" for one in deep[:3]]
        detail = f"at {where} inside each other: {', '.join(words)}"
    findings = [one.finding for one in deep]
    return compiled.result(f"start at {where}", not deep, detail, worst, DEEP, findings, level)


def overlaps(model: Any, data: Any) -> list[Overlap]:
    """The pairs of bodies that are in contact, the deepest first, each with its deepest contact."""
    mujoco.mj_fwdPosition(model, data)
    every = touching(model, data)
    return [Overlap(model.body(a).name, model.body(b).name, depth) for a, b, depth in every if depth > 0.0]
