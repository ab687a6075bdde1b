"""Finds the motion or reflection that takes the seed of a pattern or mirror to its copy.

Onshape mirrors an instance by a transform, or "using a new instance of an existing or newly created part"
(its help, "Assembly Mirror"). Such a part is the mirror image of the seed's; a sub-assembly then consists of
such parts. The definition has no plane. So it is the plane by which another copy of the same mirror is its
seed's reflection, or the plane midway between the centres of mass of a seed and its copy; and it counts only
if it takes each part of the seed to a part of the copy, as far as their mass distributions show.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from linkwright.stages.graph.globs import entries_of
from linkwright.stages.graph.onshape.assembly import Assembly, Path, Pattern
from linkwright.stages.graph.onshape.mass.part_solids import PartSolids, gyration_radius, is_moved_body
from linkwright.stages.graph.section import MirrorSection
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.dynamics.inertia import moved
from linkwright.stages.robot.model.poses import from_parts, inverse
from linkwright.stages.robot.model.robot import Array, frozen
from linkwright.stages.robot.text.globs import exact_glob, name_list

MIN_CENTRE_DISTANCE = 0.01
"""Smallest distance of the centres of mass of a seed and its copy, in radii of gyration: the line between
nearer centres has no certain direction."""

MAX_PLANE_PAIRS = 8
"""Largest number of pairs whose middle planes are tried: the pairs whose centres are farthest apart."""

PART_FIELDS = ("type", "documentId", "elementId", "partId")
"""The fields of an instance that identify its part or sub-assembly."""

Pair = tuple[Path, Path]
"""A seed and its copy."""

Plane = tuple[Array, Array]
"""A normal and a point (3,)."""


@dataclass(frozen=True, slots=True, eq=False)
class Image:
    """A copy's relation to its seed."""

    motion: Array
    """Motion (4, 4) of the world at the saved pose from the seed to the copy; it may reflect."""
    by_transform: bool = False
    """Whether the motion follows from the transforms of both instances, so that a frame in the seed is the
    same frame in the copy."""
    leaves: Mapping[Path, Path] | None = None
    """Path of each part of the seed → path of its image in the copy; None if the copy has the same parts."""

    @property
    def reflects(self) -> bool:
        """Whether the motion reflects."""
        return bool(np.linalg.det(self.motion[:3, :3]) < 0)


class MirrorPlanes:
    """Finds the images of seeds. `sections`: the key `mirrors`, the user's planes by globs."""

    def __init__(
        self, assembly: Assembly, solids: PartSolids, sections: Mapping[str, MirrorSection], log: Diagnostics
    ) -> None:
        self.assembly, self.solids, self.log = assembly, solids, log
        titles = sorted({pattern.title for pattern in assembly.patterns if pattern.mirrors})
        entries = entries_of([{title} for title in titles], sections, "mirrors", "mirror", log)
        planes = list(sections.values())
        self.user_planes = {
            title: planes[indices[-1]] for title, indices in zip(titles, entries, strict=True) if indices
        }

    def images(self, pattern: Pattern) -> dict[Path, Image]:
        """Returns the known images, by copy. Reports W-PATTERN for the copies whose images are unknown;
        I-MIRROR for those that are made of mirror-image parts."""
        pairs = [
            (seed, copy)
            for seed, copies in pattern.copies.items()
            for copy in copies
            if {seed, copy} <= self.assembly.occurrences.keys()
        ]
        images = {copy: self._by_transform(seed, copy) for seed, copy in pairs if self._same_part(seed, copy)}
        doubtful = [pair for pair in pairs if pair[1] not in images or not images[pair[1]].reflects]
        if pattern.mirrors and doubtful:
            images |= self._by_reflection(pattern, pairs, doubtful, images)
        for seed, copy in pairs:
            if copy not in images:
                self._report_unknown(pattern, seed, copy)
        return images

    def _by_reflection(
        self,
        pattern: Pattern,
        pairs: Sequence[Pair],
        doubtful: Sequence[Pair],
        known_images: Mapping[Path, Image],
    ) -> dict[Path, Image]:
        """Returns the images of `doubtful` copies by the mirror's reflection, where this takes the seeds to
        them."""
        reflection = self._reflection(pattern, pairs, known_images)
        if reflection is None:
            return {}
        images: dict[Path, Image] = {}
        for seed, copy in doubtful:
            leaves = self._leaves(seed, copy, reflection)
            if leaves is None and copy not in known_images and pattern.title in self.user_planes:
                leaves = self._user_image(pattern, seed, copy, reflection)
            if leaves is not None:
                images[copy] = Image(reflection, leaves=None if self._same_part(seed, copy) else leaves)
        rebuilt = [copy for copy, image in images.items() if image.leaves]
        if rebuilt:
            titles = name_list(self.assembly.occurrences[copy].title for copy in rebuilt)
            message = (
                f"taken for the mirror images of their seeds, at the plane {_plane_of(reflection)}: {titles}"
            )
            self.log.report("I-MIRROR", message, pattern.title)
        return images

    def _by_transform(self, seed: Path, copy: Path) -> Image:
        world_from_copy, world_from_seed = map(self.assembly.world_from_path, (copy, seed))
        return Image(frozen(world_from_copy @ inverse(world_from_seed)), by_transform=True)

    def _same_part(self, seed: Path, copy: Path) -> bool:
        """Tells whether both are instances of the same part, or of the same sub-assembly."""
        first, second = (self.assembly.occurrences[path].record for path in (seed, copy))
        return all(first.get(key) == second.get(key) for key in PART_FIELDS)

    def _reflection(
        self, pattern: Pattern, pairs: Sequence[Pair], known_images: Mapping[Path, Image]
    ) -> Array | None:
        """Returns the mirror's reflection (4, 4) of the world. Its plane is the user's; else that of a copy
        whose transform reflects; else the plane that explains the most copies."""
        world_from_owner = self.assembly.world_from_path(pattern.owner)

        def in_world(plane: Plane) -> Array:
            return frozen(world_from_owner @ _reflection_at(plane) @ inverse(world_from_owner))

        if pattern.title in self.user_planes:
            user_plane = self.user_planes[pattern.title]
            return in_world((np.array(user_plane.normal), np.array(user_plane.xyz)))
        for _, copy in pairs:
            if copy in known_images and known_images[copy].reflects:
                return known_images[copy].motion
        middle_planes = [(*middle, pair) for pair in pairs if (middle := self._middle(pattern.owner, pair))]
        middle_planes = sorted(middle_planes, key=lambda middle: -middle[1])[:MAX_PLANE_PAIRS]
        # The planes of the assembly's own axes come first, since they are exact.
        planes = [(axis, np.zeros(3)) for axis in np.eye(3)] + [plane for plane, _, _ in middle_planes]
        candidates = [in_world(plane) for plane in planes]
        explained = [
            sum(self._leaves(*pair, candidate) is not None for _, _, pair in middle_planes)
            for candidate in candidates
        ]
        best = max(explained)
        return candidates[explained.index(best)] if best else None

    def _middle(self, owner: Path, pair: Pair) -> tuple[Plane, float] | None:
        """Returns the plane midway between the centres of mass of a seed and its copy, in the frame of
        `owner`, and the distance [m] of the centres; None if a centre is unknown, or if they are too near."""
        bodies = [self.solids.body(path) for path in pair]
        if bodies[0] is None or bodies[1] is None:
            return None
        owner_from_world = inverse(self.assembly.world_from_path(owner))
        first, second = (moved(body, owner_from_world).com for body in bodies if body)
        distance = float(np.linalg.norm(second - first))
        if distance <= MIN_CENTRE_DISTANCE * gyration_radius(bodies[0]):
            return None
        return (second - first, (first + second) / 2), distance

    def _leaves(self, seed: Path, copy: Path, reflection: Array) -> dict[Path, Path] | None:
        """Returns the parts of a seed → those of its copy; None unless `reflection` (4, 4) takes each to
        another."""
        parts, images = (list(self.solids.part_paths(path)) for path in (seed, copy))
        if self._same_part(seed, copy):
            pairs = {part: copy + part[len(seed) :] for part in parts}
            return pairs if all(self._is_image(*pair, reflection) for pair in pairs.items()) else None
        leaves: dict[Path, Path] = {}
        for part in parts:
            image = next((path for path in images if self._is_image(part, path, reflection)), None)
            if image is None:
                return None
            images.remove(image)
            leaves[part] = image
        return None if images else leaves

    def _is_image(self, part: Path, image: Path, reflection: Array) -> bool:
        first, second = self.solids.body(part), self.solids.body(image)
        return first is not None and second is not None and is_moved_body(second, first, reflection)

    def _user_image(
        self, pattern: Pattern, seed: Path, copy: Path, reflection: Array
    ) -> dict[Path, Path] | None:
        """Takes the copy of a part for its seed's image because the user says so, and reports that it does
        not look like it (W-MIRROR-PLANE). Returns None for a sub-assembly, whose parts would remain
        unknown."""
        occurrences = self.assembly.occurrences
        if not (occurrences[seed].is_part and occurrences[copy].is_part):
            return None
        first, second = self.solids.body(seed), self.solids.body(copy)
        if first is not None and second is not None:
            distance = float(np.linalg.norm(moved(first, reflection).com - second.com))
            message = (
                f"{occurrences[copy].title} is not the mirror image of {occurrences[seed].title} at the "
                f"plane in `mirrors`: their centres of mass are {1000 * distance:.3g} mm apart there"
            )
            self.log.report("W-MIRROR-PLANE", message, pattern.title, "check the plane, and the part")
        return {seed: copy}

    def _report_unknown(self, pattern: Pattern, seed: Path, copy: Path) -> None:
        """Reports W-PATTERN for a copy that is made of other parts than its seed, with the YAML for the
        plane."""
        occurrence, first = self.assembly.occurrences[copy], self.assembly.occurrences[seed]
        kind = "part" if occurrence.is_part else "sub-assembly"
        message = f"{occurrence.title} is not an instance of the same {kind} as its seed {first.title}"
        hint = "mate the copy itself"
        if pattern.mirrors:
            message += ", and does not show that it is its mirror image"
        if pattern.mirrors and occurrence.is_part:
            middle = self._middle(pattern.owner, (seed, copy))
            plane = _yaml(*middle[0]) if middle else _yaml(np.array([0.0, 1.0, 0.0]), np.zeros(3))
            where = "here midway between them" if middle else "here an example"
            name = json.dumps(exact_glob(pattern.title), ensure_ascii=False)
            hint += f"; or give the plane, in its assembly's frame ({where}): mirrors: {{{name}: {plane}}}"
        message += ": the seed's mates cannot be copied to it"
        self.log.report("W-PATTERN", message, pattern.title, hint)


def _reflection_at(plane: Plane) -> Array:
    """Returns the reflection (4, 4) at a plane: x − 2 n nᵀ (x − p), with n its unit normal."""
    normal, point = plane
    twice_projection = 2 * np.outer(normal, normal) / (normal @ normal)
    return from_parts(np.eye(3) - twice_projection, twice_projection @ point)


def _plane_of(reflection: Array) -> str:
    """Returns the plane of a reflection (4, 4), as YAML: n nᵀ = ½ (1 − R), and its nearest point to the
    origin."""
    projection = (np.eye(3) - reflection[:3, :3]) / 2
    normal = projection[:, np.abs(projection).max(axis=0).argmax()]
    return _yaml(normal, reflection[:3, 3] / 2)


def _yaml(normal: Array, point: Array) -> str:
    texts = [
        ", ".join(f"{number + 0.0:.6g}" for number in np.round(vector, 9) + 0.0)
        for vector in (normal / np.linalg.norm(normal), point)
    ]
    return "{{normal: [{}], xyz: [{}]}}".format(*texts)
