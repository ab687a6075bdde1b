"""The robot that a robot.json describes, and all else that its files are checked against.

Not in it, since nothing that is checked needs it: the meshes of parts, diagnostics, the source's own words
for what drives it (`controls`), and its own actuators and sensors apart from those that the files have.
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
from linkwright.stages.robot.dynamics.driven import as_driven
from linkwright.stages.robot.model.amendments import Amendments
from linkwright.stages.robot.model.mjcf_extras import MjcfElement
from linkwright.stages.robot.model.robot import Joint, Link, Robot

PACKAGES = ("ros2", "python")
"""The tables of packages that are written from the other files."""

MOST_ROWS = 20_000
"""Of links, joints and all else that a robot has."""

DEEPEST = 200
"""Elements in each other that are read."""


@dataclass(frozen=True, slots=True)
class Truth:
    """What the files of a robot must say: the robot as it is `written` (its `srdf_form` is None of an older
    build); `files`: the paths of those that there are, but for those of a Python package; `packages`: by
    format, those that are written from the other files."""

    written: Written
    files: tuple[str, ...]
    packages: Mapping[str, PackageRecord]


def described(data: bytes) -> Truth:
    """What a robot.json says. RobotJsonError where that is no robot, or one of another version."""
    try:
        table = json.loads(data)
        record = _record(table)
    except RecursionError:
        msg = "its tables are too deep in each other"
        raise RobotJsonError(msg) from None
    except ValueError as error:
        msg = f"it is no JSON: {error}"
        raise RobotJsonError(msg) from None
    robot = record.to_model()
    _require_tree(robot.links, robot.joints)
    _require_single_names(robot)
    extras = robot.mjcf
    if extras is not None:
        mounted = (one.element for one in extras.mounted)
        _require_shallow((*mounted, *extras.sections, *extras.scene))
    found = {name: getattr(record, name) for name in PACKAGES}
    packages = {name: package for name, package in found.items() if package is not None}
    folders = [path for one in packages.values() for path in (one.package, one.folder) if path]
    _require_inside(robot.name, *record.files, *folders)
    actuation = record.actuation.to_model()
    written = Written(
        robot=as_driven(robot, actuation),
        actuation=actuation,
        geometry=record.geometry,
        urdf_form=UrdfForm(
            merged=bool(record.merged),
            couplings=modelled(record.couplings),
            closed=tuple(loop.name for loop in record.loops if loop.mimic),
            package=record.urdf.package if record.urdf else "",
        ),
        mjcf_form=MjcfForm(tuple(held.link for held in record.fused), extras),
        sensing=record.sensing.to_model(),
        amendments=Amendments(record.amendments, record.surplus),
        scene=modelled(record.scene),
        srdf_form=_srdf(record.srdf) if record.srdf else None,
    )
    return Truth(written, record.files, packages)


def _srdf(record: SrdfRecord) -> SrdfForm:
    pairs = ((first, second) for first, others in record.never.items() for second in others)
    return SrdfForm(frozenset(pairs), record.end_effectors)


def _record(table: Any) -> RobotRecord:
    if not isinstance(table, Mapping):
        return read(RobotRecord, table, {})
    if table.get("format") != FORMAT:
        msg = "it is no robot.json of Linkwright"
        raise RobotJsonError(msg)
    if table.get("version") != VERSION:
        msg = f"its version is {table.get('version')}; this program reads version {VERSION}"
        raise RobotJsonError(msg)
    for name in ("links", "joints", "loops", "relations", "frames", "keyframes"):
        if len(_rows(table, name)) > MOST_ROWS:
            msg = f"{name}: {len(_rows(table, name))} rows; at most {MOST_ROWS} are read"
            raise RobotJsonError(msg)
    joints = [*_rows(table, "joints"), *_rows(table, "loops")]
    dofs = [dof for joint in joints for dof in _rows(joint, "dofs")]
    return read(RobotRecord, table, {"link": _names(_rows(table, "links")), "joint": _names(dofs)})


def _rows(table: Any, key: str) -> list[Any]:
    """The rows of a table that may be anything."""
    rows = table.get(key) if isinstance(table, Mapping) else None
    return rows if isinstance(rows, list) else []


def _names(rows: list[Any]) -> set[str]:
    named = [row["name"] for row in rows if isinstance(row, Mapping) and "name" in row]
    return {name for name in named if isinstance(name, str)}


def _require_inside(*paths: str) -> None:
    """That nothing outside of the folder is looked at, whatever the file names."""
    for path in paths:
        parts = PurePosixPath(path).parts
        if not parts or path.startswith("/") or ".." in parts or "\\" in path or "\0" in path:
            msg = f"{path!r} is no path below its folder"
            raise RobotJsonError(msg)


def _require_tree(links: tuple[Link, ...], joints: tuple[Joint, ...]) -> None:
    """Each link but the first is the child of one joint, which comes after that of its parent."""
    known = {link.name for link in links[:1]}
    for joint in joints:
        if joint.parent not in known or joint.child in known:
            msg = f"joints: {joint.name!r} is between {joint.parent!r} and {joint.child!r}, which is no tree"
            raise RobotJsonError(msg)
        known.add(joint.child)
    if not links or len(known) != len(links) or known != {link.name for link in links}:
        msg = "links: expected the root and the children of all joints"
        raise RobotJsonError(msg)


def _require_single_names(robot: Robot) -> None:
    loops = [dof.name for loop in robot.loops for dof in loop.dofs]
    for what, names in (
        ("links", [link.name for link in robot.links]),
        ("joints", [*(dof.name for dof in robot.dofs), *loops]),
    ):
        twice = sorted(name for name, number in Counter(names).items() if number > 1)
        if twice:
            msg = f"{what}: {twice[0]!r} is there twice"
            raise RobotJsonError(msg)


def _require_shallow(elements: tuple[MjcfElement, ...]) -> None:
    for _ in range(DEEPEST + 1):
        elements = tuple(child for element in elements for child in element.children)
    if elements:
        msg = f"mjcf: elements are more than {DEEPEST} deep in each other"
        raise RobotJsonError(msg)
