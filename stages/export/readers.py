"""What other readers drop from our files: one table, for the documentation and for the report of a build.

A row is what one version of a reader does with one thing of a format. What was measured was so with that
version, on robots made for it; what is cited has its source.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

if TYPE_CHECKING:
    from linkwright.stages.robot.model.geometry import Geometry
    from linkwright.stages.robot.model.robot import Dof, Robot

Thing = Literal[
    "balls",
    "colliders in STL",
    "cones",
    "damping",
    "effort",
    "fixed base",
    "friction",
    "inertia",
    "keyframes",
    "loops",
    "meshes in STL",
    "relations",
    "velocity",
    "everything",
    "frames",
]
"""What a robot may have that a reader drops."""


@dataclass(frozen=True, slots=True)
class ReaderRow:
    """What `reader`, of a `version`, does with a thing of a `format`; `source`: where that is from, "" where
    it was measured."""

    reader: str
    version: str
    format: str
    thing: Thing
    does: str
    source: str = ""


_DRAKE, _BULLET = ("Drake", "1.51.1"), ("PyBullet", "3.2.7")
_ISAAC = "https://github.com/isaac-sim/IsaacSim/issues/841"
_ROS = "https://docs.ros.org/en/jazzy/p/sdformat_urdf"

READERS: tuple[ReaderRow, ...] = (
    ReaderRow(*_DRAKE, "urdf", "colliders in STL", "refuses the file: `mesh.format: obj` avoids it"),
    ReaderRow(*_DRAKE, "urdf", "friction", "left out, with a warning"),
    ReaderRow(*_DRAKE, "urdf", "effort", "left out: without transmissions it has no actuators"),
    ReaderRow(*_DRAKE, "urdf", "fixed base", "the root link is free until it is welded"),
    ReaderRow(*_DRAKE, "sdf", "colliders in STL", "refuses the file: `mesh.format: obj` avoids it"),
    ReaderRow(*_DRAKE, "sdf", "friction", "left out, without a word"),
    ReaderRow(*_DRAKE, "sdf", "loops", "refuses the file"),
    ReaderRow(*_DRAKE, "sdf", "relations", "left out, without a word: it has them from a URDF"),
    ReaderRow(*_DRAKE, "mjcf", "meshes in STL", "refuses the file: `mesh.format: obj` avoids it"),
    ReaderRow(*_DRAKE, "mjcf", "friction", "left out, with a warning"),
    ReaderRow(*_DRAKE, "mjcf", "effort", "left out, with a warning"),
    ReaderRow(*_DRAKE, "mjcf", "loops", "left open, with a warning: it has no equalities of sites"),
    ReaderRow(*_DRAKE, "mjcf", "relations", "left out, with a warning"),
    ReaderRow(*_DRAKE, "mjcf", "keyframes", "left out, with a warning"),
    ReaderRow(*_BULLET, "urdf", "inertia", "from colliders, unless URDF_USE_INERTIA_FROM_FILE is given"),
    ReaderRow(*_BULLET, "urdf", "relations", "left out, without a word"),
    ReaderRow(*_BULLET, "urdf", "fixed base", "the root link is free, unless useFixedBase is given"),
    ReaderRow(*_BULLET, "urdf", "frames", "1 kg each, unless `export.urdf.frame_inertia` is tiny"),
    ReaderRow(*_BULLET, "sdf", "fixed base", "refuses the file: a joint to the world is unknown to it"),
    ReaderRow(*_BULLET, "sdf", "balls", "refuses the file"),
    ReaderRow(*_BULLET, "mjcf", "everything", "nothing moves: it reads no classes of joints and geoms"),
    ReaderRow("MuJoCo", "4.0.0", "urdf", "velocity", "left out"),
    ReaderRow("MuJoCo", "before 3.13", "urdf", "relations", "left out"),
    ReaderRow(
        "Pinocchio",
        "4.1.0",
        "urdf",
        "relations",
        "followers move freely, unless mimic=True is given, which refuses continuous joints",
    ),
    ReaderRow("sdformat", "12.3", "sdf", "relations", "`<mimic>` is unknown to it, as to Gazebo Fortress"),
    ReaderRow(
        "Gazebo with DART",
        "Harmonic",
        "sdf",
        "relations",
        "left out, with an error; the engine bullet-featherstone has them",
        "https://github.com/gazebosim/gz-physics/issues/432",
    ),
    ReaderRow(
        "Gazebo with DART",
        "all so far",
        "sdf",
        "loops",
        "only those that a fixed joint closes",
        "https://github.com/gazebosim/gz-physics/issues/25",
    ),
    ReaderRow("ROS (sdformat_urdf)", "Jazzy", "sdf", "loops", "refuses the file", _ROS),
    ReaderRow("ROS (sdformat_urdf)", "Jazzy", "sdf", "balls", "refuses the file", _ROS),
    ReaderRow("Newton", "1.8.0", "usd", "keyframes", "starts at zero, unless SchemaResolverPhysx is given"),
    ReaderRow("Newton", "1.8.0", "usd", "cones", "left out, without a word"),
    ReaderRow("PhysX", "ovphysx 0.7.0", "usd", "loops", "pushed at the start, or lost (NaN)"),
    ReaderRow("Isaac Sim", "6.1.0", "urdf", "damping", "left out, without a word", _ISAAC),
    ReaderRow("Isaac Sim", "6.1.0", "urdf", "friction", "left out, without a word", _ISAAC),
)
"""In the order of the page."""

WHOLE: tuple[tuple[str, str, str], ...] = (("yourdfpy", "0.0.60", "urdf"), ("Pinocchio", "4.1.0", "urdf"))
"""Reader, version, format: measured to keep limits, effort, velocity, damping, friction and mimic, the last
in Pinocchio where it is asked for."""


def dropped(robot: "Robot", geometry: "Geometry", formats: Sequence[str]) -> list[dict[str, Any]]:
    """The rows that matter for this robot in these formats, each with the names of the things that it has."""
    names = {thing: tuple(find(robot, geometry)) for thing, find in _FOUND.items()}
    return [
        {
            "reader": row.reader,
            "version": row.version,
            "format": row.format,
            "thing": row.thing,
            "does": row.does,
            "of": list(names[row.thing]),
            "source": row.source or "measured",
        }
        for row in READERS
        if row.format in formats and names[row.thing]
    ]


def _dofs(test: "Callable[[Dof], object]") -> "Callable[[Robot, Geometry], Iterator[str]]":
    return lambda robot, _: (dof.name for dof in robot.dofs if test(dof))


def _files(*roles: str) -> "Callable[[Robot, Geometry], Iterator[str]]":
    """STL files of shapes in these roles."""

    def find(_: "Robot", geometry: "Geometry") -> Iterator[str]:
        files = {shape.file for shape in geometry.shapes if shape.file and shape.role in roles}
        return (name for name in sorted(files) if name.endswith(".stl"))

    return find


_FOUND: Mapping[Thing, "Callable[[Robot, Geometry], Iterator[str]]"] = {
    "balls": _dofs(lambda dof: dof.kind == "ball"),
    "colliders in STL": _files("collision"),
    "cones": _dofs(lambda dof: dof.kind == "ball" and dof.limits.upper is not None),
    "damping": _dofs(lambda dof: dof.dynamics.damping),
    "effort": _dofs(lambda dof: dof.dynamics.effort),
    "fixed base": lambda robot, _: iter([robot.root.name] * robot.base.fixed),
    "friction": _dofs(lambda dof: dof.dynamics.friction),
    "inertia": lambda robot, _: (link.name for link in robot.links if link.inertial.mass),
    "keyframes": lambda robot, _: iter(("home", "cad") if robot.dofs else ()),
    "loops": lambda robot, _: (loop.name for loop in robot.loops),
    "meshes in STL": _files("visual", "collision"),
    "relations": lambda robot, _: (relation.follower for relation in robot.relations),
    "velocity": _dofs(lambda dof: dof.dynamics.velocity),
    "everything": lambda robot, _: (joint.name for joint in robot.joints if joint.dofs),
    "frames": lambda robot, _: (frame.name for frame in robot.frames),
}
"""Thing → the names of those that a robot has."""
