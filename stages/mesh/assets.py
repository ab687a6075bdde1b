"""Converts the mesh files of a robot to the format that `mesh.format` and `mesh.assets` select."""

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from linkwright.stages.formats.meshes.body_arrays import distinct
from linkwright.stages.formats.meshes.surface import Surface
from linkwright.stages.mesh.files import obj, stl
from linkwright.stages.mesh.visuals import textures
from linkwright.stages.robot.errors import Diagnostic
from linkwright.stages.robot.model.geometry import Shape
from linkwright.stages.robot.text.plural import count

if TYPE_CHECKING:
    from linkwright.stages.mesh.section import MeshSection


class Assets(NamedTuple):
    """The shapes of a robot, and the mesh files to which they refer."""

    shapes: tuple[Shape, ...]
    files: Mapping[str, bytes]
    """File name → content."""
    reports: Sequence[Diagnostic]


def convert_assets(
    shapes: Sequence[Shape], files: Mapping[str, bytes], section: "MeshSection", *, obj_only: bool = False
) -> Assets:
    """Converts mesh files to the configured format; returns the shapes with their new file names, the content
    of the files, and reports.

    All given meshes are named .stl, but the data of meshes with a texture are already OBJ, since an STL has
    no texture coordinates; these stay OBJ, and `files` has their images. Meshes with equal content become one
    file. Reports I-NO-ASSETS and W-NO-COLLIDER if meshes are left out. `obj_only`: whether a target reads no
    other format.
    """
    if section.assets == "none":
        primitives = tuple(shape for shape in shapes if shape.file is None)
        return Assets(primitives, {}, _omission_reports(shapes))
    converted_files = {name: data for name, data in files.items() if name.endswith(textures.IMAGE_SUFFIX)}
    shared_names = _first_names(shapes, files)
    named_shapes = []
    for shape in shapes:
        if shape.file is None:
            named_shapes.append(shape)
            continue
        data = files[shape.file]
        name = shared_names[_sharing_key(shape, data)]
        if shape.texture is not None:
            name = _obj_name(name)
            if name not in converted_files:
                converted_files |= textures.with_material_files(shape, name, data)
        elif obj_only or section.format == "obj":
            name = _obj_name(name)
            if name not in converted_files:
                converted_files[name] = obj.write(surface(data))
        else:
            converted_files[name] = data
        named_shapes.append(replace(shape, file=name))
    return Assets(tuple(named_shapes), dict(sorted(converted_files.items())), ())


def _first_names(shapes: Sequence[Shape], files: Mapping[str, bytes]) -> dict[Hashable, str]:
    """Maps each sharing key to the file name of its first mesh, in the order of the links, with visual meshes
    before colliders."""
    order = {link: index for index, link in enumerate(dict.fromkeys(shape.link for shape in shapes))}
    names: dict[Hashable, str] = {}
    for shape in sorted(shapes, key=lambda shape: (order[shape.link], shape.role == "collision")):
        if shape.file is not None:
            names.setdefault(_sharing_key(shape, files[shape.file]), shape.file)
    return names


def _sharing_key(shape: Shape, data: bytes) -> Hashable:
    """Returns a key that is equal for shapes that can share a mesh file and its material."""
    return (data, shape.texture, shape.colour) if shape.texture is not None else data


def surface(data: bytes) -> Surface:
    """Reads a surface from an STL file that `stl.write` made; its vertices are sorted and distinct."""
    corners = stl.read(data)
    vertices, index = distinct(corners.reshape(-1, 3))
    return Surface(vertices, index.reshape(-1, 3).astype(np.int64))


def _obj_name(name: str) -> str:
    return f"{name.removesuffix('.stl')}.obj"


def _omission_reports(shapes: Sequence[Shape]) -> list[Diagnostic]:
    meshes = [shape for shape in shapes if shape.file is not None]
    visuals = sum(shape.role == "visual" for shape in meshes)
    colliders = len(meshes) - visuals
    problems = []
    if meshes:
        problems.append(
            Diagnostic(
                "I-NO-ASSETS",
                f"{count(visuals, 'visual mesh', 'visual meshes')} and {count(colliders, 'collider')} that "
                "are meshes are left out; masses and primitives stay",
                "mesh.assets",
                "mesh.assets=files writes them",
            )
        )
    if not any(shape.role == "collision" and shape.file is None for shape in shapes):
        problems.append(
            Diagnostic(
                "W-NO-COLLIDER",
                "the robot collides with nothing: all its colliders are meshes, which are left out",
                "mesh.assets",
                "mesh.assets=files writes them; or give links primitives",
            )
        )
    return problems
