"""Writes the visuals of a link, as instances of meshes, and its colliders."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from hashlib import sha256

import numpy as np

from linkwright.stages.export.paints import Paint, materials, paint
from linkwright.stages.export.usd.layer import Layer, Prim
from linkwright.stages.formats.meshes.body_arrays import distinct
from linkwright.stages.formats.meshes.faces import MeshFaces, mesh_faces, normals
from linkwright.stages.formats.usd.colours import ROUGHNESS, to_linear_rgb
from linkwright.stages.formats.usd.names import identifiers
from linkwright.stages.robot.model.geometry import Geometry, Shape
from linkwright.stages.robot.model.robot import Array, Primitive
from linkwright.stages.robot.text.names import free_name

Friction = tuple[float, float, float]
"""Coefficients of friction: sliding [-], torsional [m] and rolling [m]."""

_PRIM_TYPES = {"box": "Cube", "sphere": "Sphere", "cylinder": "Cylinder", "capsule": "Capsule"}
"""Kind of primitive → type of prim."""

_POINT_DIGITS = 6
"""Decimal places to which the points [m] of two surfaces, and the numbers of their poses, must agree to count
as the same."""

_NORMAL_DIGITS = 5
"""Decimal places of normals, above the noise of points in single precision."""

_COLLIDER_SCHEMAS = ("PhysicsCollisionAPI", "NewtonCollisionAPI", "MjcCollisionAPI")
"""Schemas of a collider: of UsdPhysics, of Newton and of MuJoCo."""


@dataclass(frozen=True, slots=True, eq=False)
class UsdMeshes:
    """The meshes in a layer beside the robot's, by the names of their files."""

    layer: str
    """The path of the layer."""

    paths: Mapping[str, str]
    """File → path of the prim that holds its mesh as the child `mesh`."""

    surfaces: Mapping[str, str]
    """File → digest of its triangles, which is the same for meshes whose points are equal after rounding to a
    micrometre."""


def meshes_layer(geometry: Geometry, path: str) -> tuple[Layer, UsdMeshes]:
    """Returns the layer of all meshes, each once. `path`: the path of the layer's file, relative to the
    robot's file."""
    layer = Layer("meshes", "Scope")
    files = list(dict.fromkeys(shape.file for shape in geometry.shapes if shape.file is not None))
    names = identifiers(_stem(file) for file in files)
    paths, surfaces = {}, {}
    for file in files:
        holder = layer.root.child(names[_stem(file)], "Xform")
        faces = mesh_faces(file, geometry.files[file])
        _write_mesh(holder.child("mesh", "Mesh"), faces)
        paths[file] = holder.path
        # Adding 0.0 turns -0.0 into 0.0, which has other bytes.
        rounded_points = np.round(faces.points, _POINT_DIGITS) + 0.0
        surfaces[file] = sha256(rounded_points.tobytes() + faces.triangles.tobytes()).hexdigest()
    return layer, UsdMeshes(f"./{path}", paths, surfaces)


class ShownMeshes:
    """A register of the meshes that are shown at each pose of the standing robot."""

    def __init__(self, meshes: UsdMeshes) -> None:
        self._surfaces = meshes.surfaces
        self._links: dict[tuple[str, bytes], set[str]] = {}

    def add(self, file: str, link: str, world_from_link: Array) -> set[str]:
        """Adds a mesh of a link. Returns the links that already show the same mesh in the same pose."""
        key = self._surfaces[file], (np.round(world_from_link, _POINT_DIGITS) + 0.0).tobytes()
        links = self._links.setdefault(key, set())
        earlier_links = {*links}
        links.add(link)
        return earlier_links


def _stem(file: str) -> str:
    """Returns the file's name without its extension."""
    return file.rsplit(".", 1)[0]


def _write_mesh(prim: Prim, faces: MeshFaces) -> None:
    """Writes the triangles of a mesh, with a normal for each triangle and any texture coordinates of their
    corners."""
    prim.array("points", "point3f[]", faces.points.astype(np.float32))
    prim.array("faceVertexCounts", "int[]", np.full(len(faces.triangles), 3, dtype=np.int32))
    prim.array("faceVertexIndices", "int[]", faces.triangles.astype(np.int32).reshape(-1))
    prim.token("subdivisionScheme", "none")
    if len(faces.points):
        corners = np.array([faces.points.min(axis=0), faces.points.max(axis=0)], dtype=np.float32)
        prim.array("extent", "float3[]", corners)
    # By index: most faces of a part from CAD share their normal with others.
    distinct_normals, index = distinct(np.round(normals(faces), _NORMAL_DIGITS))
    prim.array("primvars:normals", "normal3f[]", distinct_normals.astype(np.float32))
    prim.array("primvars:normals:indices", "int[]", index.astype(np.int32))
    prim.interpolate("primvars:normals", "uniform")
    if faces.texcoords is not None:
        prim.array("primvars:st", "texCoord2f[]", faces.texcoords.astype(np.float32).reshape(-1, 2))
        prim.interpolate("primvars:st", "faceVarying")


@dataclass(frozen=True, slots=True, eq=False)
class UsdMaterials:
    """The materials of a robot, by the paths of their prims."""

    visual: Mapping[Paint, str]
    """Colour and image → path."""

    physical: Mapping[Friction, str]
    """Friction → path."""


def write_materials(scope: Prim, geometry: Geometry) -> UsdMaterials:
    """Writes the materials of `geometry`, below `scope`."""
    names = materials(geometry)
    used_names: set[str] = set(names.values())
    identifier_of = identifiers(names.values())
    visual = {
        look: _write_material(scope.child(identifier_of[name], "Material"), look)
        for look, name in names.items()
    }
    physical = {}
    for friction in _frictions(geometry):
        name = free_name("friction", used_names)
        used_names.add(name)
        prim = scope.child(name, "Material", "PhysicsMaterialAPI", "NewtonMaterialAPI")
        for key in ("staticFriction", "dynamicFriction"):
            prim.number(f"physics:{key}", friction[0])
        for key, value in (("torsionalFriction", friction[1]), ("rollingFriction", friction[2])):
            prim.number(f"newton:{key}", value)
        physical[friction] = prim.path
    return UsdMaterials(visual, physical)


def _frictions(geometry: Geometry) -> Iterator[Friction]:
    """Yields the frictions of colliders, each once."""
    frictions = (shape.contact.friction for shape in geometry.shapes if shape.contact is not None)
    yield from dict.fromkeys(friction for friction in frictions if friction is not None)


def _write_material(prim: Prim, look: Paint) -> str:
    """Writes the surface of a visual material, with the image if it has one. Returns the path of the
    material."""
    colour, image_file = look
    surface = prim.child("surface", "Shader")
    surface.token("info:id", "UsdPreviewSurface")
    if image_file:
        image = prim.child("image", "Shader")
        image.token("info:id", "UsdUVTexture")
        image.set("inputs:file", "asset", f"assets/{image_file}")
        image.set("inputs:sourceColorSpace", "token", "sRGB")
        image.floats("inputs:scale", "float4", (*to_linear_rgb(colour), 1.0))
        coordinates = prim.child("places", "Shader")
        coordinates.token("info:id", "UsdPrimvarReader_float2")
        coordinates.set("inputs:varname", "string", "st")
        coordinates.set("outputs:result", "float2", None)
        image.connect("inputs:st", "float2", f"{coordinates.path}.outputs:result")
        image.set("outputs:rgb", "float3", None)
        surface.connect("inputs:diffuseColor", "color3f", f"{image.path}.outputs:rgb")
    else:
        surface.floats("inputs:diffuseColor", "color3f", to_linear_rgb(colour))
    surface.number("inputs:opacity", colour[3])
    surface.number("inputs:roughness", ROUGHNESS)
    surface.set("outputs:surface", "token", None)
    prim.connect("outputs:surface", "token", f"{surface.path}.outputs:surface")
    return prim.path


def write_visuals(
    scope: Prim,
    shapes: Sequence[Shape],
    robot_materials: UsdMaterials,
    meshes: UsdMeshes,
    shown: ShownMeshes,
    world_from_link: Array,
) -> None:
    """Writes the visual shapes of a link below `scope`, each as an instance of its mesh or as a primitive.
    Only a mesh that the link itself already shows there is made invisible: other links move away."""
    for number, shape in enumerate(shapes, 1):
        name = f"visual_{number}"
        if shape.primitive is None:
            assert shape.file is not None
            prim = scope.child(name, "Xform")
            prim.refer(meshes.paths[shape.file], meshes.layer, instance=True)
            if shape.link in shown.add(shape.file, shape.link, world_from_link):
                prim.hide()
        else:
            prim = _write_primitive(scope, name, shape.primitive)
        look = paint(shape)
        if look is not None:
            prim.array(
                "primvars:displayColor",
                "color3f[]",
                np.array([to_linear_rgb(look[0])], dtype=np.float32),
            )
            prim.apply("MaterialBindingAPI")
            prim.point_to("material:binding", robot_materials.visual[look])


def write_colliders(
    scope: Prim,
    shapes: Sequence[Shape],
    robot_materials: UsdMaterials,
    meshes: UsdMeshes,
    shown: ShownMeshes,
    world_from_link: Array,
) -> list[Prim]:
    """Writes the colliders of a link below `scope`, which are convex: primitives, and hulls of meshes.
    Returns their prims. All visuals of the robot come first: a collider is invisible if its mesh is already
    shown there, also by another link, which may move away. That changes no contact, and colliders are guides,
    which viewers show only on demand."""
    colliders = []
    for number, shape in enumerate(shapes, 1):
        name = f"collision_{number}"
        if shape.primitive is None:
            assert shape.file is not None
            collider = scope.child(
                name, "Mesh", *_COLLIDER_SCHEMAS, "PhysicsMeshCollisionAPI", "NewtonMeshCollisionAPI"
            )
            collider.refer(f"{meshes.paths[shape.file]}/mesh", meshes.layer)
            if shown.add(shape.file, shape.link, world_from_link):
                collider.hide()
            collider.token("physics:approximation", "convexHull")
        else:
            collider = _write_primitive(scope, name, shape.primitive)
            collider.apply(*_COLLIDER_SCHEMAS)
        if shape.contact is not None and shape.contact.friction is not None:
            collider.apply("MaterialBindingAPI")
            collider.point_to("material:binding:physics", robot_materials.physical[shape.contact.friction])
        colliders.append(collider)
    return colliders


def _write_primitive(parent: Prim, name: str, primitive: Primitive) -> Prim:
    """Writes a primitive at its pose below `parent`. A box is a cube of side 1 m, scaled along its axes."""
    prim, size = parent.child(name, _PRIM_TYPES[primitive.kind]), primitive.size
    if primitive.kind == "box":
        prim.number("size", 1.0, "double")
        _write_extent(prim, np.full(3, 0.5))
        prim.place(primitive.link_from_shape, size)
        return prim
    radius = size[0]
    prim.number("radius", radius, "double")
    half_sizes = np.full(3, radius)
    if primitive.kind != "sphere":
        prim.number("height", size[1], "double")
        prim.token("axis", "Z")
        half_sizes[2] = size[1] / 2 + (radius if primitive.kind == "capsule" else 0.0)
    _write_extent(prim, half_sizes)
    prim.place(primitive.link_from_shape)
    return prim


def _write_extent(prim: Prim, half_sizes: Array) -> None:
    """Writes the box around a primitive in its own frame, before its scale. `half_sizes` (3,) [m]."""
    prim.array("extent", "float3[]", np.array([-half_sizes, half_sizes], dtype=np.float32))
