"""Represents parts as bodies of 1 kg, to compare how two bodies distribute their mass."""

import math
from functools import cached_property

import numpy as np

from linkwright.stages.graph.onshape.assembly import Assembly, Path
from linkwright.stages.graph.onshape.mass.mass_estimate import shapes_of
from linkwright.stages.graph.onshape.mass.part_mass import SHEET, PartKey, PartMass, part_key, read_masses
from linkwright.stages.robot.bundle import OnshapeBundle
from linkwright.stages.robot.dynamics.inertia import merged, moved, scaled
from linkwright.stages.robot.model.robot import Array, Inertial

COM_TOLERANCE = 1e-3
"""Largest distance between centres of mass that count as equal, in radii of gyration."""

INERTIA_TOLERANCE = 1e-2
"""Largest difference between the entries of tensors of inertia that count as equal, as a share of the
trace."""


class PartSolids:
    """The parts of an assembly as bodies of 1 kg, by CAD's mass properties or else by their triangles."""

    def __init__(self, assembly: Assembly, bundle: OnshapeBundle) -> None:
        self.assembly, self.bundle = assembly, bundle
        self._bodies: dict[Path, Inertial | None] = {}

    def body(self, path: Path) -> Inertial | None:
        """Returns the parts at or below an occurrence as a single body of 1 kg, in the world's frame. The
        parts have equal shares of the mass. Returns None if a part has neither mass properties nor triangles,
        or if there are no parts."""
        if path not in self._bodies:
            bodies = [self._part_body(part) for part in self.part_paths(path)]
            known_bodies = [body for body in bodies if body is not None]
            is_complete = bool(known_bodies) and len(known_bodies) == len(bodies)
            self._bodies[path] = scaled(merged(known_bodies), 1.0) if is_complete else None
        return self._bodies[path]

    def part_paths(self, path: Path) -> list[Path]:
        """Returns the paths of the parts at or below a path, sorted."""
        return self._parts_by_path.get(path, [])

    @cached_property
    def _parts_by_path(self) -> dict[Path, list[Path]]:
        """Path of an occurrence → the paths of the parts at or below it."""
        parts_below: dict[Path, list[Path]] = {}
        for part in self.assembly.parts:
            for depth in range(1, len(part.path) + 1):
                parts_below.setdefault(part.path[:depth], []).append(part.path)
        return parts_below

    @cached_property
    def _masses(self) -> dict[PartKey, PartMass]:
        return read_masses(self.bundle)

    def _part_body(self, path: Path) -> Inertial | None:
        """Returns a part as a body of 1 kg, in the world's frame; None if it has neither mass properties nor
        triangles."""
        key = part_key(self.assembly.occurrences[path].record)
        part_mass = self._masses.get(key)
        if part_mass and part_mass.inertial.mass > 0:
            body = scaled(part_mass.inertial, 1.0)
        else:
            # `shapes_of` takes None for a sheet, and 0 for an unknown volume.
            volume: float | None = part_mass.volume if part_mass else 0.0
            if self.assembly.body_types.get(key) == SHEET:
                volume = None
            shape = shapes_of(self.bundle, [(key, volume)]).get(key)
            if shape is None:
                return None
            body = shape.inertial
        return moved(body, self.assembly.world_from_path(path))


def is_moved_body(image: Inertial, body: Inertial, motion: Array) -> bool:
    """Tells whether `image` is `body` under `motion` (4, 4), which may reflect, as far as their distributions
    of mass show. Both bodies have 1 kg."""
    moved_body = moved(body, motion)
    com_distance = np.linalg.norm(moved_body.com - image.com)
    inertia_difference = np.abs(moved_body.inertia - image.inertia).max()
    return bool(
        com_distance <= COM_TOLERANCE * gyration_radius(body)
        and inertia_difference <= INERTIA_TOLERANCE * np.trace(body.inertia)
    )


def gyration_radius(body: Inertial) -> float:
    """Returns the radius of gyration [m] of a body of 1 kg about its centre of mass: r² = ½ tr I."""
    return math.sqrt(np.trace(body.inertia) / 2)
