"""What a link looks like, as instances of meshes, and what it collides with."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from linkwright.stages.export.paints import Paint, materials, paint
from linkwright.stages.export.usd.layer import Layer, Prim
from linkwright.stages.formats.meshes.faces import MeshFaces, mesh_faces
from linkwright.stages.formats.usd.colours import ROUGHNESS, linear
from linkwright.stages.formats.usd.names import identifiers
from linkwright.stages.robot.model.geometry import Geometry, Shape
from linkwright.stages.robot.model.robot import Array, Primitive
from linkwright.stages.robot.text.names import free

Friction = tuple[float, float, float]
"""Sliding [-], torsional [m] and rolling [m]."""

_KINDS = {"box": "Cube", "sphere": "Sphere", "cylinder": "Cylinder", "capsule": "Capsule"}


def meshes_layer(geometry: Geometry) -> tuple[Layer, dict[str, str]]:
    """The layer of all meshes, each once, and their paths in it by the names of their files: of a prim that
    holds the mesh, which is its child `mesh`."""
    layer = Layer("meshes", "Scope")
    files = list(dict.fromkeys(shape.file for shape in geometry.shapes if shape.file is not None))
    names = identifiers(_stem(file) for file in files)
    paths = {}
    for file in files:
        holder = layer.root.child(names[_stem(file)], "Xform")
        _mesh(holder.child("mesh", "Mesh"), mesh_faces(file, geometry.files[file]))
        paths[file] = holder.path
    return layer, paths


def _stem(file: str) -> str:
    """The file's name without its extension."""
    return file.rsplit(".", 1)[0]


def _mesh(prim: Prim, faces: MeshFaces) -> None:
    prim.array("points", "point3f[]", faces.points.astype(np.float32))
    prim.array("faceVertexCounts", "int[]", np.full(len(faces.triangles), 3, dtype=np.int32))
    prim.array("faceVertexIndices", "int[]", faces.triangles.astype(np.int32).reshape(-1))
    prim.token("subdivisionScheme", "none")
    if len(faces.points):
        ends = np.array([faces.points.min(axis=0), faces.points.max(axis=0)], dtype=np.float32)
        prim.array("extent", "float3[]", ends)
    if faces.texcoords is not None:
        prim.array("primvars:st", "texCoord2f[]", faces.texcoords.astype(np.float32).reshape(-1, 2))
        prim.interpolate("primvars:st", "faceVarying")


@dataclass(frozen=True, slots=True, eq=False)
class Looks:
    """The materials of a robot: what is seen, and what rubs; each by the path of its prim."""

    seen: Mapping[Paint, str]
    rubs: Mapping[Friction, str]


def write_materials(above: Prim, geometry: Geometry) -> Looks:
    """The materials of `geometry`, below a prim."""
    names = materials(geometry)
    taken: set[str] = set(names.values())
    own = identifiers(names.values())
    seen = {one: _material(above.child(own[name], "Material"), one) for one, name in names.items()}
    rubs = {}
    for one in _frictions(geometry):
        name = free("friction", taken)
        taken.add(name)
        made = above.child(name, "Material", "PhysicsMaterialAPI", "NewtonMaterialAPI")
        for key in ("staticFriction", "dynamicFriction"):
            made.number(f"physics:{key}", one[0])
        for key, value in (("torsionalFriction", one[1]), ("rollingFriction", one[2])):
            made.number(f"newton:{key}", value)
        rubs[one] = made.path
    return Looks(seen, rubs)


def _frictions(geometry: Geometry) -> Iterator[Friction]:
    """Those of colliders, each once."""
    found = (shape.contact.friction for shape in geometry.shapes if shape.contact is not None)
    yield from dict.fromkeys(one for one in found if one is not None)


def _material(prim: Prim, own: Paint) -> str:
    colour, texture = own
    surface = prim.child("surface", "Shader")
    surface.token("info:id", "UsdPreviewSurface")
    if texture:
        image = prim.child("image", "Shader")
        image.token("info:id", "UsdUVTexture")
        image.set("inputs:file", "asset", f"assets/{texture}")
        image.set("inputs:sourceColorSpace", "token", "sRGB")
        image.floats("inputs:scale", "float4", (*linear(colour), 1.0))
        places = prim.child("places", "Shader")
        places.token("info:id", "UsdPrimvarReader_float2")
        places.set("inputs:varname", "string", "st")
        places.set("outputs:result", "float2", None)
        image.connect("inputs:st", "float2", f"{places.path}.outputs:result")
        image.set("outputs:rgb", "float3", None)
        surface.connect("inputs:diffuseColor", "color3f", f"{image.path}.outputs:rgb")
    else:
        surface.floats("inputs:diffuseColor", "color3f", linear(colour))
    surface.number("inputs:opacity", colour[3])
    surface.number("inputs:roughness", ROUGHNESS)
    surface.set("outputs:surface", "token", None)
    prim.connect("outputs:surface", "token", f"{surface.path}.outputs:surface")
    return prim.path


def write_visuals(
    above: Prim, shapes: Sequence[Shape], looks: Looks, meshes: Mapping[str, str], layer: str
) -> None:
    """The visual shapes of a link below a prim: an instance of its mesh each, or a primitive."""
    for count, shape in enumerate(shapes, 1):
        name = f"visual_{count}"
        if shape.primitive is None:
            assert shape.file is not None
            made = above.child(name, "Xform")
            made.refer(meshes[shape.file], layer, instance=True)
        else:
            made = _primitive(above, name, shape.primitive)
        own = paint(shape)
        if own is not None:
            made.array("primvars:displayColor", "color3f[]", np.array([linear(own[0])], dtype=np.float32))
            made.apply("MaterialBindingAPI")
            made.point_to("material:binding", looks.seen[own])


def write_colliders(
    above: Prim, shapes: Sequence[Shape], looks: Looks, meshes: Mapping[str, str], layer: str
) -> list[Prim]:
    """The colliders of a link below a prim, which are convex: primitives, and hulls of meshes."""
    made = []
    for count, shape in enumerate(shapes, 1):
        name = f"collision_{count}"
        if shape.primitive is None:
            assert shape.file is not None
            one = above.child(name, "Mesh", "PhysicsCollisionAPI", "PhysicsMeshCollisionAPI")
            one.refer(f"{meshes[shape.file]}/mesh", layer)
            one.token("physics:approximation", "convexHull")
        else:
            one = _primitive(above, name, shape.primitive)
            one.apply("PhysicsCollisionAPI")
        if shape.contact is not None and shape.contact.friction is not None:
            one.apply("MaterialBindingAPI")
            one.point_to("material:binding:physics", looks.rubs[shape.contact.friction])
        made.append(one)
    return made


def _primitive(above: Prim, name: str, primitive: Primitive) -> Prim:
    prim, size = above.child(name, _KINDS[primitive.kind]), primitive.size
    if primitive.kind == "box":
        prim.number("size", 1.0, "double")
        _extent(prim, np.full(3, 0.5))
        prim.place(primitive.link_from_shape, size)
        return prim
    radius = size[0]
    prim.number("radius", radius, "double")
    half = np.full(3, radius)
    if primitive.kind != "sphere":
        prim.number("height", size[1], "double")
        prim.token("axis", "Z")
        half[2] = size[1] / 2 + (radius if primitive.kind == "capsule" else 0.0)
    _extent(prim, half)
    prim.place(primitive.link_from_shape)
    return prim


def _extent(prim: Prim, half: Array) -> None:
    prim.array("extent", "float3[]", np.array([-half, half], dtype=np.float32))
