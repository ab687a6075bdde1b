"""Reads the robot that a robot.json describes, and the other values that its files are checked against.

Left out, since no check needs them, are the meshes of parts, diagnostics, the source's own text about its
drives (`controls`), and its own actuators and sensors apart from those that the files have.
"""

import json
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import PurePosixPath
from typing import Any

from linkwright.stages.formats.mjcf.form import MjcfForm
from linkwright.stages.formats.robot_json import FORMAT, VERSION
from linkwright.stages.formats.robot_json.codec import RobotJsonError, modelled, read
from linkwright.stages.formats.robot_json.files import PackageRecord, SrdfRecord
from linkwright.stages.formats.robot_json.robot import RobotRecord
from linkwright.stages.formats.urdf.form import UrdfForm
from linkwright.stages.formats.urdf.srdf_form import SrdfForm
from linkwright.stages.formats.written import Written
from linkwright.stages.robot.dynamics.driven import with_actuation
from linkwright.stages.robot.model.amendments import Amendments
from linkwright.stages.robot.model.mjcf_extras import MjcfElement
from linkwright.stages.robot.model.robot import Joint, Link, Robot

PACKAGES = ("ros2", "python")
"""The keys of the packages that are written from the other files."""

MAX_ROWS = 20_000
"""Largest number of rows of a table: of links, joints and other things of a robot."""

MAX_DEPTH = 200
"""Largest depth of nested elements that are read."""


@dataclass(frozen=True, slots=True)
class Truth:
    """The content that the files of a robot must have."""

    written: Written
    """The robot as its files have it; its `srdf_form` is None for an older build."""

    files: tuple[str, ...]
    """The paths of the robot's other files, except those of a Python package."""

    packages: Mapping[str, PackageRecord]
    """Format → the package that is written from the other files."""


def read_robot_json(data: bytes) -> Truth:
    """Returns the robot in the bytes of a robot.json, and what else its files must have.

    Raises RobotJsonError if they are not JSON, are of another version, or are not a valid robot.
    """
    try:
        table = json.loads(data)
        record = _record(table)
    except RecursionError:
        msg = "its tables are nested too deeply"
        raise RobotJsonError(msg) from None
    except ValueError as error:
        msg = f"it is not JSON: {error}"
        raise RobotJsonError(msg) from None
    robot = record.to_model()
    _require_tree(robot.links, robot.joints)
    _require_single_names(robot)
    extras = robot.mjcf
    if extras is not None:
        mounted_elements = (mounted.element for mounted in extras.mounted)
        _require_shallow((*mounted_elements, *extras.sections, *extras.scene))
    tables = {name: getattr(record, name) for name in PACKAGES}
    packages = {name: package for name, package in tables.items() if package is not None}
    folders = [path for package in packages.values() for path in (package.package, package.folder) if path]
    _require_inside(robot.name, *record.files, *folders)
    actuation = record.actuation.to_model()
    written = Written(
        robot=with_actuation(robot, actuation),
        actuation=actuation,
        geometry=record.geometry,
        urdf_form=UrdfForm(
            merged=bool(record.merged),
            couplings=modelled(record.couplings),
            closed=tuple(loop.name for loop in record.loops if loop.mimic),
            package=record.urdf.package if record.urdf else "",
        ),
        mjcf_form=MjcfForm(tuple(fused.link for fused in record.fused), extras),
        sensing=record.sensing.to_model(),
        amendments=Amendments(record.amendments, record.surplus),
        scene=modelled(record.scene),
        srdf_form=_srdf_form(record.srdf) if record.srdf else None,
    )
    return Truth(written, record.files, packages)


def _srdf_form(record: SrdfRecord) -> SrdfForm:
    """Returns the content that only the SRDF has."""
    pairs = ((first, second) for first, later in record.never.items() for second in later)
    return SrdfForm(frozenset(pairs), record.end_effectors)


def _record(table: Any) -> RobotRecord:
    """Returns the record in parsed JSON. Raises RobotJsonError for an invalid or too large table."""
    if not isinstance(table, Mapping):
        return read(RobotRecord, table, {})
    if table.get("format") != FORMAT:
        msg = "it is not a robot.json of Linkwright"
        raise RobotJsonError(msg)
    if table.get("version") != VERSION:
        msg = f"its version is {table.get('version')}; this program reads version {VERSION}"
        raise RobotJsonError(msg)
    for name in ("links", "joints", "loops", "relations", "frames", "keyframes"):
        if len(_rows(table, name)) > MAX_ROWS:
            msg = f"{name}: {len(_rows(table, name))} rows; at most {MAX_ROWS} are read"
            raise RobotJsonError(msg)
    joints = [*_rows(table, "joints"), *_rows(table, "loops")]
    dofs = [dof for joint in joints for dof in _rows(joint, "dofs")]
    return read(RobotRecord, table, {"link": _names(_rows(table, "links")), "joint": _names(dofs)})


def _rows(table: Any, key: str) -> list[Any]:
    """Returns the list at `key` of a table; empty if there is none, or `table` is not a table."""
    rows = table.get(key) if isinstance(table, Mapping) else None
    return rows if isinstance(rows, list) else []


def _names(rows: list[Any]) -> set[str]:
    """Returns the names in rows that may be invalid."""
    names = [row["name"] for row in rows if isinstance(row, Mapping) and "name" in row]
    return {name for name in names if isinstance(name, str)}


def _require_inside(*paths: str) -> None:
    """Raises RobotJsonError for a path that is not below the robot's folder, so that no such file is read."""
    for path in paths:
        parts = PurePosixPath(path).parts
        if not parts or path.startswith("/") or ".." in parts or "\\" in path or "\0" in path:
            msg = f"{path!r} is not a path below its folder"
            raise RobotJsonError(msg)


def _require_tree(links: tuple[Link, ...], joints: tuple[Joint, ...]) -> None:
    """Raises RobotJsonError unless each link except the first is the child of a single joint, which comes
    after the joint of its parent."""
    reached = {link.name for link in links[:1]}
    for joint in joints:
        if joint.parent not in reached or joint.child in reached:
            ends = f"{joint.parent!r} and {joint.child!r}"
            msg = f"joints: {joint.name!r} connects {ends}, so the links do not form a tree"
            raise RobotJsonError(msg)
        reached.add(joint.child)
    if not links or len(reached) != len(links) or reached != {link.name for link in links}:
        msg = "links: expected the root and the children of all joints"
        raise RobotJsonError(msg)


def _require_single_names(robot: Robot) -> None:
    """Raises RobotJsonError if two links, or two degrees of freedom, have the same name."""
    loop_dofs = [dof.name for loop in robot.loops for dof in loop.dofs]
    for kind, names in (
        ("links", [link.name for link in robot.links]),
        ("joints", [*(dof.name for dof in robot.dofs), *loop_dofs]),
    ):
        repeated_names = sorted(name for name, count in Counter(names).items() if count > 1)
        if repeated_names:
            msg = f"{kind}: {repeated_names[0]!r} is there twice"
            raise RobotJsonError(msg)


def _require_shallow(elements: tuple[MjcfElement, ...]) -> None:
    """Raises RobotJsonError if elements are nested too deeply for recursive functions."""
    for _ in range(MAX_DEPTH + 1):
        elements = tuple(child for element in elements for child in element.children)
    if elements:
        msg = f"mjcf: elements are nested more than {MAX_DEPTH} levels deep"
        raise RobotJsonError(msg)
