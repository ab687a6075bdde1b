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

    without: "tuple[PrimitiveKind, ...]" = ()
    """The kinds of primitives that colliders must not be."""

    hull: int | None = None
    """The largest number of vertices of a collider that is a mesh; None without a limit."""

    obj: bool = False
    """Whether meshes must be OBJ files."""

    def vertices(self, limit: int) -> int:
        """Returns the largest number of vertices of a hull, with the configuration's `limit`."""
        return limit if self.hull is None else min(limit, self.hull)


NO_LIMITS = ShapeLimits()
"""The limits of engines that accept every collider."""


@dataclass(frozen=True, slots=True)
class TargetEngine:
    """An engine that a build can be made for."""

    readers: tuple[str, ...]
    """Its names in the table of readers."""

    reads: tuple[str, ...]
    """The formats that it reads, the best first."""

    mujoco: MujocoVersion | None = None
    """The version of MuJoCo that compiles its models; None for an engine without MuJoCo."""

    shapes: ShapeLimits = NO_LIMITS
    """Its limits of shapes."""

    def format(self, written: Collection[str]) -> str | None:
        """Returns the best of the written formats that the engine reads, or None."""
        return next((name for name in self.reads if name in written), None)


ENGINES: Mapping[str, TargetEngine] = {
    "mjx": TargetEngine(("MJX",), ("mjcf", "urdf"), "3.17", ShapeLimits(("cylinder", "ellipsoid"), hull=32)),
    "mjwarp": TargetEngine(("MuJoCo Warp",), ("mjcf", "urdf"), "4.0"),
    "mujoco": TargetEngine(("MuJoCo",), ("mjcf", "urdf"), "4.0"),
    "newton": TargetEngine(("Newton",), ("usd", "mjcf", "urdf")),
    "isaac": TargetEngine(("Isaac Sim", "PhysX"), ("usd", "urdf")),
    "gazebo": TargetEngine(("Gazebo with DART",), ("sdf",)),
    "pybullet": TargetEngine(("PyBullet",), ("urdf",)),
    "drake": TargetEngine(("Drake",), ("urdf", "sdf", "mjcf"), shapes=ShapeLimits(obj=True)),
}
"""The engines, by the keys of `target`."""


def shape_limits(targets: Collection[str]) -> ShapeLimits:
    """Returns the limits that shapes must keep for all of these targets."""
    limits = [ENGINES[name].shapes for name in targets]
    hulls = [shapes.hull for shapes in limits if shapes.hull is not None]
    kinds = tuple(sorted({kind for shapes in limits for kind in shapes.without}))
    return ShapeLimits(kinds, min(hulls, default=None), any(shapes.obj for shapes in limits))
