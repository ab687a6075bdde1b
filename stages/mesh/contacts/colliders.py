"""Computes with MuJoCo how deep the colliders of two links overlap, at any pose.

MuJoCo takes a mesh as its convex hull, here as in a simulation.
"""

import functools
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt

from linkwright.stages.formats.numbers import spaced
from linkwright.stages.formats.xml import Element, element, to_bytes
from linkwright.stages.mesh.contacts.narrow import Mask
from linkwright.stages.mujoco.compile import NotCompiled, compiled_text
from linkwright.stages.robot.contact.meeting_boxes import meeting_boxes
from linkwright.stages.robot.errors import MeshError
from linkwright.stages.robot.model.geometry import Shape
from linkwright.stages.robot.model.poses import from_parts, quat_from_rotation, rotation_from_quat
from linkwright.stages.robot.model.robot import Array
from linkwright.stages.robot.motion.adjacency import Pair

TOUCH_DISTANCE = 1e-6
"""Largest distance [m] of colliders that touch: single precision moves faces by as much."""

_MAX_DISTANCE = 1e-3
"""Distance [m] up to which MuJoCo measures; it returns this for geoms that are farther apart."""

_NUDGE = 1e-4
"""Distance by which a geom is moved to break symmetry, as a share of the sum of both bounding radii."""

_OBLIQUE = np.array([0.48, 0.64, 0.6])
"""Unit vector (3,) that is far from every coordinate axis."""


class Colliders:
    """The colliders of all links, compiled once."""

    def __init__(self, shapes: Sequence[Shape], files: Mapping[str, bytes]) -> None:
        """Compiles the shapes; raises MeshError if MuJoCo refuses one."""
        self._distance = mujoco.mj_geomDistance
        self._model = _compiled(shapes, files)
        if not measures_overlaps():
            self._model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_NATIVECCD
        self._data = mujoco.MjData(self._model)
        self._geoms: dict[str, list[int]] = {}
        for index, shape in enumerate(shapes):
            self._geoms.setdefault(shape.link, []).append(index)
        model = self._model
        self._link_from_geom = [
            from_parts(rotation_from_quat(quat), position)
            for quat, position in zip(model.geom_quat, model.geom_pos, strict=True)
        ]

    @property
    def links(self) -> tuple[str, ...]:
        """Links that have a collider, in the order of the shapes."""
        return tuple(self._geoms)

    def place(self, link: str, pose: Array) -> None:
        """Moves the colliders of a link to the link's `pose` (4, 4)."""
        for geom in self._geoms[link]:
            geom_pose = pose @ self._link_from_geom[geom]
            self._data.geom_xpos[geom] = geom_pose[:3, 3]
            self._data.geom_xmat[geom] = geom_pose[:3, :3].ravel()

    def meeting(self, links: Sequence[str]) -> list[Pair]:
        """Returns the pairs of these links, in their order, whose boxes meet at the current poses."""
        if not links:
            return []
        low, high = self._boxes()
        lows = np.array([low[self._geoms[link]].min(axis=0) for link in links])
        highs = np.array([high[self._geoms[link]].max(axis=0) for link in links])
        return [(links[first], links[second]) for first, second in meeting_boxes(lows, highs).tolist()]

    def depths(self, pairs: Sequence[Pair]) -> dict[Pair, Array]:
        """Returns the pairs that touch at the current poses. Each has an array (m, n) of how deep [m] each
        shape of the first link is in each shape of the second: 0 if they only touch, -inf if they do not."""
        low, high = self._boxes()
        depths_of_pairs = {pair: self._depths(pair, low, high) for pair in pairs}
        return {pair: depths for pair, depths in depths_of_pairs.items() if (depths >= 0).any()}

    def touching(self, pair: Pair) -> Mask:
        """Tells whether each shape of the first link touches each shape of the second (m, n) at the current
        poses."""
        low, high = self._boxes(self._geoms[pair[0]] + self._geoms[pair[1]])
        mask: Mask = self._depths(pair, low, high) >= 0
        return mask

    def span(self) -> float:
        """Returns the diagonal [m] of the box around all colliders."""
        low, high = self._boxes()
        return float(np.linalg.norm(high.max(axis=0) - low.min(axis=0)))

    def _separation(self, first: int, second: int) -> float:
        """Returns the distance [m] of two colliders, negative if they overlap; at most 1 mm."""
        distance = self._distance(self._model, self._data, first, second, _MAX_DISTANCE, None)
        if abs(distance) > TOUCH_DISTANCE:
            return float(distance)
        # MuJoCo (at least up to 4.0) says of two geoms with the same centre that they only touch, so one of
        # them is moved a little.
        nudge = _NUDGE * (self._model.geom_rbound[first] + self._model.geom_rbound[second])
        position = self._data.geom_xpos[second].copy()
        self._data.geom_xpos[second] += nudge * _OBLIQUE
        nudged_distance = self._distance(self._model, self._data, first, second, _MAX_DISTANCE, None)
        self._data.geom_xpos[second] = position
        return float(nudged_distance if nudged_distance < -2 * nudge else distance)

    def _depths(self, pair: Pair, low: Array, high: Array) -> Array:
        first, second = (self._geoms[link] for link in pair)
        depths = np.full((len(first), len(second)), -np.inf)
        for row, column in self._meeting_shapes(pair, low, high):
            depth = -self._separation(first[row], second[column])
            if depth >= -TOUCH_DISTANCE:
                depths[row, column] = max(depth, 0.0)
        return depths

    def _meeting_shapes(self, pair: Pair, low: Array, high: Array) -> Iterator[tuple[int, int]]:
        """Yields the pairs of shapes whose boxes meet, by their indices among the shapes of each link."""
        first, second = (np.array(self._geoms[link]) for link in pair)
        meet = (low[first][:, None] <= high[second]) & (low[second] <= high[first][:, None])
        for row, column in np.argwhere(meet.all(axis=2)):
            yield int(row), int(column)

    def _boxes(self, geoms: Sequence[int] | None = None) -> tuple[Array, Array]:
        """Returns the lower and upper corners (n, 3) of the boxes around all colliders. With `geoms`, only
        the boxes of these are computed, and the others are NaN."""
        rows: npt.NDArray[np.intp] = np.arange(self._model.ngeom) if geoms is None else np.array(geoms)
        rotations = self._data.geom_xmat[rows].reshape(-1, 3, 3)
        box = self._model.geom_aabb[rows]
        centres = self._data.geom_xpos[rows] + np.einsum("nij,nj->ni", rotations, box[:, :3])
        half = np.einsum("nij,nj->ni", np.abs(rotations), box[:, 3:]) + TOUCH_DISTANCE
        low, high = np.full((2, self._model.ngeom, 3), np.nan)
        low[rows], high[rows] = centres - half, centres + half
        return low, high


# A cylinder and a box that overlap by more than 0.1 m.
_OVERLAP = """<mujoco><worldbody><geom type="cylinder" size=".1 .1"/>
<geom type="box" size=".1 .1 .05" pos=".05 .02 .01"/></worldbody></mujoco>"""


@functools.cache
def measures_overlaps() -> bool:
    """Tells whether MuJoCo's default method measures how deep convex shapes are in each other. In versions
    3.3.3 and 3.3.4 only an older method does, whose depths are up to a half too large."""
    model = compiled_text(_OVERLAP.encode(), {})
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return bool(mujoco.mj_geomDistance(model, data, 0, 1, _MAX_DISTANCE, None) < -0.1)


def _compiled(shapes: Sequence[Shape], files: Mapping[str, bytes]) -> Any:
    """Returns the model of the colliders, each at its pose in the link."""
    root = element(None, "mujoco")
    asset, world = element(root, "asset"), element(root, "worldbody")
    mesh_files = sorted({shape.file for shape in shapes if shape.file is not None})
    names = {file: f"mesh_{index}" for index, file in enumerate(mesh_files)}
    for file, name in names.items():
        # As a shell, since MuJoCo then does not check the mesh's volume, which does not matter here.
        element(asset, "mesh", name=name, file=file, inertia="shell")
    for shape in shapes:
        _geom(world, shape, names)
    try:
        meshes = {file: files[file] for file in mesh_files}
        return compiled_text(to_bytes(root), meshes)
    except NotCompiled as error:
        msg = f"MuJoCo refuses the colliders: {error}"
        raise MeshError(msg, "contact.self", "contact.self=none needs no analysis of contact") from None


def _geom(world: Element, shape: Shape, names: Mapping[str, str]) -> None:
    primitive = shape.ellipsoid or shape.primitive
    if primitive is None:
        assert shape.file is not None
        element(world, "geom", type="mesh", mesh=names[shape.file])
        return
    radii = 0 if primitive.kind in ("box", "ellipsoid") else 1
    sizes = [*primitive.size[:radii], *(length / 2 for length in primitive.size[radii:])]
    pose = primitive.link_from_shape
    element(
        world,
        "geom",
        type=primitive.kind,
        size=spaced(sizes),
        pos=spaced(pose[:3, 3]),
        quat=spaced(quat_from_rotation(pose[:3, :3])),
    )
