"""A simulation starts with nothing inside something else: at `home`, and at qpos0, where a reset leads to.

What earlier stages have reported is known and a warning: colliders that overlap at `home`, since they are
larger than their parts, and links of a fixed robot that reach into the ground, which is a plane. So is all
of a robot that stands where its source, an MJCF, has it: the source starts so. All else is an error: what
else the scene has is in the way.
"""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Literal

import mujoco
import numpy as np

from linkwright.stages.mujoco.state import at_keyframe, keyframe_of
from linkwright.stages.robot.check import Check, CheckLevel, Finding
from linkwright.stages.robot.model.geometry import Touch
from linkwright.stages.robot.model.scene import FLOOR
from linkwright.stages.robot.motion.start_pose import HOME, roots_in_source
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.findings import named
from linkwright.stages.validate.model.coordinates import of_the_scene
from linkwright.stages.validate.model.shapes import seen_and_solid
from linkwright.stages.validate.simulate.running import DEEP, Touching, touching

SAME = 1e-6
"""Poses that differ by less [m, and of rotation matrices] are the same: files have few digits."""

Other = Literal["ground", "obstacle", "link"]
"""What a link may be in: a plane of the world; something else of the scene; another link, or what a robot
whose root is the world has there."""

HINTS: dict[Other, str] = {
    "ground": "see scene.pose and keyframes",
    "obstacle": "move it in scene.xml, or see scene.pose and keyframes",
    "link": "see contact.exclude, keyframes and its colliders",
}


@dataclass(frozen=True, slots=True)
class Overlap:
    """Two things in each other, the robot's first, and how deep [m]. `second`: a link's name, or words."""

    first: str
    second: str
    depth: float
    other: Other = "link"

    @property
    def finding(self) -> Finding:
        words = f"it is {1e3 * self.depth:.3g} mm inside {self.second}"
        attribute = "geom" if self.other == "link" else "pos"
        return Finding(named("body", self.first), attribute, f"{words}: {HINTS[self.other]}")


def check(compiled: CompiledModel) -> Iterator[Check]:
    """An error at `home`; at qpos0 a warning, where there is a `home` to start from."""
    model = compiled.model
    has_home = keyframe_of(model, HOME) >= 0
    if not model.ngeom:
        return
    if has_home:
        found = overlaps(compiled, at_keyframe(model, HOME))
        reported = {(one.link_a, one.link_b): one.depth for one in _touching(compiled)}
        deeper = [one for one in found if one.depth > _known(one, reported) + DEEP]
        if compiled.robot.base.fixed:
            deeper = [one for one in deeper if one.other != "ground"]
        wrong = bool(deeper) and not _as_in_source(compiled)
        yield _result(compiled, HOME, found, "error" if wrong else "warning")
    found = overlaps(compiled, mujoco.MjData(model))
    yield _result(compiled, "qpos0", found, "warning" if has_home else "error")


def _as_in_source(compiled: CompiledModel) -> bool:
    """Whether the robot stands at `home` where its source, an MJCF, has it, on no ground but the source's."""
    robot, scene = compiled.robot, compiled.written.scene
    if robot.mjcf is None or scene is None or scene.ground is not None:
        return False
    roots = roots_in_source(robot)
    there = dict(scene.keyframes).get(HOME, scene.world_from_root)
    return bool(np.abs(there - roots.get(HOME, roots[""])).max() < SAME)


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


def overlaps(compiled: CompiledModel, data: Any) -> list[Overlap]:
    """What is in contact, the deepest first, each pair with its deepest contact."""
    mujoco.mj_fwdPosition(compiled.model, data)
    strange = of_the_scene(compiled.model, compiled.robot)
    every = touching(compiled.model, data)
    return [_overlap(compiled, one, strange) for one in every if one.depth > 0.0]


def _overlap(compiled: CompiledModel, one: Touching, strange: Collection[int]) -> Overlap:
    model = compiled.model
    if one.other == 0:
        return Overlap(model.body(one.body).name, *_of_the_world(compiled, one.geom, one.depth))
    first, second = one.body, one.other
    if first in strange and second not in strange:
        first, second = second, first
    name = model.body(second).name
    if second in strange and first not in strange:
        return Overlap(model.body(first).name, f"{named('body', name)} of the scene", one.depth, "obstacle")
    return Overlap(model.body(first).name, name, one.depth)


def _of_the_world(compiled: CompiledModel, geom: int, depth: float) -> tuple[str, float, Other]:
    """(words, depth [m], what it is) of a geom of the world that is touched."""
    model = compiled.model
    name = model.geom(geom).name
    if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_PLANE:
        return ("the ground" if name in ("", FLOOR) else f"the ground ({name})"), depth, "ground"
    if compiled.robot.root.name == "world" and geom in _colliders_of_the_world(compiled):
        return "world", depth, "ground"
    return named("geom", name) if name else "a geom of the world", depth, "obstacle"


def _colliders_of_the_world(compiled: CompiledModel) -> list[int]:
    """The geoms of a root that is the world: they come before those of the scene."""
    number = 0 if compiled.geometry is None else len(compiled.geometry.of("world", "collision"))
    return seen_and_solid(compiled.model).get(0, ([], []))[1][:number]
