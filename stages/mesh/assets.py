"""The mesh files of a robot in the form that `mesh.format` and `mesh.assets` ask for."""

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from linkwright.stages.formats.meshes.surface import Surface
from linkwright.stages.formats.triangles import distinct
from linkwright.stages.mesh.files import obj, stl
from linkwright.stages.mesh.visuals import textures
from linkwright.stages.robot.errors import Diagnostic
from linkwright.stages.robot.model.geometry import Shape
from linkwright.stages.robot.text.plural import count

if TYPE_CHECKING:
    from linkwright.stages.mesh.section import MeshSection

Assets = tuple[tuple[Shape, ...], Mapping[str, bytes]]
"""Shapes, and the files that they name."""


def written(
    shapes: Sequence[Shape], files: Mapping[str, bytes], section: "MeshSection"
) -> tuple[Assets, list[Diagnostic]]:
    """Shapes and files as they are written, out of meshes that are all named .stl, those with a texture being
    OBJ files, and images: meshes of the same content are one file. I-NO-ASSETS and W-NO-COLLIDER where meshes
    are left out. A mesh with a texture stays an OBJ, since an STL has no texture coordinates."""
    if section.assets == "none":
        kept = tuple(shape for shape in shapes if shape.file is None)
        return (kept, {}), _left_out(shapes)
    found = {name: data for name, data in files.items() if name.endswith(textures.IMAGE)}
    first = _first_names(shapes, files)
    renamed = []
    for shape in shapes:
        if shape.file is None:
            renamed.append(shape)
            continue
        data = files[shape.file]
        name = first[_content(shape, data)]
        if shape.texture is not None:
            name = _obj(name)
            if name not in found:
                found |= textures.dressed(shape, name, data)
        elif section.format == "obj":
            name = _obj(name)
            if name not in found:
                found[name] = obj.write(surface(data))
        else:
            found[name] = data
        renamed.append(replace(shape, file=name))
    return (tuple(renamed), dict(sorted(found.items()))), []


def _first_names(shapes: Sequence[Shape], files: Mapping[str, bytes]) -> dict[Hashable, str]:
    """By content: the name of the first mesh that has it, in the order of the links, of each the visual ones
    first."""
    order = {link: index for index, link in enumerate(dict.fromkeys(shape.link for shape in shapes))}
    found: dict[Hashable, str] = {}
    for shape in sorted(shapes, key=lambda one: (order[one.link], one.role == "collision")):
        if shape.file is not None:
            found.setdefault(_content(shape, files[shape.file]), shape.file)
    return found


def _content(shape: Shape, data: bytes) -> Hashable:
    """What a mesh file, and the material in its library, are made of."""
    return (data, shape.texture, shape.colour) if shape.texture is not None else data


def surface(data: bytes) -> Surface:
    """The surface of a file that `stl.write` made: its points, sorted, and its triangles."""
    corners = stl.read(data)
    vertices, index = distinct(corners.reshape(-1, 3))
    return Surface(vertices, index.reshape(-1, 3).astype(np.int64))


def _obj(name: str) -> str:
    return f"{name.removesuffix('.stl')}.obj"


def _left_out(shapes: Sequence[Shape]) -> list[Diagnostic]:
    meshes = [shape for shape in shapes if shape.file is not None]
    visuals = sum(shape.role == "visual" for shape in meshes)
    colliders = len(meshes) - visuals
    found = []
    if meshes:
        found.append(
            Diagnostic(
                "I-NO-ASSETS",
                f"{count(visuals, 'visual mesh', 'visual meshes')} and {count(colliders, 'collider')} that "
                "are meshes are left out; masses and primitives stay",
                "mesh.assets",
                "mesh.assets=files writes them",
            )
        )
    if not any(shape.role == "collision" and shape.file is None for shape in shapes):
        found.append(
            Diagnostic(
                "W-NO-COLLIDER",
                "nothing of the robot collides: all of its colliders are meshes, which are left out",
                "mesh.assets",
                "mesh.assets=files writes them; or give links primitives",
            )
        )
    return found
