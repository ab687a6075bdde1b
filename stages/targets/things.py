"""Finds the things in a robot that some readers drop, by the table of readers."""

from collections.abc import Callable, Iterator, Mapping, Sequence, Set
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from linkwright.stages.robot.motion.start_pose import starting_point
from linkwright.stages.targets.engines import ENGINES
from linkwright.stages.targets.readers import READERS, rows_of
from linkwright.stages.targets.row import ReaderRow, Thing

if TYPE_CHECKING:
    from linkwright.stages.robot.model.geometry import Geometry
    from linkwright.stages.robot.model.robot import Dof, Robot


def reader_rows_of_robot(
    robot: "Robot",
    geometry: "Geometry",
    formats: Sequence[str],
    targets: Mapping[str, str | None] = MappingProxyType({}),
) -> list[dict[str, Any]]:
    """Returns the rows of the table of readers about things that this robot has, in these formats. Each lists
    the names of these things (`of`). A row about one of the `targets` (name → version of MuJoCo) also says
    how the build responds (`target`)."""
    names = _names_by_thing(robot, geometry)
    targeted = {
        row
        for name, version in targets.items()
        for form in ENGINES[name].reads
        for row in rows_of(name, form, version)
    }
    return [
        {
            "reader": row.reader,
            "version": row.version,
            "format": row.format,
            "thing": row.thing,
            "does": row.does,
            "of": names[row.thing],
            "source": row.source or row.evidence,
            **({"target": row.response} if row in targeted else {}),
        }
        for row in READERS
        if row.format in formats and names.get(row.thing)
    ]


def names_in_robot(row: ReaderRow, robot: "Robot", geometry: "Geometry") -> list[str]:
    """Returns the names of the things that a row concerns in a robot; an empty list for things that are found
    only in files."""
    find = _FINDERS.get(row.thing)
    return [*find(robot, geometry)] if find is not None else []


def _names_by_thing(robot: "Robot", geometry: "Geometry") -> dict[Thing, list[str]]:
    """Returns, for each thing in `_FINDERS`, the names of such things in a robot."""
    return {thing: [*find(robot, geometry)] for thing, find in _FINDERS.items()}


def _dofs_with(test: "Callable[[Dof], object]") -> "Callable[[Robot, Geometry], Iterator[str]]":
    """Returns a function that finds the dofs that pass a test."""
    return lambda robot, _: (dof.name for dof in robot.dofs if test(dof))


def _stl_files(*roles: str) -> "Callable[[Robot, Geometry], Iterator[str]]":
    """Returns a function that finds the STL files of shapes in these roles."""

    def find(_: "Robot", geometry: "Geometry") -> Iterator[str]:
        files = {shape.file for shape in geometry.shapes if shape.file and shape.role in roles}
        return (name for name in sorted(files) if name.endswith(".stl"))

    return find


_FINDERS: Mapping[Thing, "Callable[[Robot, Geometry], Iterator[str]]"] = {
    "balls": _dofs_with(lambda dof: dof.kind == "ball"),
    "colliders in STL": _stl_files("collision"),
    "cones": _dofs_with(lambda dof: dof.kind == "ball" and dof.limits.upper is not None),
    "damping": _dofs_with(lambda dof: dof.dynamics.damping),
    "effort": _dofs_with(lambda dof: dof.dynamics.effort),
    # The joints that move are what such a reader loses.
    "everything": lambda robot, _: (joint.name for joint in robot.joints if joint.dofs),
    "fixed base": lambda robot, _: iter([robot.root.name] if robot.base.fixed else []),
    "frames": lambda robot, _: (frame.name for frame in robot.frames),
    "friction": _dofs_with(lambda dof: dof.dynamics.friction),
    "inertia": lambda robot, _: (link.name for link in robot.links if link.inertial.mass),
    "keyframes": lambda robot, _: iter(("home", "cad") if robot.dofs else ()),
    "loops": lambda robot, _: (loop.name for loop in robot.loops),
    "meshes in STL": _stl_files("visual", "collision"),
    "relations": lambda robot, _: (relation.follower for relation in robot.relations),
    "saturated servos": _dofs_with(lambda dof: dof.dynamics.effort),
    "starts of joints": lambda robot, _: (
        name for name, value in starting_point(robot).items() if isinstance(value, float) and value
    ),
    "velocity": _dofs_with(lambda dof: dof.dynamics.velocity),
    "visuals in GLB": lambda _, geometry: iter(sorted({str(whole.file) for whole in geometry.whole_visuals})),
}
"""Thing → a function that finds the names of such things in a robot. Other things are found only in its
files."""

THINGS_OF_ROBOTS: Set[Thing] = _FINDERS.keys()
"""The things that are found in a robot: the report of a build lists their names."""
