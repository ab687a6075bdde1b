"""Joins the visual meshes of a link into a single GLB file, with their colours and images."""

from collections.abc import Hashable, Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from linkwright.stages.formats.meshes import glb
from linkwright.stages.formats.meshes.faces import mesh_faces
from linkwright.stages.formats.meshes.gltf_conventions import SUFFIX
from linkwright.stages.formats.meshes.surface import Surface
from linkwright.stages.mesh.files.names import stems
from linkwright.stages.robot.model.geometry import NEUTRAL, Geometry, Shape


def with_glb(geometry: Geometry, links: Iterable[str], up: glb.UpAxis) -> Geometry:
    """Returns the geometry with a GLB for each link that has visual meshes. Links with the same meshes and
    colours share the GLB of the first of them. `links`: all links of the robot."""
    names = stems(links)
    meshes_of: dict[str, list[Shape]] = {}
    for shape in geometry.shapes:
        if shape.role == "visual" and shape.file is not None:
            meshes_of.setdefault(shape.link, []).append(shape)
    first_names: dict[Hashable, str] = {}
    link_shapes, glbs = [], dict[str, bytes]()
    for link, meshes in meshes_of.items():
        content = tuple((shape.file, shape.colour, shape.texture) for shape in meshes)
        name = first_names.setdefault(content, f"{names[link]}{SUFFIX}")
        if name not in glbs:
            glbs[name] = glb.write([_glb_piece(shape, geometry.files) for shape in meshes], up)
        link_shapes.append(_whole_shape(link, name, meshes))
    files = dict(sorted(({**geometry.files, **glbs}).items()))
    return replace(geometry, files=files, whole_visuals=tuple(link_shapes))


def _glb_piece(shape: Shape, files: Mapping[str, bytes]) -> glb.Piece:
    file = str(shape.file)
    faces = mesh_faces(file, files[file])
    texcoords = None if faces.texcoords is None else faces.texcoords.astype(np.float32)
    image = files[shape.texture] if shape.texture else b""
    return glb.Piece(Surface(faces.points, faces.triangles, texcoords), shape.colour or NEUTRAL, image)


def _whole_shape(link: str, file: str, meshes: Sequence[Shape]) -> Shape:
    """Returns the shape of a link's GLB `file`, with the sums of the meshes' figures. It has no colour, since
    its file has the colours."""
    bounds = np.array([shape.bounds for shape in meshes])
    low, high = bounds[:, :3].min(axis=0), bounds[:, 3:].max(axis=0)
    return Shape(
        link,
        "visual",
        file,
        None,
        vertices=sum(shape.vertices for shape in meshes),
        faces=sum(shape.faces for shape in meshes),
        area=sum(shape.area for shape in meshes),
        volume=sum(shape.volume for shape in meshes),
        bounds=(*map(float, low), *map(float, high)),
    )
