"""Finds contacts of a robot with itself that differ from those of its visual shapes, over poses within its
limits.

A contact is *false* if the colliders of two bodies overlap by more than 2 mm while their visual shapes are
more than 2 mm apart, neither inside the other. At `home`, any overlap of colliders whose visual shapes are
apart is false. A contact is *missed* if the visual shapes intersect and the colliders do not touch. MuJoCo
decides what collides, and the visual shapes are the triangles and primitives of the file, so the result does
not depend on how the colliders were made.
"""

from collections.abc import Mapping
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
"""Depth [m] above which a contact can be false, and distance [m] within which visual shapes count as near."""

TOUCH_DISTANCE = 1e-4
"""Distance [m] within which colliders touch: faces that slide on each other must touch, also in single
precision."""

HOME_FALSE_DEPTH = 1e-5
HOME_MIN_DISTANCE = 2e-4
"""Limits at `home` [m]. Smaller depths are mere touches. Nearer visual shapes may touch in CAD, since meshes
deviate from CAD by as much."""

SLIDE_TRAVEL = 0.5
"""Travel [m] of slides without limits."""

SALT = "contacts that others than the maker of colliders see"
"""Seed of the sampled poses, so that they differ from those at which colliders are made."""


@dataclass(frozen=True, slots=True)
class PairErrors:
    """Two bodies whose contact differs from that of their visual shapes."""

    bodies: tuple[int, int]
    """The indices of the bodies in the model."""

    false_count: int
    """Number of poses with a false contact."""

    missed_count: int
    """Number of poses with a missed contact."""

    max_distance: float
    """The largest distance [m] of the visual shapes at the false contacts; 0 without any."""

    home_depth: float
    """The depth [m] of a false contact at `home`; 0 without it."""

    reason: ExcludeReason | None
    """Why the pair is excluded from contact, if it is."""


@dataclass(frozen=True, slots=True)
class ContactErrors:
    """The contact errors of a robot."""

    pose_count: int
    """Number of sampled poses, `home` not counted."""

    body_count: int
    """Number of visible bodies that were judged."""

    pairs: tuple[PairErrors, ...]


@dataclass(slots=True)
class _PairResults:
    """The results for two bodies so far."""

    reason: ExcludeReason | None
    false_poses: list[Array] = field(default_factory=list)
    """first_from_second (4, 4) of the bodies, for each sampled pose with a false contact."""

    missed_count: int = 0
    """Number of sampled poses with a missed contact."""

    is_missed_at_home: bool = False
    home_depth: float = 0.0
    """The depth [m] of a false contact at `home`."""


class _Judge:
    """The bodies of a robot in MuJoCo, with their visual shapes and colliders, and the results so far.

    Bodies and geoms are indices in the model; in a pair of bodies, the lower index comes first.
    """

    def __init__(self, compiled: CompiledModel) -> None:
        self.model = compiled.model
        self.data = mujoco.MjData(self.model)
        body_of_link = {link.name: body_index(self.model, link.name) for link in compiled.robot.links}
        judged = {body_of_link[link.name] for link in compiled.robot.links if _is_judged(link)}
        visuals, colliders = dict[int, list[int]](), dict[int, list[int]]()
        for body, (visual_geoms, colliding_geoms) in seen_and_solid(self.model).items():
            if body not in judged or not visual_geoms:
                continue
            if colliding_geoms or not _is_bare_by_intent(compiled, body):
                visuals[body], colliders[body] = visual_geoms, colliding_geoms
        self.colliders = dict(sorted(colliders.items()))
        self.bodies = np.array(list(self.colliders), dtype=int)
        self.body_of_geom = np.full(self.model.ngeom, -1)
        for body, geoms in self.colliders.items():
            self.body_of_geom[geoms] = body
        self.surfaces = SeenSurfaces(self.model, visuals)
        boxes = np.array([self.surfaces.box(body) for body in self.colliders]).reshape(-1, 2, 3)
        self.box_centres, self.box_halves = boxes.mean(axis=1), (boxes[:, 1] - boxes[:, 0]) / 2.0
        self.reasons: dict[tuple[int, int], ExcludeReason] = {}
        self.partly_excluded: set[tuple[int, int]] = set()
        for exclude in compiled.geometry.excludes if compiled.geometry else ():
            ends = body_of_link.get(exclude.link_a, -1), body_of_link.get(exclude.link_b, -1)
            pair = min(ends), max(ends)
            self.reasons[pair] = exclude.reason
            # Which visual shapes belong to the shapes that do not collide is unknown.
            self.partly_excluded |= {pair} if exclude.geoms else set()
        self.results: dict[tuple[int, int], _PairResults] = {}

    def results_of(self, first: int, second: int) -> _PairResults:
        """Returns the results for two bodies, to be completed."""
        if (first, second) not in self.results:
            self.results[first, second] = _PairResults(self.reasons.get((first, second)))
        return self.results[first, second]

    def are_neighbours(self, first: int, second: int) -> bool:
        """Tells whether two bodies are neighbours, so that their contact means nothing."""
        return self.reasons.get((first, second)) == "Adjacent" or never_collide(self.model, first, second)

    def first_from_second(self, first: int, second: int) -> Array:
        """Returns the pose (4, 4) of the second body in the frame of the first."""
        return inverse(pose_of(self.data, first)) @ pose_of(self.data, second)

    def depths(self) -> dict[tuple[int, int], float]:
        """Returns, for each pair of bodies in contact, the depth [m] by which their colliders overlap."""
        mujoco.mj_collision(self.model, self.data)
        depths: dict[tuple[int, int], float] = {}
        contacts = self.data.contact
        pairs = np.sort(self.body_of_geom[contacts.geom.reshape(-1, 2)], axis=1)
        for (first, second), distance in zip(pairs.tolist(), contacts.dist.tolist(), strict=True):
            # -1 is a geom that is not a collider of a judged body.
            if 0 <= first != second:
                depths[first, second] = max(-distance, depths.get((first, second), -np.inf))
        return depths

    def pairs_with_meeting_boxes(self) -> list[tuple[int, int]]:
        """Returns the pairs of bodies whose boxes around their visual shapes meet."""
        rotations = self.data.xmat[self.bodies].reshape(-1, 3, 3)
        centres = self.data.xpos[self.bodies] + np.einsum("nij,nj->ni", rotations, self.box_centres)
        # Half sizes of the boxes along the world's axes around the turned boxes.
        halves = np.einsum("nij,nj->ni", np.abs(rotations), self.box_halves)
        # The bodies are sorted, and so are the pairs.
        pairs = self.bodies[meeting_boxes(centres - halves, centres + halves)].tolist()
        return [(first, second) for first, second in pairs]

    def are_touching(self, first: int, second: int) -> bool:
        """Tells whether colliders of two bodies touch, even if the bodies are excluded from contact."""
        max_distance = 2.0 * TOUCH_DISTANCE  # MuJoCo returns this distance for geoms that are further apart
        return any(
            mujoco.mj_geomDistance(self.model, self.data, geom, other_geom, max_distance, None)
            <= TOUCH_DISTANCE
            for geom in self.colliders[first]
            for other_geom in self.colliders[second]
        )

    def judge_pose(self, *, at_home: bool) -> None:
        """Adds the false and missed contacts at the pose of `data` to the results."""
        depths = self.depths()
        self._add_false(depths, at_home)
        self._add_missed(depths, at_home)

    def _add_false(self, depths: Mapping[tuple[int, int], float], at_home: bool) -> None:
        min_depth, min_distance = FALSE_DEPTH, FALSE_DEPTH
        if at_home:
            min_depth, min_distance = HOME_FALSE_DEPTH, HOME_MIN_DISTANCE
        for (first, second), depth in depths.items():
            if depth <= min_depth or self.are_neighbours(first, second):
                continue
            pose = self.first_from_second(first, second)
            if self.surfaces.near(first, second, pose, min_distance):
                continue
            results = self.results_of(first, second)
            if at_home:
                results.home_depth = depth
            else:
                results.false_poses.append(pose)

    def _add_missed(self, depths: Mapping[tuple[int, int], float], at_home: bool) -> None:
        for first, second in self.pairs_with_meeting_boxes():
            is_in_contact = depths.get((first, second), -np.inf) >= -TOUCH_DISTANCE
            if is_in_contact or (first, second) in self.partly_excluded or self.are_neighbours(first, second):
                continue
            if not self.surfaces.near(first, second, self.first_from_second(first, second), 0.0):
                continue
            # Excluded colliders do not touch in a simulation, wherever they are.
            is_excluded = self.reasons.get((first, second)) is not None
            if is_excluded or not self.are_touching(first, second):
                results = self.results_of(first, second)
                results.is_missed_at_home |= at_home
                results.missed_count += not at_home


def contact_errors(compiled: CompiledModel, max_poses: int, salt: str = SALT) -> ContactErrors:
    """Finds the pairs of bodies with false or missed contacts, at `home` and at up to `max_poses` sampled
    poses, at which loops are closed. `salt`: seed of the poses.

    Neighbours never collide, and are not judged. A pair that is excluded because it touches in every pose is
    missed only if its visual shapes overlap in some sampled poses, but neither in all of them nor at `home`.
    """
    judge, robot = _Judge(compiled), compiled.robot
    start = home(robot)
    values = sampled_poses(robot, max_poses, SLIDE_TRAVEL, start, salt) if robot.dofs else {}
    pose_count = count_of(values) if values else 0
    set_values(judge.model, judge.data, robot, start, urdf=False)
    judge.judge_pose(at_home=True)
    for row in range(pose_count):
        q = {name: _value(samples[row]) for name, samples in values.items()}
        set_values(judge.model, judge.data, robot, q, urdf=False)
        judge.judge_pose(at_home=False)
    errors = []
    for bodies, results in sorted(judge.results.items()):
        false_poses = judge.surfaces.outside(*bodies, results.false_poses)
        overlaps_always = results.is_missed_at_home or results.missed_count == pose_count
        missed_count = 0 if results.reason == "Always" and overlaps_always else results.missed_count
        if false_poses or missed_count or results.home_depth:
            max_distance = judge.surfaces.furthest(*bodies, false_poses) if false_poses else 0.0
            errors.append(
                PairErrors(
                    bodies, len(false_poses), missed_count, max_distance, results.home_depth, results.reason
                )
            )
    return ContactErrors(pose_count, len(judge.bodies), tuple(errors))


def _is_judged(link: Link) -> bool:
    """Tells whether a link's visual shapes can be compared with its colliders: all colliders are visible, or
    there are purely visual shapes in their place."""
    parts = [part for part in link.parts if part.mesh is not None]
    has_unseen_collider = any(not part.seen for part in parts) or any(
        not shape.visual for shape in link.shapes
    )
    has_visual_only = any(not part.collides for part in parts) or any(
        not shape.collision for shape in link.shapes
    )
    return has_visual_only or not has_unseen_collider


def _is_bare_by_intent(compiled: CompiledModel, body: int) -> bool:
    """Tells whether a body without colliders is intended to have none."""
    return compiled.robot.mjcf is not None or is_bare_by_choice(compiled, compiled.model.body(body).name)


def _value(value: Any) -> float | tuple[float, ...]:
    """Returns the value of a dof as a number or, from an array, as a tuple."""
    return float(value) if np.ndim(value) == 0 else tuple(map(float, value))


def never_collide(model: Any, first: int, second: int) -> bool:
    """Tells whether MuJoCo never lets two bodies collide, whatever contact the file allows.

    These are bodies that are fixed to each other; and, unless the flag `filterparent` is disabled, parent and
    child if neither is fixed to the world.
    """
    # A body's weld is the uppermost body to which it is fixed; 0 is the world.
    first_weld, second_weld = (int(model.body_weldid[body]) for body in (first, second))
    if first_weld == second_weld:
        return True
    if model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_FILTERPARENT or not (first_weld and second_weld):
        return False
    first_parent, second_parent = (
        int(model.body_weldid[model.body_parentid[weld]]) for weld in (first_weld, second_weld)
    )
    return first_weld == second_parent or second_weld == first_parent
