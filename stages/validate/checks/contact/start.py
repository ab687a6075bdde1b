"""Checks that nothing is inside something else when a simulation starts: at `home`, or at qpos0 after a
reset.

Overlaps that earlier stages have reported are warnings: colliders that overlap at `home`, since they are
larger than their parts, and links of a fixed robot that reach into a ground plane. So are all overlaps of a
robot at the pose of its MJCF source, which starts the same way. All others are errors: something in the scene
is in the way.
"""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Literal

import mujoco
import numpy as np

from linkwright.stages.mujoco.state import at_keyframe, keyframe_index
from linkwright.stages.robot.check import Check, CheckLevel, Finding
from linkwright.stages.robot.model.geometry import Touch
from linkwright.stages.robot.model.scene import FLOOR
from linkwright.stages.robot.motion.start_pose import HOME, roots_in_source
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.findings import named
from linkwright.stages.validate.model.coordinates import bodies_of_scene
from linkwright.stages.validate.model.shapes import seen_and_solid
from linkwright.stages.validate.simulate.running import MAX_START_DEPTH, Touching, touching

POSE_TOLERANCE = 1e-6
"""Tolerance of poses [m, and entries of rotation matrices]: files have few digits."""

Other = Literal["ground", "obstacle", "link"]
"""What a link is inside. ground: a plane of the world; obstacle: another object of the scene; link: another
link, or a geom of a root that is the world."""

HINTS: dict[Other, str] = {
    "ground": "see scene.pose and keyframes",
    "obstacle": "move it in scene.xml, or see scene.pose and keyframes",
    "link": "see contact.exclude, keyframes and its colliders",
}


@dataclass(frozen=True, slots=True)
class Overlap:
    """An overlap of a link with another thing."""

    first: str
    second: str
    """A link's name, or a text that says what it is."""

    depth: float
    """The depth [m] of the overlap."""

    other: Other = "link"
    """The kind of `second`."""

    @property
    def finding(self) -> Finding:
        message = f"it is {1e3 * self.depth:.3g} mm inside {self.second}"
        attribute = "geom" if self.other == "link" else "pos"
        return Finding(named("body", self.first), attribute, f"{message}: {HINTS[self.other]}")


def check(compiled: CompiledModel) -> Iterator[Check]:
    """Yields an error for overlaps at `home`. For overlaps at qpos0 it yields a warning if there is a `home`
    to start from, else an error."""
    model = compiled.model
    has_home = keyframe_index(model, HOME) >= 0
    if not model.ngeom:
        return
    if has_home:
        start_overlaps = overlaps(compiled, at_keyframe(model, HOME))
        reported = {(touch.link_a, touch.link_b): touch.depth for touch in _reported_touches(compiled)}
        unexplained = [
            overlap
            for overlap in start_overlaps
            if overlap.depth > _reported_depth(overlap, reported) + MAX_START_DEPTH
        ]
        if compiled.robot.base.fixed:
            unexplained = [overlap for overlap in unexplained if overlap.other != "ground"]
        wrong = bool(unexplained) and not _is_as_in_source(compiled)
        yield _result(compiled, HOME, start_overlaps, "error" if wrong else "warning")
    start_overlaps = overlaps(compiled, mujoco.MjData(model))
    yield _result(compiled, "qpos0", start_overlaps, "warning" if has_home else "error")


def _is_as_in_source(compiled: CompiledModel) -> bool:
    """Tells whether the robot at `home` is where its MJCF source has it, without a ground that the source
    does not have."""
    robot, scene = compiled.robot, compiled.written.scene
    if robot.mjcf is None or scene is None or scene.ground is not None:
        return False
    roots = roots_in_source(robot)
    world_from_root = dict(scene.keyframes).get(HOME, scene.world_from_root)
    return bool(np.abs(world_from_root - roots.get(HOME, roots[""])).max() < POSE_TOLERANCE)


def _reported_touches(compiled: CompiledModel) -> tuple[Touch, ...]:
    return compiled.geometry.touching if compiled.geometry is not None else ()


def _reported_depth(overlap: Overlap, reported: Mapping[tuple[str, str], float]) -> float:
    """Returns the depth [m] that was reported for the two links, in either order; 0 if none was."""
    pairs = (overlap.first, overlap.second), (overlap.second, overlap.first)
    return max(reported.get(pair, 0.0) for pair in pairs)


def _result(compiled: CompiledModel, where: str, start_overlaps: list[Overlap], level: CheckLevel) -> Check:
    deep_overlaps = [overlap for overlap in start_overlaps if overlap.depth > MAX_START_DEPTH]
    worst = max((overlap.depth for overlap in start_overlaps), default=0.0)
    detail = f"the deepest contact at {where} [m]"
    if deep_overlaps:
        texts = [
            f"{overlap.first} and {overlap.second} by {1e3 * overlap.depth:.3g} mm"
            for overlap in deep_overlaps[:3]
        ]
        detail = f"at {where} inside each other: {', '.join(texts)}"
    findings = [overlap.finding for overlap in deep_overlaps]
    return compiled.result(
        f"start at {where}", not deep_overlaps, detail, worst, MAX_START_DEPTH, findings, level
    )


def overlaps(compiled: CompiledModel, data: Any) -> list[Overlap]:
    """Returns the overlaps of the contacts, the deepest first, each pair of things once."""
    mujoco.mj_fwdPosition(compiled.model, data)
    scene_bodies = bodies_of_scene(compiled.model, compiled.robot)
    contacts = touching(compiled.model, data)
    return [_overlap(compiled, contact, scene_bodies) for contact in contacts if contact.depth > 0.0]


def _overlap(compiled: CompiledModel, contact: Touching, scene_bodies: Collection[int]) -> Overlap:
    model = compiled.model
    if contact.other == 0:
        return Overlap(model.body(contact.body).name, *_world_overlap(compiled, contact.geom, contact.depth))
    first, second = contact.body, contact.other
    if first in scene_bodies and second not in scene_bodies:
        first, second = second, first
    name = model.body(second).name
    if second in scene_bodies and first not in scene_bodies:
        return Overlap(
            model.body(first).name, f"{named('body', name)} of the scene", contact.depth, "obstacle"
        )
    return Overlap(model.body(first).name, name, contact.depth)


def _world_overlap(compiled: CompiledModel, geom: int, depth: float) -> tuple[str, float, Other]:
    """Returns the last three fields of `Overlap` for a geom of the world, overlapped by `depth` [m]."""
    model = compiled.model
    name = model.geom(geom).name
    if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_PLANE:
        return ("the ground" if name in ("", FLOOR) else f"the ground ({name})"), depth, "ground"
    if compiled.robot.root.name == "world" and geom in _root_colliders(compiled):
        return "world", depth, "ground"
    return named("geom", name) if name else "a geom of the world", depth, "obstacle"


def _root_colliders(compiled: CompiledModel) -> list[int]:
    """Returns the colliders of a root that is the world. They precede the world's geoms from the scene."""
    number = 0 if compiled.geometry is None else len(compiled.geometry.shapes_of("world", "collision"))
    return seen_and_solid(compiled.model).get(0, ([], []))[1][:number]
