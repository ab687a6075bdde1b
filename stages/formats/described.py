"""The robot that a robot.json describes, and all else that its files are checked against.

Not in it, since nothing that is checked needs it: the meshes of parts, diagnostics, the source's own words
for what drives it (`controls`), and its own actuators and sensors apart from those that the files have.
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import PurePosixPath

from stages.formats.mjcf_form import MjcfForm
from stages.formats.robot_json.driving import actuation_of, sensing_of, transmission_of
from stages.formats.robot_json.fields import Fields, RobotJsonError
from stages.formats.robot_json.joints import frame_of, joint_of, keyframe_of, loop_of, relation_of
from stages.formats.robot_json.links import link_of
from stages.formats.robot_json.mjcf import extras_of
from stages.formats.robot_json.references import require_names
from stages.formats.robot_json.scene import scene_of
from stages.formats.robot_json.semantics import semantics_of
from stages.formats.robot_json.shapes import geometry_of
from stages.formats.urdf.form import UrdfForm
from stages.formats.urdf.srdf_form import SrdfForm
from stages.formats.written import Written
from stages.robot.amendments import Amendment, Amendments, Surplus
from stages.robot.driven import as_driven
from stages.robot.linear_coupling import LinearCoupling
from stages.robot.model import Base, Joint, Link, Mobility, Provenance, Robot

FORMAT, VERSION = "linkwright-robot", 1

PACKAGES = ("ros2", "python")
"""The tables of packages that are written from the other files."""

MOST_ROWS = 20_000
"""Of links, joints and all else that a robot has."""


@dataclass(frozen=True, slots=True)
class PackageRecord:
    """A package that is written from the other files. `package`: its name; `writer`: the version of its
    writer, 0 of an older build; `folder`: that of the robot's files in it, "" where these are no copies."""

    package: str
    writer: int
    folder: str


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
        record = Fields(json.loads(data))
    except (ValueError, RecursionError) as error:
        msg = f"it is no JSON: {error}"
        raise RobotJsonError(msg) from None
    _require_version(record)
    robot = _robot(record)
    require_names(record, robot)
    files = record.texts("files") if record.has("files") else ()
    _require_inside(robot.name, *files)
    loops = record.records("loops")
    actuation = actuation_of(record)
    written = Written(
        robot=as_driven(robot, actuation),
        actuation=actuation,
        geometry=geometry_of(record),
        urdf_form=UrdfForm(
            merged=bool(record.records("merged")),
            couplings=tuple(_coupling(one) for one in record.records("couplings")),
            closed=tuple(one.text("name") for one in loops if one.truth("mimic")),
            package=record.inside("urdf").text("package") if record.has("urdf") else "",
        ),
        mjcf_form=MjcfForm(tuple(one.text("link") for one in record.records("fused")), robot.mjcf),
        sensing=sensing_of(record),
        amendments=Amendments(
            tuple(_amendment(one) for one in record.records("amendments")),
            tuple(_surplus(one) for one in record.records("surplus")),
        ),
        scene=scene_of(record),
        srdf_form=_srdf(record.inside("srdf")) if record.has("srdf") else None,
    )
    packages = {name: _package(record.inside(name)) for name in PACKAGES if record.has(name)}
    return Truth(written, files, packages)


def _srdf(record: Fields) -> SrdfForm:
    never = record.inside("never")
    pairs = frozenset((first, second) for first in never.table for second in never.texts(first))
    return SrdfForm(pairs, record.texts("end_effectors"))


def _package(record: Fields) -> PackageRecord:
    folder = record.text("folder") if record.has("folder") else ""
    _require_inside(*filter(None, [record.text("package"), folder]))
    return PackageRecord(
        record.text("package"), record.whole("writer") if record.has("writer") else 0, folder
    )


def _require_version(record: Fields) -> None:
    if record.table.get("format") != FORMAT:
        msg = "it is no robot.json of Linkwright"
        raise RobotJsonError(msg)
    if record.table.get("version") != VERSION:
        msg = f"its version is {record.table.get('version')}; this program reads version {VERSION}"
        raise RobotJsonError(msg)


def _require_inside(*paths: str) -> None:
    """That nothing outside of the folder is looked at, whatever the file names."""
    for path in paths:
        parts = PurePosixPath(path).parts
        if not parts or path.startswith("/") or ".." in parts or "\\" in path or "\0" in path:
            msg = f"{path!r} is no path below its folder"
            raise RobotJsonError(msg)


def _robot(record: Fields) -> Robot:
    for table in ("links", "joints", "loops", "relations", "frames", "keyframes"):
        rows = len(record.records(table))
        if rows > MOST_ROWS:
            msg = f"{table}: {rows} rows; at most {MOST_ROWS} are read"
            raise RobotJsonError(msg)
    links = tuple(link_of(one) for one in record.records("links"))
    joints = tuple(joint_of(one) for one in record.records("joints"))
    _require_tree(links, joints)
    base, source = record.inside("base"), record.inside("source")
    keyframes = (keyframe_of(one) for one in record.records("keyframes"))
    return Robot(
        name=record.text("name"),
        links=links,
        joints=joints,
        loops=tuple(loop_of(one) for one in record.records("loops")),
        relations=tuple(relation_of(one) for one in record.records("relations")),
        frames=tuple(frame_of(one) for one in record.records("frames")),
        base=Base(base.truth("fixed"), base.text("reason"), base.text("joint") if base.has("joint") else ""),
        world_from_root=record.pose("root_pose"),
        mobility=_mobility(record.inside("mobility")),
        provenance=Provenance(
            *(source.text(key) for key in ("document", "element", "microversion", "configuration"))
        ),
        transmissions=tuple(transmission_of(one) for one in record.records("transmissions")),
        keyframes=tuple(one for one in keyframes if one is not None),
        semantics=semantics_of(record),
        mjcf=extras_of(record),
    )


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


def _mobility(record: Fields) -> Mobility:
    redundant = tuple((one.text("loop"), one.whole("conditions")) for one in record.records("redundant"))
    coordinates, gruebler, dof = (record.whole(key) for key in ("coordinates", "gruebler", "dof"))
    return Mobility(coordinates, gruebler, dof, redundant)


def _coupling(record: Fields) -> LinearCoupling:
    low, high = record.numbers("range", 2)
    return LinearCoupling(
        follower=record.text("follower"),
        driver=record.text("driver"),
        multiplier=record.number("multiplier"),
        offset=record.number("offset"),
        error=record.number("error"),
        exact=record.truth("mimic"),
        low=low,
        high=high,
    )


def _amendment(record: Fields) -> Amendment:
    key, file, target = (record.text(name) for name in ("key", "file", "target"))
    return Amendment(key, file, target, record.texts("adds"), record.texts("sets"))


def _surplus(record: Fields) -> Surplus:
    counts = (record.whole(key) for key in ("dofs", "actuators", "equalities"))
    return Surplus(record.text("file"), *counts)
