"""Compares the distribution of mass in parts, and tells whether two bodies are mirror images."""

import math
from functools import cached_property

import numpy as np

from linkwright.stages.graph.onshape.assembly import Assembly, Path
from linkwright.stages.graph.onshape.mass.mass_estimate import shapes_of
from linkwright.stages.graph.onshape.mass.part_mass import SHEET, PartKey, Weight, part_key, read_masses
from linkwright.stages.robot.bundle import OnshapeBundle
from linkwright.stages.robot.dynamics.inertia import merged, moved, scaled
from linkwright.stages.robot.model.robot import Array, Inertial

COM_TOLERANCE = 1e-3
"""Largest distance of equal centres of mass, in radii of gyration."""

INERTIA_TOLERANCE = 1e-2
"""Largest difference of equal tensors of inertia, as a share of the trace."""


class PartSolids:
    """The parts of an assembly as bodies of 1 kg: by CAD's mass properties, else by their triangles."""

    def __init__(self, assembly: Assembly, bundle: OnshapeBundle) -> None:
        self.assembly, self.bundle = assembly, bundle
        self._bodies: dict[Path, Inertial | None] = {}

    def body(self, path: Path) -> Inertial | None:
        """Returns all parts at or below an occurrence as one body of 1 kg in the world, each part of the same
        mass; None where any of them is unknown."""
        if path not in self._bodies:
            bodies = [self._part(part) for part in self.parts(path)]
            shaped = [body for body in bodies if body is not None]
            is_complete = bool(shaped) and len(shaped) == len(bodies)
            self._bodies[path] = scaled(merged(shaped), 1.0) if is_complete else None
        return self._bodies[path]

    def parts(self, path: Path) -> list[Path]:
        """Returns the part occurrences at or below a path, sorted."""
        return self._parts_by_path.get(path, [])

    @cached_property
    def _parts_by_path(self) -> dict[Path, list[Path]]:
        parts_below: dict[Path, list[Path]] = {}
        for part in self.assembly.parts:
            for depth in range(1, len(part.path) + 1):
                parts_below.setdefault(part.path[:depth], []).append(part.path)
        return parts_below

    @cached_property
    def _masses(self) -> dict[PartKey, Weight]:
        return read_masses(self.bundle)

    def _part(self, path: Path) -> Inertial | None:
        key = part_key(self.assembly.occurrences[path].record)
        weight = self._masses.get(key)
        if weight and weight.inertial.mass > 0:
            body = scaled(weight.inertial, 1.0)
        else:
            sheet = self.assembly.body_types.get(key) == SHEET
            volume = None if sheet else weight.volume if weight else 0.0
            shape = shapes_of(self.bundle, [(key, volume)]).get(key)
            if shape is None:
                return None
            body = shape.inertial
        return moved(body, self.assembly.world_from_path(path))


def is_image(first: Inertial, second: Inertial, motion: Array) -> bool:
    """Returns whether `motion` (4, 4), which may reflect, takes the first of two bodies of 1 kg to the
    second."""
    image = moved(first, motion)
    is_centred = np.linalg.norm(image.com - second.com) <= COM_TOLERANCE * gyration(first)
    difference = np.abs(image.inertia - second.inertia).max()
    return bool(is_centred and difference <= INERTIA_TOLERANCE * np.trace(first.inertia))


def gyration(body: Inertial) -> float:
    """Returns the radius of gyration [m] of a body of 1 kg about its centre of mass: r² = ½ tr I."""
    return math.sqrt(np.trace(body.inertia) / 2)
