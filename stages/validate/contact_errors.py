"""Where the contact of a robot with itself is not that of what is seen of it, over poses within its limits.

*False*: colliders of two bodies are in each other by more than 2 mm, and what is seen of them is more than
that apart, neither in the other. *Missed*: what is seen of them cuts, and their colliders do not touch. At
`home` no depth is borne between what stands apart. What collides is MuJoCo's word, what is seen the triangles
and primitives of the file: neither knows how the colliders were made.
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
from linkwright.stages.validate.model.shapes import asked_bare, seen_and_solid

DEEP = 2e-3
"""Colliders that are in each other by less [m] are no false contact, and what is seen is near within it."""

TOUCH = 1e-4
"""Colliders within it [m] touch: faces that slide on each other do, whatever single precision says."""

HOME_DEEP = 1e-5
HOME_APART = 2e-4
"""At `home` [m]: what is less deep only touches, and what is nearer may touch in CAD, of which what is seen
is so far off."""

REACH = 0.5
"""How far [m] slides without limits go."""

SALT = "contacts that others than the maker of colliders see"


@dataclass(frozen=True, slots=True)
class PairErrors:
    """Two bodies whose contact is not that of what is seen of them: in how many poses it is false, how far
    [m] what is seen is apart there at most, and in how many it is missed; and how deep [m] their colliders
    are in each other at `home`, where that is false. `reason`: why they do not collide, where they do not."""

    bodies: tuple[int, int]
    false: int
    missed: int
    apart: float
    at_home: float
    reason: ExcludeReason | None


@dataclass(frozen=True, slots=True)
class ContactErrors:
    """`poses`: at how many it was looked, beside `home`; `bodies`: of how many that are seen."""

    poses: int
    bodies: int
    pairs: tuple[PairErrors, ...]


@dataclass(slots=True)
class _Pair:
    """What is known of two bodies so far. `false`: the second from the first at the poses where it is."""

    reason: ExcludeReason | None
    false: list[Array] = field(default_factory=list)
    cuts: int = 0
    cuts_at_home: bool = False
    at_home: float = 0.0


class _Judge:
    """The bodies of a robot in MuJoCo, and what is seen of them."""

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
            # Which of what is seen belongs to the shapes that do not collide is not known.
            self.partly |= {(low, high)} if exclude.geoms else set()
        self.pairs: dict[tuple[int, int], _Pair] = {}

    def known(self, one: int, other: int) -> _Pair:
        if (one, other) not in self.pairs:
            self.pairs[one, other] = _Pair(self.reasons.get((one, other)))
        return self.pairs[one, other]

    def never(self, one: int, other: int) -> bool:
        """Whether two bodies are next to each other: their contact means nothing."""
        return self.reasons.get((one, other)) == "Adjacent" or never_collide(self.model, one, other)

    def other_from(self, one: int, other: int) -> Array:
        return inverse(pose_of(self.data, one)) @ pose_of(self.data, other)

    def depths(self) -> dict[tuple[int, int], float]:
        """How deep [m] the colliders of each two bodies in contact are in each other."""
        mujoco.mj_collision(self.model, self.data)
        found: dict[tuple[int, int], float] = {}
        contacts = self.data.contact
        pairs = np.sort(self.of_geom[contacts.geom.reshape(-1, 2)], axis=1)
        for (one, other), gap in zip(pairs.tolist(), contacts.dist.tolist(), strict=True):
            if 0 <= one != other:
                found[one, other] = max(-gap, found.get((one, other), -np.inf))
        return found

    def meeting(self) -> list[tuple[int, int]]:
        """The pairs of bodies whose boxes meet."""
        turned = self.data.xmat[self.bodies].reshape(-1, 3, 3)
        middles = self.data.xpos[self.bodies] + np.einsum("nij,nj->ni", turned, self.middles)
        halves = np.einsum("nij,nj->ni", np.abs(turned), self.halves)
        # The bodies are sorted, and so are the pairs.
        pairs = self.bodies[meeting_boxes(middles - halves, middles + halves)].tolist()
        return [(one, other) for one, other in pairs]

    def touching(self, one: int, other: int) -> bool:
        """Whether colliders of two bodies touch that may not be in contact."""
        return any(
            mujoco.mj_geomDistance(self.model, self.data, a, b, 2.0 * TOUCH, None) <= TOUCH
            for a in self.solid[one]
            for b in self.solid[other]
        )

    def look(self, *, at_home: bool) -> None:
        """Judges the pose that the data are at."""
        depths = self.depths()
        for (one, other), depth in depths.items():
            least, apart = (HOME_DEEP, HOME_APART) if at_home else (DEEP, DEEP)
            if depth <= least or self.never(one, other):
                continue
            pose = self.other_from(one, other)
            if not self.surfaces.near(one, other, pose, apart):
                pair = self.known(one, other)
                if at_home:
                    pair.at_home = depth
                else:
                    pair.false.append(pose)
        for one, other in self.meeting():
            if depths.get((one, other), -np.inf) >= -TOUCH or (one, other) in self.partly:
                continue
            if self.never(one, other):
                continue
            if not self.surfaces.near(one, other, self.other_from(one, other), 0.0):
                continue
            reason = self.reasons.get((one, other))
            if reason is not None or not self.touching(one, other):
                pair = self.known(one, other)
                pair.cuts_at_home |= at_home
                pair.cuts += not at_home


def contact_errors(compiled: CompiledModel, poses: int, salt: str = SALT) -> ContactErrors:
    """The pairs of bodies with false or missed contacts, at seeded poses within the limits with loops closed.

    Pairs that are next to each other never collide, and are not judged. Those that are excluded because they
    are in each other in every pose are missed where what is seen of them is not, and cuts in some.
    """
    judge, robot = _Judge(compiled), compiled.robot
    start = home(robot)
    values = sampled_poses(robot, poses, REACH, start, salt) if robot.dofs else {}
    count = count_of(values) if values else 0
    for row in range(-1, count):
        q = start if row < 0 else {name: _value(every[row]) for name, every in values.items()}
        set_values(judge.model, judge.data, robot, q, urdf=False)
        judge.look(at_home=row < 0)
    found = []
    for bodies, pair in sorted(judge.pairs.items()):
        false = judge.surfaces.outside(*bodies, pair.false)
        always = pair.reason == "Always" and (pair.cuts_at_home or pair.cuts == count)
        missed = 0 if always else pair.cuts
        if false or missed or pair.at_home:
            apart = judge.surfaces.furthest(*bodies, false) if false else 0.0
            found.append(PairErrors(bodies, len(false), missed, apart, pair.at_home, pair.reason))
    return ContactErrors(count, len(judge.bodies), tuple(found))


def _is_judged(link: Link) -> bool:
    """Not where something of a link collides that is not drawn, and nothing is drawn in its place."""
    parts = [part for part in link.parts if part.mesh is not None]
    solid = any(not part.seen for part in parts) or any(not shape.visual for shape in link.shapes)
    seen = any(not part.collides for part in parts) or any(not shape.collision for shape in link.shapes)
    return seen or not solid


def _is_bare(compiled: CompiledModel, body: int) -> bool:
    """Whether a body without colliders is meant to have none."""
    return compiled.robot.mjcf is not None or asked_bare(compiled, compiled.model.body(body).name)


def _value(value: Any) -> Any:
    return float(value) if np.ndim(value) == 0 else tuple(map(float, value))


def never_collide(model: Any, one: int, other: int) -> bool:
    """Whether MuJoCo leaves two bodies out by itself, whatever the file says of contact: one rigid body, and
    parent and child where neither is fixed to the world."""
    welds = [int(model.body_weldid[body]) for body in (one, other)]
    if welds[0] == welds[1] or model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_FILTERPARENT:
        return welds[0] == welds[1]
    above = [int(model.body_weldid[model.body_parentid[weld]]) for weld in welds]
    return all(welds) and (welds[0] == above[1] or welds[1] == above[0])
