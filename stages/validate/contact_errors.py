"""Finds contacts of a robot with itself that differ from those of its visual shapes, over poses within its
limits.

*False*: colliders of two bodies overlap by more than 2 mm, while their visual shapes are more than that
apart, neither inside the other. *Missed*: the visual shapes intersect, and the colliders do not touch. At
`home` any overlap counts between visual shapes that are apart. MuJoCo decides what collides; the visual
shapes are the triangles and primitives of the file: neither depends on how the colliders were made.
"""

from dataclasses import dataclass, field
from typing import Any

import mujoco
import numpy as np

from linkwright.stages.mujoco.names import body_index
from linkwright.stages.robot.contact.meeting_boxes import meeting_boxes
from linkwright.stages.robot.model.geometry import ExcludeReason
from linkwright.stages.robot.model.poses import inverse
from linkwright.stages.robot.model.robot import Array, Link
from linkwright.stages.robot.motion.pose_batch import count_of
from linkwright.stages.robot.motion.pose_samples import sampled_poses
from linkwright.stages.robot.motion.start_pose import home
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.model.coordinates import pose_of, set_values
from linkwright.stages.validate.model.seen_surfaces import SeenSurfaces
from linkwright.stages.validate.model.shapes import is_bare_by_choice, seen_and_solid

FALSE_DEPTH = 2e-3
"""Depth [m] from which a contact can be false, and distance [m] within which visual shapes count as near."""

TOUCH_DISTANCE = 1e-4
"""Distance [m] within which colliders touch: faces that slide on each other must, in single precision too."""

HOME_FALSE_DEPTH = 1e-5
HOME_MIN_DISTANCE = 2e-4
"""Limits at `home` [m]. Smaller depths are mere touches. Nearer visual shapes may touch in CAD, since meshes
deviate from CAD by as much."""

SLIDE_TRAVEL = 0.5
"""Travel [m] of slides without limits."""

SALT = "contacts that others than the maker of colliders see"
"""Seed of the sampled poses, which differ from those at which colliders are made."""


@dataclass(frozen=True, slots=True)
class PairErrors:
    """Two bodies whose contact differs from that of their visual shapes."""

    bodies: tuple[int, int]
    false: int
    """Number of poses with a false contact."""

    missed: int
    """Number of poses with a missed contact."""

    apart: float
    """The largest distance [m] of the visual shapes at the false contacts."""

    at_home: float
    """The depth [m] of a false contact at `home`."""

    reason: ExcludeReason | None
    """Why the pair is excluded from contact, if it is."""


@dataclass(frozen=True, slots=True)
class ContactErrors:
    """The contact errors of a robot."""

    poses: int
    """Number of sampled poses, `home` not counted."""

    bodies: int
    """Number of visible bodies that were judged."""

    pairs: tuple[PairErrors, ...]


@dataclass(slots=True)
class _Pair:
    """The results for two bodies so far."""

    reason: ExcludeReason | None
    false: list[Array] = field(default_factory=list)
    """Poses of the second body in the first (4, 4), with false contact."""

    cuts: int = 0
    cuts_at_home: bool = False
    at_home: float = 0.0


class _Judge:
    """The bodies of a robot in MuJoCo, with their visual shapes."""

    def __init__(self, compiled: CompiledModel) -> None:
        self.model = compiled.model
        self.data = mujoco.MjData(self.model)
        shapes = seen_and_solid(self.model)
        links = {link.name: body_index(self.model, link.name) for link in compiled.robot.links}
        judged = {links[link.name] for link in compiled.robot.links if _is_judged(link)}
        seen = {body: shapes[body][0] for body in judged & shapes.keys() if shapes[body][0]}
        bare = {body for body in seen if not shapes[body][1] and _is_bare(compiled, body)}
        self.bodies = np.array(sorted(seen.keys() - bare), dtype=int)
        self.solid = {int(body): shapes[int(body)][1] for body in self.bodies}
        self.of_geom = np.full(self.model.ngeom, -1)
        for body, geoms in self.solid.items():
            self.of_geom[geoms] = body
        self.surfaces = SeenSurfaces(self.model, seen)
        boxes = np.array([self.surfaces.box(body) for body in self.solid]).reshape(-1, 2, 3)
        self.middles, self.halves = boxes.mean(axis=1), (boxes[:, 1] - boxes[:, 0]) / 2.0
        self.reasons: dict[tuple[int, int], ExcludeReason] = {}
        self.partly: set[tuple[int, int]] = set()
        for exclude in compiled.geometry.excludes if compiled.geometry else ():
            low, high = sorted((links.get(exclude.link_a, -1), links.get(exclude.link_b, -1)))
            self.reasons[low, high] = exclude.reason
            # Which visual shapes belong to the shapes that do not collide is unknown.
            self.partly |= {(low, high)} if exclude.geoms else set()
        self.pairs: dict[tuple[int, int], _Pair] = {}

    def pair(self, first: int, second: int) -> _Pair:
        if (first, second) not in self.pairs:
            self.pairs[first, second] = _Pair(self.reasons.get((first, second)))
        return self.pairs[first, second]

    def are_adjacent(self, first: int, second: int) -> bool:
        """Tells whether two bodies are adjacent, so that their contact means nothing."""
        return self.reasons.get((first, second)) == "Adjacent" or never_collide(self.model, first, second)

    def second_from_first(self, first: int, second: int) -> Array:
        return inverse(pose_of(self.data, first)) @ pose_of(self.data, second)

    def depths(self) -> dict[tuple[int, int], float]:
        """Maps each pair of bodies in contact to the depth [m] by which their colliders overlap."""
        mujoco.mj_collision(self.model, self.data)
        depths: dict[tuple[int, int], float] = {}
        contacts = self.data.contact
        pairs = np.sort(self.of_geom[contacts.geom.reshape(-1, 2)], axis=1)
        for (first, second), gap in zip(pairs.tolist(), contacts.dist.tolist(), strict=True):
            if 0 <= first != second:
                depths[first, second] = max(-gap, depths.get((first, second), -np.inf))
        return depths

    def with_meeting_boxes(self) -> list[tuple[int, int]]:
        """Returns the pairs of bodies whose boxes meet."""
        rotations = self.data.xmat[self.bodies].reshape(-1, 3, 3)
        middles = self.data.xpos[self.bodies] + np.einsum("nij,nj->ni", rotations, self.middles)
        halves = np.einsum("nij,nj->ni", np.abs(rotations), self.halves)
        # The bodies are sorted, and so are the pairs.
        pairs = self.bodies[meeting_boxes(middles - halves, middles + halves)].tolist()
        return [(first, second) for first, second in pairs]

    def are_touching(self, first: int, second: int) -> bool:
        """Tells whether colliders of two bodies touch, even if the bodies are excluded from contact."""
        return any(
            mujoco.mj_geomDistance(self.model, self.data, a, b, 2.0 * TOUCH_DISTANCE, None) <= TOUCH_DISTANCE
            for a in self.solid[first]
            for b in self.solid[second]
        )

    def judge_pose(self, *, at_home: bool) -> None:
        """Judges the pose of `data`."""
        depths = self.depths()
        for (first, second), depth in depths.items():
            min_depth, min_distance = (
                (HOME_FALSE_DEPTH, HOME_MIN_DISTANCE) if at_home else (FALSE_DEPTH, FALSE_DEPTH)
            )
            if depth <= min_depth or self.are_adjacent(first, second):
                continue
            pose = self.second_from_first(first, second)
            if not self.surfaces.near(first, second, pose, min_distance):
                pair = self.pair(first, second)
                if at_home:
                    pair.at_home = depth
                else:
                    pair.false.append(pose)
        for first, second in self.with_meeting_boxes():
            if depths.get((first, second), -np.inf) >= -TOUCH_DISTANCE or (first, second) in self.partly:
                continue
            if self.are_adjacent(first, second):
                continue
            if not self.surfaces.near(first, second, self.second_from_first(first, second), 0.0):
                continue
            reason = self.reasons.get((first, second))
            if reason is not None or not self.are_touching(first, second):
                pair = self.pair(first, second)
                pair.cuts_at_home |= at_home
                pair.cuts += not at_home


def contact_errors(compiled: CompiledModel, poses: int, salt: str = SALT) -> ContactErrors:
    """Finds the pairs of bodies with false or missed contacts, at seeded poses within the limits with loops
    closed.

    Adjacent pairs never collide, and are not judged. Pairs that are excluded because they overlap in every
    pose count as missed if their visual shapes overlap in some poses only.
    """
    judge, robot = _Judge(compiled), compiled.robot
    start = home(robot)
    values = sampled_poses(robot, poses, SLIDE_TRAVEL, start, salt) if robot.dofs else {}
    count = count_of(values) if values else 0
    for row in range(-1, count):
        q = start if row < 0 else {name: _value(samples[row]) for name, samples in values.items()}
        set_values(judge.model, judge.data, robot, q, urdf=False)
        judge.judge_pose(at_home=row < 0)
    errors = []
    for bodies, pair in sorted(judge.pairs.items()):
        false = judge.surfaces.outside(*bodies, pair.false)
        always = pair.reason == "Always" and (pair.cuts_at_home or pair.cuts == count)
        missed = 0 if always else pair.cuts
        if false or missed or pair.at_home:
            max_distance = judge.surfaces.furthest(*bodies, false) if false else 0.0
            errors.append(PairErrors(bodies, len(false), missed, max_distance, pair.at_home, pair.reason))
    return ContactErrors(count, len(judge.bodies), tuple(errors))


def _is_judged(link: Link) -> bool:
    """Tells whether the link's colliders are drawn, or visual shapes are drawn in their place."""
    parts = [part for part in link.parts if part.mesh is not None]
    is_solid = any(not part.seen for part in parts) or any(not shape.visual for shape in link.shapes)
    is_seen = any(not part.collides for part in parts) or any(not shape.collision for shape in link.shapes)
    return is_seen or not is_solid


def _is_bare(compiled: CompiledModel, body: int) -> bool:
    """Tells whether a body without colliders is intended to have none."""
    return compiled.robot.mjcf is not None or is_bare_by_choice(compiled, compiled.model.body(body).name)


def _value(value: Any) -> Any:
    return float(value) if np.ndim(value) == 0 else tuple(map(float, value))


def never_collide(model: Any, first: int, second: int) -> bool:
    """Tells whether MuJoCo never lets two bodies collide, whatever the file says of contact. It ignores the
    contacts of parts of one rigid body, and of parent and child if neither is fixed to the world."""
    welds = [int(model.body_weldid[body]) for body in (first, second)]
    if welds[0] == welds[1] or model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_FILTERPARENT:
        return welds[0] == welds[1]
    above = [int(model.body_weldid[model.body_parentid[weld]]) for weld in welds]
    return all(welds) and (welds[0] == above[1] or welds[1] == above[0])
