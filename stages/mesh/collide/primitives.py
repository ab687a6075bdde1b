"""Converts primitives (boxes, spheres, cylinders, capsules) to shapes of a `Geometry`."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from linkwright.stages.formats.meshes.surface import Surface
from linkwright.stages.mesh.collide.collision import Collider
from linkwright.stages.mesh.files import mesh_file
from linkwright.stages.mesh.files.mesh_file import MeshFile
from linkwright.stages.mesh.surfaces.convex_hull import convex_hull
from linkwright.stages.robot.dynamics.inertia import primitive_volume
from linkwright.stages.robot.model.geom_form import PLAIN
from linkwright.stages.robot.model.geometry import NEUTRAL, Colour, Role, Shape
from linkwright.stages.robot.model.robot import Link, Part, Primitive
from linkwright.stages.targets.engines import ShapeLimits


def shapes(link: Link) -> Iterator[Shape]:
    """Yields the shapes of a link's primitives: of each the collider first, then the visual. The form of an
    MJCF geom goes to the collider, or to the visual if there is no collider."""
    for primitive in link.shapes:
        if primitive.collision:
            yield replace(collider(link.name, primitive), form=primitive.form)
        if primitive.visual:
            shape = _shape(link.name, "visual", primitive, primitive.colour or NEUTRAL)
            yield shape if primitive.collision else replace(shape, form=primitive.form)


PRISM_SIDES = 16
"""Number of sides of the prism that replaces a cylinder: every engine takes as many vertices."""

_STEP = 2 * math.pi / PRISM_SIDES

PRISM_GROWTH = math.sqrt(_STEP / math.sin(_STEP))
"""Distance of the prism's corners from the axis, in radii of the cylinder. Equal volumes need equal areas,
and a regular polygon with n corners at a distance R has the area n/2 R² sin(2π/n)."""


def prism(cylinder: Primitive) -> Surface | None:
    """Returns a prism with a cylinder's length and volume, in the link's frame; None if it is too flat."""
    radius, length = cylinder.size[0] * PRISM_GROWTH, cylinder.size[1]
    ends = (-length / 2, length / 2)
    turns = [_STEP * corner for corner in range(PRISM_SIDES)]
    corners = [[radius * math.cos(turn), radius * math.sin(turn), end] for end in ends for turn in turns]
    pose = cylinder.link_from_shape
    return convex_hull(np.array(corners) @ pose[:3, :3].T + pose[:3, 3])


def engine_solid(solid: Collider, limits: ShapeLimits) -> Collider:
    """Returns a mesh or primitive as it is, but a prism of equal volume for a cylinder that a target cannot
    collide."""
    if isinstance(solid, MeshFile) or solid.kind != "cylinder" or "cylinder" not in limits.excluded_kinds:
        return solid
    surface = prism(solid)
    return solid if surface is None else mesh_file.collider(surface)


def replacement_mesh(shape: Shape, limits: ShapeLimits) -> MeshFile | None:
    """Returns the mesh that replaces a primitive of the link itself; None if the primitive stays."""
    if shape.role == "visual" or shape.primitive is None:
        return None
    solid = engine_solid(shape.primitive, limits)
    return solid if isinstance(solid, MeshFile) else None


def with_form(shape: Shape, parts: Sequence[Part], limits: ShapeLimits) -> Shape:
    """Returns a collider with the form of its part's MJCF geom; the form is plain if several `parts` share
    the collider. A mesh of an ellipsoid also gets the ellipsoid, if all targets can collide it."""
    form = parts[0].form if len(parts) == 1 else PLAIN
    if not form.ellipsoid or "ellipsoid" in limits.excluded_kinds:
        return replace(shape, form=form)
    ellipsoid = Primitive("ellipsoid", form.ellipsoid, parts[0].link_from_part)
    return replace(shape, form=form, ellipsoid=ellipsoid)


def collider(link: str, primitive: Primitive) -> Shape:
    """Returns a primitive as a collider of a link."""
    return _shape(link, "collision", primitive, None)


def _shape(link: str, role: Role, primitive: Primitive, colour: Colour | None) -> Shape:
    volume = primitive_volume(primitive.kind, primitive.size)
    return Shape(link, role, None, colour, 0, 0, _area(primitive), volume, primitive)


def _area(primitive: Primitive) -> float:
    """Returns the surface area [m²]."""
    if primitive.kind == "box":
        x, y, z = primitive.size
        return 2 * (x * y + y * z + z * x)
    radius = primitive.size[0]
    ball = 4 * math.pi * radius**2
    if primitive.kind == "sphere":
        return ball
    barrel = 2 * math.pi * radius * primitive.size[1]
    return barrel + (2 * math.pi * radius**2 if primitive.kind == "cylinder" else ball)
