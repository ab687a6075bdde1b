"""Reads triangles from mesh files: STL (binary and ASCII), OBJ, DAE, glTF and GLB, PLY, through trimesh.

Coordinates are read as by RViz and Pinocchio: in metres, except for the unit of a DAE; the
axis that a DAE or a glTF calls "up" is not turned. Colours are those of materials, faces or vertices;
images are not read.
"""

from __future__ import annotations

import importlib.util
import io
import re
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from stages.fetch.urdf.dae import cleaned
from stages.fetch.urdf.images import images
from stages.formats import gltf_claims
from stages.formats.triangles import Body, merged
from stages.robot.geometry import NEUTRAL, Colour
from stages.robot.install import install

FORMATS = ("stl", "obj", "dae", "gltf", "glb", "ply")

_MOST_COLOURS = 16
"""Largest number of colours of one mesh: more are shading, and each would become a file."""

_LFS = b"version https://git-lfs"
_STL_HEAD, _STL_FACE = 84, 50


class Unreadable(Exception):
    """A mesh file cannot be read; the text gives the reason."""


@dataclass(frozen=True, slots=True, eq=False)
class LooseMesh:
    """Loose triangles: `points` (n, 3) float64 [m], `triangles` (m, 3) indices into them counter-clockwise
    seen from outside, `colours` and which of them each triangle has (m,); `images`: names of images,
    which are not read."""

    points: npt.NDArray[np.float64]
    triangles: npt.NDArray[np.int64]
    colours: tuple[Colour, ...]
    which: npt.NDArray[np.int64]
    images: tuple[str, ...] = ()


def read(data: bytes, name: str, companions: Mapping[str, bytes]) -> LooseMesh:
    """The triangles in a mesh file. `name` ends as its format does; `companions`: the files that it
    names, as it names them. Unreadable where there are none."""
    kind = name.rpartition(".")[2].lower()
    if kind not in FORMATS:
        msg = f"its format is not supported; supported: {', '.join(FORMATS)}"
        raise Unreadable(msg)
    _require_content(data, kind)
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            if kind in ("gltf", "glb"):
                gltf_claims.judge(data, companions)
            scene = _scene(_PREPARED.get(kind, bytes)(data), kind, companions)
            pieces = [_placed(scene, node) for node in scene.graph.nodes_geometry]
            scale = _unit(scene, kind)
    except Exception as error:
        why = " ".join(str(error).split())[:200] or type(error).__name__
        raise Unreadable(f"it is damaged, or is not a {kind.upper()} file ({why})") from None
    joined = _joined([piece for piece in pieces if piece is not None], scale)
    return replace(joined, images=images(data, kind, companions))


def body(mesh: LooseMesh, key: str, scale: tuple[float, float, float], colour: Colour | None) -> Body:
    """A mesh as one body: scaled, turned outside again where that mirrors it, maybe in one colour."""
    points = mesh.points * np.array(scale) + 0.0
    mirrored = scale[0] * scale[1] * scale[2] < 0
    corners = mesh.triangles[:, ::-1] if mirrored else mesh.triangles
    if colour is None:
        return merged(key, points, corners, mesh.colours, mesh.which)
    return merged(key, points, corners, [colour], np.zeros(len(corners), dtype=np.int64))


def _require_content(data: bytes, kind: str) -> None:
    if not data:
        msg = "it is empty"
        raise Unreadable(msg)
    if data.startswith(_LFS):
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


def _whole(data: bytes) -> bytes:
    """A binary STL without the extra bytes that some programs append."""
    if len(data) >= _STL_HEAD and not (data.lstrip().startswith(b"solid") and b"facet" in data[:2000]):
        size = _STL_HEAD + _STL_FACE * int.from_bytes(data[80:84], "little")
        if size > len(data):
            there = (len(data) - _STL_HEAD) // _STL_FACE
            msg = f"it announces {(size - _STL_HEAD) // _STL_FACE} triangles and contains {there}"
            raise ValueError(msg)
        return data[:size]
    return data


def _utf8(data: bytes) -> bytes:
    """Text as UTF-8: old programs write names in any encoding."""
    try:
        data.decode()
    except UnicodeDecodeError:
        return data.decode("latin-1").encode()
    return data


_PREPARED = {"stl": _whole, "obj": _utf8, "dae": cleaned}
"""What is done to a format's bytes before they are read."""


def _scene(data: bytes, kind: str, companions: Mapping[str, bytes]) -> Any:
    import trimesh
    from trimesh.resolvers import Resolver

    class Companions(Resolver):
        """Gives the files beside a mesh file, and no others."""

        def __init__(self) -> None:
            pass

        def get(self, name: str) -> bytes:
            found = companions[name.strip()]
            return _utf8(found) if kind == "obj" else found

        def keys(self) -> Any:
            return companions.keys()

        def namespaced(self, namespace: str) -> Any:
            return self

        def write(self, name: str, data: bytes) -> None:
            raise NotImplementedError

    if kind == "dae":
        from trimesh.exchange import dae

        load: Any = dae.load_collada
        # What it cannot follow is an error: by default it is dropped.
        found = load(io.BytesIO(data), Companions(), ignore_broken=False)
        for shape in found["geometry"].values():
            shape["process"] = False
        return trimesh.load_scene(found)
    return trimesh.load_scene(
        io.BytesIO(data), file_type=kind, resolver=Companions(), process=False, maintain_order=True
    )


def _placed(scene: Any, node: str) -> LooseMesh | None:
    """One node of a scene in the scene's frame; None where it has no triangles."""
    transform, name = scene.graph[node]
    shape = scene.geometry[name]
    if not len(getattr(shape, "faces", ())):
        return None
    points = np.asarray(shape.vertices, dtype=np.float64)
    corners = np.asarray(shape.faces, dtype=np.int64)
    if corners.min() < 0 or corners.max() >= len(points):
        msg = "a triangle refers to a vertex that does not exist"
        raise ValueError(msg)
    if not np.array_equal(transform, np.eye(4)):
        points = points @ transform[:3, :3].T + transform[:3, 3]
        if np.linalg.det(transform[:3, :3]) < 0:
            corners = corners[:, ::-1]
    if not np.isfinite(points).all():
        msg = "a vertex is NaN or infinite"
        raise ValueError(msg)
    shades = _shades(shape)
    if shades is None:
        return LooseMesh(points, corners, (NEUTRAL,), np.zeros(len(corners), dtype=np.int64))
    colours, which = np.unique(shades, axis=0, return_inverse=True)
    index = which.ravel() if len(shades) > 1 else np.zeros(len(corners), dtype=np.int64)
    return LooseMesh(points, corners, tuple(_colour(one) for one in colours), index)


def _shades(shape: Any) -> npt.NDArray[np.int64] | None:
    """RGBA in 0..255: (1, 4) where all triangles have one colour, else (m, 4); None where it has none."""
    kind = shape.visual.kind
    if kind in ("vertex", "face"):
        shades = np.asarray(shape.visual.face_colors, dtype=np.int64).reshape(-1, 4)
        if len(shades) == len(shape.faces):
            return _coarse(shades)
    if kind == "texture" and shape.visual.material is not None:
        return np.asarray(shape.visual.material.main_color, dtype=np.int64).reshape(1, 4)
    return None


def _coarse(shades: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    """Colours rounded until they are few."""
    for levels in (255, 15, 7, 3, 1):
        rounded = np.rint(np.rint(shades * (levels / 255)) * (255 / levels)).astype(np.int64)
        if len(np.unique(rounded, axis=0)) <= _MOST_COLOURS:
            break
    return np.asarray(rounded, dtype=np.int64)


def _colour(shade: npt.NDArray[np.int64]) -> Colour:
    r, g, b, a = (round(int(channel) / 255, 6) for channel in shade)
    # Some exporters write 0 for opaque; invisible surfaces are not modelled.
    return r, g, b, a or 1.0


def _unit(scene: Any, kind: str) -> float:
    """The length of a DAE's unit [m]."""
    if kind != "dae" or not scene.geometry:
        return 1.0
    units = str(next(iter(scene.geometry.values())).metadata.get("units", "meters"))
    factor = units.partition(" * ")[0] if " * " in units else "1"
    return float(factor)


def _joined(pieces: list[LooseMesh], scale: float) -> LooseMesh:
    if not pieces:
        msg = "it has no triangles"
        raise Unreadable(msg)
    first = np.cumsum([0, *(len(piece.points) for piece in pieces)])
    shade = np.cumsum([0, *(len(piece.colours) for piece in pieces)])
    return LooseMesh(
        points=np.concatenate([piece.points for piece in pieces]) * scale,
        triangles=np.concatenate([one.triangles + at for one, at in zip(pieces, first, strict=False)]),
        colours=tuple(colour for piece in pieces for colour in piece.colours),
        which=np.concatenate([one.which + at for one, at in zip(pieces, shade, strict=False)]),
    )
