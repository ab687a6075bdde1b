"""Finds contacts of a robot with itself that differ from those of its visual shapes, over poses within its
limits.

A contact is *false* if the colliders of two bodies overlap by more than `MIN_FALSE_DEPTH` while their visual
shapes are more than `MIN_FALSE_DISTANCE` apart, neither inside the other; at `home`, the limits are
`MIN_HOME_FALSE_DEPTH` and `MIN_HOME_FALSE_DISTANCE`, and one shape may be inside the other. A contact is
*missed* if the visual shapes intersect and the colliders do not touch. MuJoCo decides what collides, and the
visual shapes are those of the file, so the result does not depend on how the colliders were made.
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

MIN_FALSE_DEPTH = 2e-3
"""Depth [m] above which the contact of two colliders can be false."""

MIN_FALSE_DISTANCE = 2e-3
"""Distance [m] of visual shapes above which a contact is false; nearer shapes are taken to touch."""

TOUCH_DISTANCE = 1e-4
"""Distance [m] within which colliders touch: faces that slide on each other must touch, also in single
precision."""

MIN_HOME_FALSE_DEPTH = 1e-5
"""Depth [m] above which a contact can be false at `home`: a smaller depth is a mere touch."""

MIN_HOME_FALSE_DISTANCE = 2e-4
"""Distance [m] of visual shapes above which a contact is false at `home`: nearer shapes may touch in CAD,
since meshes deviate by as much."""

SLIDE_TRAVEL = 0.5
"""Travel [m] of slides without limits."""

POSES_SALT = "contacts that others than the maker of colliders see"
"""Seed of the sampled poses, which differ from those at which colliders are made."""


@dataclass(frozen=True, slots=True)
class PairErrors:
    """Two bodies whose contact differs from that of their visual shapes."""

    bodies: tuple[int, int]
    """The indices of the bodies in the model."""
    false_count: int
    """Number of sampled poses with a false contact, `home` not counted."""
    missed_count: int
    """Number of sampled poses with a missed contact, `home` not counted."""
    max_distance: float
    """The largest distance [m] of the visual shapes over the poses of `false_count`; 0 without any."""
    home_depth: float
    """The depth [m] of a false contact at `home`; 0 if there is none."""
    reason: ExcludeReason | None
    """Why the pair is excluded from contact; None if it is not excluded."""


@dataclass(frozen=True, slots=True)
class ContactErrors:
    """The contact errors of a robot."""

    pose_count: int
    """Number of sampled poses, `home` not counted."""
    body_count: int
    """Number of visible bodies that were judged."""
    pairs: tuple[PairErrors, ...]
    """The pairs with errors, in the order of their bodies."""


@dataclass(slots=True)
class _PairResults:
    """The results for two bodies so far."""

    reason: ExcludeReason | None
    """Why the pair is excluded from contact; None if it is not excluded."""
    false_poses: list[Array] = field(default_factory=list)
    """first_from_second (4, 4) of the bodies, for each sampled pose that may have a false contact."""
    missed_count: int = 0
    """Number of sampled poses with a missed contact."""
    is_missed_at_home: bool = False
    """Whether the contact is missed at `home`; this only explains an exclusion, see `contact_errors`."""
    home_depth: float = 0.0
    """The depth [m] of a false contact at `home`; 0 if there is none."""

    def add_false(self, first_from_second: Array, depth: float, *, at_home: bool) -> None:
        """Adds a pose (4, 4) with a false contact of this depth [m]."""
        if at_home:
            self.home_depth = depth
        else:
            self.false_poses.append(first_from_second)

    def add_missed(self, *, at_home: bool) -> None:
        """Adds a pose with a missed contact."""
        if at_home:
            self.is_missed_at_home = True
        else:
            self.missed_count += 1


class _ContactJudge:
    """Compares the contacts of a robot's colliders with those of its visual shapes, pose by pose.

    Bodies and geoms are indices in the model; in a pair of bodies, the lower index comes first. The pose is
    that of `data`.
    """

    def __init__(self, compiled: CompiledModel) -> None:
        self.model = compiled.model
        self.data = mujoco.MjData(self.model)
        body_of_link = {link.name: body_index(self.model, link.name) for link in compiled.robot.links}
        visuals, self.colliders = _judged_geoms(compiled, body_of_link)
        """Judged body → its geoms that are colliders, in the order of the bodies."""
        self.bodies = np.array(list(self.colliders), dtype=int)
        self.body_of_geom = np.full(self.model.ngeom, -1)
        """Judged body of each collider (ngeom,); -1 for other geoms."""
        for body, geoms in self.colliders.items():
            self.body_of_geom[geoms] = body
        self.surfaces = SeenSurfaces(self.model, visuals)
        boxes = np.array([self.surfaces.box(body) for body in self.colliders]).reshape(-1, 2, 3)
        self.box_centres, self.box_half_sizes = boxes.mean(axis=1), (boxes[:, 1] - boxes[:, 0]) / 2.0
        self.reasons: dict[tuple[int, int], ExcludeReason] = {}
        """Excluded pair of bodies → why it is excluded."""
        self.partly_excluded_pairs: set[tuple[int, int]] = set()
        """Pairs of bodies of which only some colliders are excluded."""
        for exclude in compiled.geometry.excludes if compiled.geometry else ():
            bodies = body_of_link.get(exclude.link_a, -1), body_of_link.get(exclude.link_b, -1)
            pair = min(bodies), max(bodies)
            self.reasons[pair] = exclude.reason
            if exclude.geoms:
                self.partly_excluded_pairs.add(pair)
        self.results: dict[tuple[int, int], _PairResults] = {}

    def results_to_complete(self, first: int, second: int) -> _PairResults:
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

    def contact_depths(self) -> dict[tuple[int, int], float]:
        """Returns, for each pair of bodies in contact, the depth [m] by which their colliders overlap."""
        mujoco.mj_collision(self.model, self.data)
        depths: dict[tuple[int, int], float] = {}
        contacts = self.data.contact
        pairs = np.sort(self.body_of_geom[contacts.geom.reshape(-1, 2)], axis=1)
        for (first, second), distance in zip(pairs.tolist(), contacts.dist.tolist(), strict=True):
            if 0 <= first != second:
                depths[first, second] = max(-distance, depths.get((first, second), -np.inf))
        return depths

    def pairs_with_meeting_boxes(self) -> list[tuple[int, int]]:
        """Returns the pairs of bodies whose boxes around their visual shapes meet."""
        rotations = self.data.xmat[self.bodies].reshape(-1, 3, 3)
        centres = self.data.xpos[self.bodies] + np.einsum("nij,nj->ni", rotations, self.box_centres)
        # Boxes along the world's axes, around the turned boxes.
        half_sizes = np.einsum("nij,nj->ni", np.abs(rotations), self.box_half_sizes)
        # The bodies are sorted, and so are the pairs.
        pairs = self.bodies[meeting_boxes(centres - half_sizes, centres + half_sizes)].tolist()
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

    def add_pose(self, *, at_home: bool) -> None:
        """Adds the false and missed contacts at the pose to the results. `at_home`: whether it is `home`."""
        depths = self.contact_depths()
        self._add_false(depths, at_home)
        self._add_missed(depths, at_home)

    def _add_false(self, depths: Mapping[tuple[int, int], float], at_home: bool) -> None:
        """Adds the false contacts among the `depths`, see `contact_depths`."""
        min_depth, min_distance = MIN_FALSE_DEPTH, MIN_FALSE_DISTANCE
        if at_home:
            min_depth, min_distance = MIN_HOME_FALSE_DEPTH, MIN_HOME_FALSE_DISTANCE
        for (first, second), depth in depths.items():
            if depth <= min_depth or self.are_neighbours(first, second):
                continue
            first_from_second = self.first_from_second(first, second)
            if not self.surfaces.near(first, second, first_from_second, min_distance):
                self.results_to_complete(first, second).add_false(first_from_second, depth, at_home=at_home)

    def _add_missed(self, depths: Mapping[tuple[int, int], float], at_home: bool) -> None:
        """Adds the missed contacts: visual shapes intersect, but `depths` has no contact of the colliders."""
        for first, second in self.pairs_with_meeting_boxes():
            is_in_contact = depths.get((first, second), -np.inf) >= -TOUCH_DISTANCE
            # Of a partly excluded pair, the visual shapes of the colliders that still collide are unknown.
            is_unknown = (first, second) in self.partly_excluded_pairs
            if is_in_contact or is_unknown or self.are_neighbours(first, second):
                continue
            if not self.surfaces.near(first, second, self.first_from_second(first, second), 0.0):
                continue
            # Excluded colliders do not touch in a simulation, wherever they are.
            is_excluded = self.reasons.get((first, second)) is not None
            if is_excluded or not self.are_touching(first, second):
                self.results_to_complete(first, second).add_missed(at_home=at_home)


def contact_errors(compiled: CompiledModel, max_poses: int, salt: str = POSES_SALT) -> ContactErrors:
    """Finds the pairs of bodies with false contacts, at `home` or at up to `max_poses` sampled poses, or with
    missed contacts at sampled poses. Loops are closed at all poses. `salt`: seed of the poses.

    Neighbours never collide, and are not judged. A pair that is excluded because it touches in every pose is
    missed only if its visual shapes are apart at `home` and in some sampled poses, but overlap in others.
    """
    judge, robot = _ContactJudge(compiled), compiled.robot
    start = home(robot)
    samples_by_dof = sampled_poses(robot, max_poses, SLIDE_TRAVEL, start, salt) if robot.dofs else {}
    pose_count = count_of(samples_by_dof) if samples_by_dof else 0
    set_values(judge.model, judge.data, robot, start, urdf=False)
    judge.add_pose(at_home=True)
    for row in range(pose_count):
        values = {name: _value(samples[row]) for name, samples in samples_by_dof.items()}
        set_values(judge.model, judge.data, robot, values, urdf=False)
        judge.add_pose(at_home=False)
    pairs = [
        _pair_errors(bodies, results, judge.surfaces, pose_count)
        for bodies, results in sorted(judge.results.items())
    ]
    wrong_pairs = [pair for pair in pairs if pair.false_count or pair.missed_count or pair.home_depth]
    return ContactErrors(pose_count, len(judge.bodies), tuple(wrong_pairs))


def _pair_errors(
    bodies: tuple[int, int], results: _PairResults, surfaces: SeenSurfaces, pose_count: int
) -> PairErrors:
    """Returns the errors of a pair; its counts and its depth may all be 0."""
    # A contact is not false if one visual shape is inside the other.
    false_poses = surfaces.outside(*bodies, results.false_poses)
    # Visual shapes that overlap at `home` or in all poses are the reason for the exclusion.
    explains_exclusion = results.is_missed_at_home or results.missed_count == pose_count
    missed_count = 0 if results.reason == "Always" and explains_exclusion else results.missed_count
    max_distance = surfaces.furthest(*bodies, false_poses) if false_poses else 0.0
    return PairErrors(
        bodies, len(false_poses), missed_count, max_distance, results.home_depth, results.reason
    )


def _judged_geoms(
    compiled: CompiledModel, body_of_link: Mapping[str, int]
) -> tuple[dict[int, list[int]], dict[int, list[int]]]:
    """Returns the visual geoms and the colliders of each judged body, in the order of the bodies."""
    comparable_bodies = {body_of_link[link.name] for link in compiled.robot.links if _is_comparable(link)}
    visuals, colliders = dict[int, list[int]](), dict[int, list[int]]()
    for body, (visual_geoms, colliding_geoms) in sorted(seen_and_solid(compiled.model).items()):
        if body not in comparable_bodies or not visual_geoms:
            continue
        if colliding_geoms or not _is_bare_on_purpose(compiled, body):
            visuals[body], colliders[body] = visual_geoms, colliding_geoms
    return visuals, colliders


def _is_comparable(link: Link) -> bool:
    """Tells whether a link's visual shapes can be compared with its colliders: all colliders are visible, or
    there are purely visual shapes in their place."""
    parts = [part for part in link.parts if part.mesh is not None]
    are_visible = [*(part.seen for part in parts), *(shape.visual for shape in link.shapes)]
    are_colliding = [*(part.collides for part in parts), *(shape.collision for shape in link.shapes)]
    return all(are_visible) or not all(are_colliding)


def _is_bare_on_purpose(compiled: CompiledModel, body: int) -> bool:
    """Tells whether the MJCF source or the configuration leaves a body without colliders."""
    return compiled.robot.mjcf is not None or is_bare_by_choice(compiled, compiled.model.body(body).name)


def _value(value: Any) -> float | tuple[float, ...]:
    """Returns the value of a dof, which is a number or an array (n,), as a number or a tuple."""
    return float(value) if np.ndim(value) == 0 else tuple(map(float, value))


def never_collide(model: Any, first: int, second: int) -> bool:
    """Tells whether MuJoCo never lets two bodies collide, whatever contact the file allows.

    It never lets bodies collide that are fixed to each other; nor, unless the flag `filterparent` is
    disabled, a parent and its child if neither is fixed to the world.
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
