"""Lists the engines that a build can be made for, and combines the limits of their shapes."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:  # numpy comes with it
    from linkwright.stages.robot.model.robot import PrimitiveKind

MujocoVersion = Literal["3.11", "3.16", "3.17", "4.0"]
"""The versions of MuJoCo whose elements and attributes are known."""


@dataclass(frozen=True, slots=True)
class ShapeLimits:
    """The limits that engines set to shapes."""

    excluded_kinds: "tuple[PrimitiveKind, ...]" = ()
    """The kinds of primitives that colliders must not be."""

    max_hull_vertices: int | None = None
    """The largest number of vertices of a collider that is a mesh; None without a limit."""

    needs_obj: bool = False
    """Whether meshes must be OBJ files."""

    def vertices(self, limit: int) -> int:
        """Returns the largest number of vertices of a hull: the configuration's `limit`, or that of the
        engines if it is smaller."""
        return limit if self.max_hull_vertices is None else min(limit, self.max_hull_vertices)


NO_LIMITS = ShapeLimits()
"""The limits of engines that accept every collider."""


@dataclass(frozen=True, slots=True)
class TargetEngine:
    """An engine that a build can be made for."""

    readers: tuple[str, ...]
    """The engine's names in the table of readers."""

    reads: tuple[str, ...]
    """The formats that the engine reads, the best first."""

    mujoco: MujocoVersion | None = None
    """The version of MuJoCo that compiles the engine's models; None for an engine without MuJoCo."""

    shapes: ShapeLimits = NO_LIMITS
    """The engine's limits of shapes."""

    def format(self, written: Collection[str]) -> str | None:
        """Returns the best of the written formats that the engine reads, or None."""
        return next((name for name in self.reads if name in written), None)


ENGINES: Mapping[str, TargetEngine] = {
    "mjx": TargetEngine(
        ("MJX",), ("mjcf", "urdf"), "3.17", ShapeLimits(("cylinder", "ellipsoid"), max_hull_vertices=32)
    ),
    "mjwarp": TargetEngine(("MuJoCo Warp",), ("mjcf", "urdf"), "4.0"),
    "mujoco": TargetEngine(("MuJoCo",), ("mjcf", "urdf"), "4.0"),
    "newton": TargetEngine(("Newton",), ("usd", "mjcf", "urdf")),
    "isaac": TargetEngine(("Isaac Sim", "PhysX"), ("usd", "urdf")),
    "gazebo": TargetEngine(("Gazebo with DART",), ("sdf",)),
    "pybullet": TargetEngine(("PyBullet",), ("urdf",)),
    "drake": TargetEngine(("Drake",), ("urdf", "sdf", "mjcf"), shapes=ShapeLimits(needs_obj=True)),
}
"""The engines, by the keys of `target`."""


def shape_limits(targets: Collection[str]) -> ShapeLimits:
    """Returns the limits that shapes must keep for all of these targets."""
    limits = [ENGINES[name].shapes for name in targets]
    vertex_limits = [shapes.max_hull_vertices for shapes in limits if shapes.max_hull_vertices is not None]
    kinds = tuple(sorted({kind for shapes in limits for kind in shapes.excluded_kinds}))
    return ShapeLimits(kinds, min(vertex_limits, default=None), any(shapes.needs_obj for shapes in limits))
