"""Reads triangles from mesh files: STL (binary and ASCII), OBJ, DAE, glTF and GLB, PLY, all but binary STL
through trimesh.

Coordinates are read as by RViz and Pinocchio: in metres, except for the unit of a DAE; the
axis that a DAE or a glTF calls "up" is not turned. Colours are those of materials, faces or vertices. Of
images, only those that give a material of an OBJ or a glTF its colour are used; they are not decoded.
"""

from __future__ import annotations

import importlib.util
import io
import re
import warnings
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from linkwright.stages.fetch.urdf.meshes import gltf_materials
from linkwright.stages.fetch.urdf.meshes.companions import Companions
from linkwright.stages.fetch.urdf.meshes.dae import cleaned
from linkwright.stages.fetch.urdf.meshes.images import images
from linkwright.stages.fetch.urdf.meshes.loose_mesh import WHITE, LooseMesh, Texcoords, join_meshes
from linkwright.stages.fetch.urdf.meshes.textures import NO_COORDINATES, Texture, gltf_textures, obj_textures
from linkwright.stages.formats.damaged import Damaged
from linkwright.stages.formats.meshes import gltf_claims
from linkwright.stages.formats.meshes.body_arrays import distinct
from linkwright.stages.formats.meshes.points import is_binary_stl, mesh_points
from linkwright.stages.formats.xml import Malformed
from linkwright.stages.robot.model.geometry import NEUTRAL, Colour
from linkwright.stages.robot.system.install import install

FORMATS = ("stl", "obj", "dae", "gltf", "glb", "ply")

_MAX_COLOURS = 16
"""Largest number of colours of a mesh: more are shading, and each would become a file."""

_EMPTY = "it has no triangles"
_LFS_POINTER = b"version https://git-lfs"
_STL_HEAD, _STL_FACE = 84, 50
"""Sizes of a binary STL's header with the number of its triangles, and of a triangle [bytes]."""


class Unreadable(Exception):
    """The error that a mesh file cannot be read; its text gives the reason."""


def read(data: bytes, name: str, companions: Companions) -> LooseMesh:
    """Reads the triangles in a mesh file. `name` ends with the format; `companions`: the files that the mesh
    file names. Raises Unreadable if there are no triangles."""
    kind = name.rpartition(".")[2].lower()
    if kind not in FORMATS:
        msg = f"its format is not supported; supported: {', '.join(FORMATS)}"
        raise Unreadable(msg)
    _require_content(data, kind)
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            textures = obj_textures(companions) if kind == "obj" else {}
            content = _PREPARATIONS.get(kind, bytes)(data)
            if kind == "stl" and is_binary_stl(content):
                return _read_binary_stl(content)
            if kind in ("gltf", "glb"):
                gltf_claims.check_claims(data, companions.files)
                content, gltf_images = gltf_materials.prepare(data, companions.files, companions.images)
                textures = gltf_textures(gltf_images)
            scene = _scene(content, kind, companions.files)
            pieces = [_node_mesh(scene, node, textures) for node in scene.graph.nodes_geometry]
            scale = _unit(scene, kind)
    except Unreadable:
        raise
    except Exception as error:
        # The words of a library may quote the file, which is any file that a robot names.
        why = str(error) if isinstance(error, Damaged | Malformed) else type(error).__name__
        raise Unreadable(f"it is damaged, or is not a {kind.upper()} file ({why})") from None
    meshes = [piece for piece in pieces if piece is not None]
    if not meshes:
        raise Unreadable(_EMPTY)
    return replace(join_meshes(meshes, scale), images=images(data, kind, companions.files))


def _require_content(data: bytes, kind: str) -> None:
    if not data:
        msg = "it is empty"
        raise Unreadable(msg)
    if data.startswith(_LFS_POINTER):
        msg = "it is a Git LFS pointer, not the file itself: run `git lfs pull` in its repository"
        raise Unreadable(msg)
    if kind == "dae":
        if importlib.util.find_spec("collada") is None:
            msg = f"DAE needs the package pycollada: {install('pycollada')}"
            raise Unreadable(msg)
        if b"<!ENTITY" in data:
            msg = "it declares entities, which are not read"
            raise Unreadable(msg)
    if kind == "obj" and re.search(rb"^f[^\n]*\s-\d", data, re.MULTILINE):
        msg = "its faces have negative indices, which are not supported"
        raise Unreadable(msg)
    if kind == "ply":
        counts = re.findall(rb"^element\s+\w+\s+(\d+)", data[: 1 << 14], re.MULTILINE)
        if any(int(count) > len(data) for count in counts):
            msg = "it is incomplete: its header announces more data"
            raise Unreadable(msg)


def _without_trailing_bytes(data: bytes) -> bytes:
    """Returns a binary STL without the extra bytes that some programs append."""
    if len(data) >= _STL_HEAD and not (data.lstrip().startswith(b"solid") and b"facet" in data[:2000]):
        size = _STL_HEAD + _STL_FACE * int.from_bytes(data[80:84], "little")
        if size > len(data):
            face_count = (len(data) - _STL_HEAD) // _STL_FACE
            msg = f"it announces {(size - _STL_HEAD) // _STL_FACE} triangles and contains {face_count}"
            raise Damaged(msg)
        return data[:size]
    return data


def _utf8(data: bytes) -> bytes:
    """Returns text as UTF-8: old programs write names in any encoding."""
    try:
        data.decode()
    except UnicodeDecodeError:
        return data.decode("latin-1").encode()
    return data


_PREPARATIONS = {"stl": _without_trailing_bytes, "obj": _utf8, "dae": cleaned}
"""Format → the function that prepares its bytes before they are read."""


def _scene(data: bytes, kind: str, files: Mapping[str, bytes]) -> Any:
    # Imported late: only formats other than STL need trimesh, which takes a while to import.
    import trimesh
    from trimesh.resolvers import Resolver

    class Beside(Resolver):
        """Gives the files beside a mesh file, and no others."""

        def __init__(self) -> None:
            pass

        def get(self, name: str) -> bytes:
            content = files[name.strip()]
            return _utf8(content) if kind == "obj" else content

        def keys(self) -> Any:
            return files.keys()

        def namespaced(self, namespace: str) -> Any:
            return self

        def write(self, name: str, data: bytes) -> None:
            raise NotImplementedError

    if kind == "dae":
        # Late: only formats that are not STL need trimesh, which takes a while to import.
        from trimesh.exchange import dae

        load: Any = dae.load_collada
        # Unresolved references are errors: by default they are dropped.
        loaded = load(io.BytesIO(data), Beside(), ignore_broken=False)
        for shape in loaded["geometry"].values():
            shape["process"] = False
        return trimesh.load_scene(loaded)
    # trimesh keeps the order of an OBJ's points only by giving each point a single pair of texture
    # coordinates.
    keeps_order = kind != "obj" or not re.search(rb"^vt\s", data, re.MULTILINE)
    return trimesh.load_scene(
        io.BytesIO(data), file_type=kind, resolver=Beside(), process=False, maintain_order=keeps_order
    )


def _node_mesh(scene: Any, node: str, textures: Mapping[str, Texture]) -> LooseMesh | None:
    """Returns a node of a scene in the scene's frame; None if it has no triangles. `textures`: by
    material."""
    transform, name = scene.graph[node]
    shape = scene.geometry[name]
    if not len(getattr(shape, "faces", ())):
        return None
    points = np.asarray(shape.vertices, dtype=np.float64)
    corners = np.asarray(shape.faces, dtype=np.int64)
    if corners.min() < 0 or corners.max() >= len(points):
        msg = "a triangle refers to a vertex that does not exist"
        raise Damaged(msg)
    if not np.array_equal(transform, np.eye(4)):
        points = points @ transform[:3, :3].T + transform[:3, 3]
        if np.linalg.det(transform[:3, :3]) < 0:
            corners = corners[:, ::-1]
    _require_finite(points)
    texcoords = _texcoords(shape, corners)
    texture = _texture(shape, textures)
    if texture is not None and texture.image and texcoords is None:
        texture = texture.without(NO_COORDINATES)
    shades = _shades(shape)
    colours: tuple[Colour, ...]
    if shades is None:
        colours, colour_indices = (NEUTRAL,), np.zeros(len(corners), dtype=np.int64)
    elif texture is not None and texture.image and texture.white:
        colours, colour_indices = (WHITE,), np.zeros(len(corners), dtype=np.int64)
    else:
        distinct_shades, inverse = np.unique(shades, axis=0, return_inverse=True)
        colours = tuple(_colour(shade) for shade in distinct_shades)
        colour_indices = inverse.ravel() if len(shades) > 1 else np.zeros(len(corners), dtype=np.int64)
    return LooseMesh(points, corners, colours, colour_indices, (texture,) * len(colours), texcoords)


def _read_binary_stl(data: bytes) -> LooseMesh:
    """Returns the triangles of a binary STL, which has nothing else. Equal points are merged, so that no use
    of a large file needs to sort all of its corners again."""
    corners = mesh_points(".stl", data)
    if not len(corners):
        raise Unreadable(_EMPTY)
    _require_finite(corners)
    points, index = distinct(corners)
    triangles = index.reshape(-1, 3)
    return LooseMesh(points, triangles, (NEUTRAL,), np.zeros(len(triangles), dtype=np.int64), (None,), None)


def _require_finite(points: npt.NDArray[np.float64]) -> None:
    if not np.isfinite(points).all():
        msg = "a vertex is NaN or infinite"
        raise Damaged(msg)


def _texture(shape: Any, textures: Mapping[str, Texture]) -> Texture | None:
    """Returns the image that gives a shape its colour, or None."""
    if shape.visual.kind != "texture" or shape.visual.material is None:
        return None
    return textures.get(str(shape.visual.material.name))


def _texcoords(shape: Any, corners: npt.NDArray[np.int64]) -> Texcoords | None:
    """Returns the texture coordinates of the corners of a shape's triangles, or None."""
    uv = getattr(shape.visual, "uv", None)
    if uv is None or np.ndim(uv) != 2 or np.shape(uv)[1] < 2 or len(uv) != len(shape.vertices):
        return None
    with np.errstate(over="ignore"):
        pairs = np.asarray(uv)[:, :2].astype(np.float32)
    return pairs[corners] if np.isfinite(pairs).all() else None


def _shades(shape: Any) -> npt.NDArray[np.int64] | None:
    """Returns RGBA in 0..255: (1, 4) if all triangles share a colour, otherwise (m, 4); None without
    colours."""
    kind = shape.visual.kind
    if kind in ("vertex", "face"):
        shades = np.asarray(shape.visual.face_colors, dtype=np.int64).reshape(-1, 4)
        if len(shades) == len(shape.faces):
            return _with_few_colours(shades)
    if kind == "texture" and shape.visual.material is not None:
        return np.asarray(shape.visual.material.main_color, dtype=np.int64).reshape(1, 4)
    return None


def _with_few_colours(shades: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    """Rounds colours until they are few."""
    for levels in (255, 15, 7, 3, 1):
        rounded = np.rint(np.rint(shades * (levels / 255)) * (255 / levels)).astype(np.int64)
        if len(np.unique(rounded, axis=0)) <= _MAX_COLOURS:
            break
    return np.asarray(rounded, dtype=np.int64)


def _colour(shade: npt.NDArray[np.int64]) -> Colour:
    r, g, b, a = (round(int(channel) / 255, 6) for channel in shade)
    # Some exporters write 0 for opaque; invisible surfaces are not modelled.
    return r, g, b, a or 1.0


def _unit(scene: Any, kind: str) -> float:
    """Returns the length of a DAE's unit [m]. Raises Damaged if it is not a positive length."""
    if kind != "dae" or not scene.geometry:
        return 1.0
    units = str(next(iter(scene.geometry.values())).metadata.get("units", "meters"))
    factor = units.partition(" * ")[0] if " * " in units else "1"
    if not 0.0 < float(factor) < np.inf:
        msg = f"its unit has a length of {float(factor):g} m"
        raise Damaged(msg)
    return float(factor)
