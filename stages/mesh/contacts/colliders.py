"""The robot's colliders in MuJoCo: how deep those of two links are in each other, at any pose.

MuJoCo takes a mesh as its convex hull, here as in a simulation.
"""

import functools
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from linkwright.stages.formats.numbers import spaced
from linkwright.stages.formats.xml import Element, element, to_bytes
from linkwright.stages.mesh.contacts.narrow import Mask
from linkwright.stages.robot.contact.meeting_boxes import meeting_boxes
from linkwright.stages.robot.errors import MeshError
from linkwright.stages.robot.model.geometry import Shape
from linkwright.stages.robot.model.poses import from_parts, quat_from_rotation, rotation_from_quat
from linkwright.stages.robot.model.robot import Array
from linkwright.stages.robot.motion.adjacency import Pair

TOUCHING = 1e-6
"""Colliders touch that are no further apart than this [m]: single precision moves faces that much."""

_FAR = 1e-3
_NUDGE = 1e-4
_ASKEW = np.array([0.48, 0.64, 0.6])
"""A unit vector along no axis."""


class Colliders:
    """The colliders of all links, compiled once."""

    def __init__(self, shapes: Sequence[Shape], files: Mapping[str, bytes]) -> None:
        """MeshError where MuJoCo refuses one."""
        # Late: a part from the cache needs no library that makes colliders or decimates.
        import mujoco

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
            from_parts(rotation_from_quat(quat), place)
            for quat, place in zip(model.geom_quat, model.geom_pos, strict=True)
        ]

    @property
    def links(self) -> tuple[str, ...]:
        """The links that have a collider, in the order of the shapes."""
        return tuple(self._geoms)

    def place(self, link: str, pose: Array) -> None:
        """Puts the colliders of a link where its frame is at `pose` (4, 4)."""
        for geom in self._geoms[link]:
            where = pose @ self._link_from_geom[geom]
            self._data.geom_xpos[geom] = where[:3, 3]
            self._data.geom_xmat[geom] = where[:3, :3].ravel()

    def meeting(self, links: Sequence[str]) -> list[Pair]:
        """The pairs of these links, in their order, whose boxes meet where the links were placed last."""
        if not links:
            return []
        low, high = self._boxes()
        lows = np.array([low[self._geoms[link]].min(axis=0) for link in links])
        highs = np.array([high[self._geoms[link]].max(axis=0) for link in links])
        return [(links[one], links[other]) for one, other in meeting_boxes(lows, highs).tolist()]

    def depths(self, pairs: Sequence[Pair]) -> dict[Pair, Array]:
        """Of each pair that touches where the links were placed last, how deep [m] each shape of the one
        (m) is in each of the other (n): 0 where they only touch, -inf where they do not."""
        low, high = self._boxes()
        found = {pair: self._depths(pair, low, high) for pair in pairs}
        return {pair: depths for pair, depths in found.items() if (depths >= 0).any()}

    def touching(self, pair: Pair) -> Mask:
        """Whether each shape of the one link (m) touches each of the other (n) where they are now."""
        low, high = self._boxes(self._geoms[pair[0]] + self._geoms[pair[1]])
        found: Mask = self._depths(pair, low, high) >= 0
        return found

    def span(self) -> float:
        """The diagonal [m] of the box around all colliders."""
        low, high = self._boxes()
        return float(np.linalg.norm(high.max(axis=0) - low.min(axis=0)))

    def _apart(self, one: int, other: int) -> float:
        """The distance [m] of two colliders, negative where they overlap; no more than 1 mm."""
        found = self._distance(self._model, self._data, one, other, _FAR, None)
        if abs(found) > TOUCHING:
            return float(found)
        # The middle of one in the middle of the other passes for touching (at least up to MuJoCo 4.0): only a
        # little further away it does not.
        nudge = _NUDGE * (self._model.geom_rbound[one] + self._model.geom_rbound[other])
        place = self._data.geom_xpos[other].copy()
        self._data.geom_xpos[other] += nudge * _ASKEW
        deeper = self._distance(self._model, self._data, one, other, _FAR, None)
        self._data.geom_xpos[other] = place
        return float(deeper if deeper < -2 * nudge else found)

    def _depths(self, pair: Pair, low: Array, high: Array) -> Array:
        first, second = (self._geoms[link] for link in pair)
        found = np.full((len(first), len(second)), -np.inf)
        for row, column in self._near(pair, low, high):
            depth = -self._apart(first[row], second[column])
            if depth >= -TOUCHING:
                found[row, column] = max(depth, 0.0)
        return found

    def _near(self, pair: Pair, low: Array, high: Array) -> Iterator[tuple[int, int]]:
        """The colliders of two links whose boxes meet, by their positions among those of each."""
        first, second = (np.array(self._geoms[link]) for link in pair)
        meet = (low[first][:, None] <= high[second]) & (low[second] <= high[first][:, None])
        for row, column in np.argwhere(meet.all(axis=2)):
            yield int(row), int(column)

    def _boxes(self, geoms: Sequence[int] | None = None) -> tuple[Array, Array]:
        """The lower and upper corners (n, 3) of the boxes around all colliders; only those of `geoms`
        are right, where they are given."""
        rows: npt.NDArray[np.intp] = np.arange(self._model.ngeom) if geoms is None else np.array(geoms)
        turned = self._data.geom_xmat[rows].reshape(-1, 3, 3)
        box = self._model.geom_aabb[rows]
        middle = self._data.geom_xpos[rows] + np.einsum("nij,nj->ni", turned, box[:, :3])
        half = np.einsum("nij,nj->ni", np.abs(turned), box[:, 3:]) + TOUCHING
        low, high = np.full((2, self._model.ngeom, 3), np.nan)
        low[rows], high[rows] = middle - half, middle + half
        return low, high


_OVERLAP = """<mujoco><worldbody><geom type="cylinder" size=".1 .1"/>
<geom type="box" size=".1 .1 .05" pos=".05 .02 .01"/></worldbody></mujoco>"""


@functools.cache
def measures_overlaps() -> bool:
    """Whether MuJoCo finds how deep convex shapes are in each other. Versions 3.3.3 and 3.3.4 do so only
    with their older method, whose depths are up to a half too large."""
    # Late: a part from the cache needs no library that makes colliders or decimates.
    import mujoco

    from linkwright.stages.mujoco.compile import compiled_text

    model = compiled_text(_OVERLAP.encode(), {})
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return bool(mujoco.mj_geomDistance(model, data, 0, 1, _FAR, None) < -0.1)


def _compiled(shapes: Sequence[Shape], files: Mapping[str, bytes]) -> Any:
    """The model of the colliders, each where it is in its link's frame."""
    # Late: a part from the cache needs no library that makes colliders or decimates.
    from linkwright.stages.mujoco.compile import NotCompiled, compiled_text

    root = element(None, "mujoco")
    asset, world = element(root, "asset"), element(root, "worldbody")
    used = sorted({shape.file for shape in shapes if shape.file is not None})
    names = {file: f"mesh_{index}" for index, file in enumerate(used)}
    for file, name in names.items():
        # A shell, so that MuJoCo asks nothing of a volume which does not matter here.
        element(asset, "mesh", name=name, file=file, inertia="shell")
    for shape in shapes:
        _geom(world, shape, names)
    try:
        meshes = {file: files[file] for file in used}
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
