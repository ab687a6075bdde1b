"""Writes the text of a new robot's file."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from linkwright.pipeline.motor_files import library
from linkwright.pipeline.new_robot.choices import RobotChoices
from linkwright.pipeline.new_robot.joint_table import JointRow
from linkwright.pipeline.new_robot.yaml_lines import comment, entry, flow
from linkwright.stages.robot.errors import Diagnostic
from linkwright.stages.robot.text.globs import exact_glob, matches_glob
from linkwright.stages.robot.text.plural import count

_REMEDIES: Mapping[str, tuple[str, ...]] = {
    "LOOSE": ("#root: {disconnected: weld} # or drop, or separate",),
    "MASS": ("#mass: {missing: density, density: 1200} # kg/m³, for all parts without a mass",),
}
"""Code of a problem, without E- → lines of YAML that end it."""

_DYNAMICS = {"damping": 0.1, "friction": 0.02, "armature": 0.01}
"""Starting values for the joints of an assembly: those of `conf/robot/sample.yaml`."""


@dataclass(frozen=True, slots=True)
class NewRobot:
    """Everything that a new robot's file says."""

    name: str
    source: Mapping[str, Any]
    """The keys of the source."""
    rows: Sequence[JointRow] = ()
    choices: RobotChoices | None = None
    """None if the graph stage could make no robot."""
    problems: Sequence[Diagnostic] = ()
    """The problems that end its build, as far as they are known."""
    studios: int = 0
    """The number of part studios whose masses were not fetched; 0 if all masses are known."""
    summary: str = ""
    """The robot in a line."""
    converted: Mapping[str, Any] = field(default_factory=dict)
    """Keys that another tool's configuration comes to."""
    remarks: Sequence[str] = ()
    """Lines about options of that configuration that are left out, or mean something else here."""
    export: str = ""
    """The format to write; "" for the usual formats."""
    collider: str = ""
    """The option of the group mesh; "" for the usual option."""


def text(robot: NewRobot) -> str:
    """Returns the text of the robot's file."""
    sections = (
        _head(robot),
        _joint_comments(robot),
        _problems(robot),
        _defaults(robot),
        _source(robot),
        _converted_keys(robot),
        _joints(robot),
        _actuators(robot),
        _geoms(robot),
        _masses(robot),
    )
    pieces = ["\n".join(lines) for section in sections if (lines := list(section))]
    return "\n\n".join(pieces) + "\n"


def _head(robot: NewRobot) -> Iterator[str]:
    yield "# @package _global_"
    yield from comment(f"{robot.name}: {robot.summary}" if robot.summary else robot.name)
    yield f"#   linkwright robot={robot.name}                 builds it"
    yield f"#   linkwright robot={robot.name} until=graph     only shows its links and joints"
    yield from comment(
        "Lines that begin with # and no space are YAML: remove the # to use them. `linkwright explain KEY` "
        "describes a key."
    )


def _joint_comments(robot: NewRobot) -> Iterator[str]:
    if not robot.rows:
        yield "# No joints were found."
        return
    yield "# Joints that were found:"
    name_width = max(len(row.name) for row in robot.rows)
    type_width = max(len(row.type) for row in robot.rows)
    for row in robot.rows:
        yield f"#   {row.name:{name_width}}  {row.type:{type_width}}  {row.text}"


def _problems(robot: NewRobot) -> Iterator[str]:
    if not robot.problems:
        return
    yield "# Problems: until they are solved, the build ends with these."
    for problem in robot.problems:
        place = f" {problem.where}:" if problem.where else ""
        yield from comment(f"- {problem.code or 'error'}{place} {problem.message}", hanging="  ")
        if problem.hint:
            yield from comment(f"→ {problem.hint}", "", "  ")
    for code in sorted({problem.code.removeprefix("E-") for problem in robot.problems} & _REMEDIES.keys()):
        yield from _REMEDIES[code]


def _defaults(robot: NewRobot) -> Iterator[str]:
    yield "defaults:"
    choices = robot.choices
    if choices and choices.base == "legged":
        yield from comment(choices.base_reason, "  ")
        yield "  - /robot/legged"
    yield f"  - override /source: {robot.source['kind']}"
    if choices:
        if choices.base != "legged":
            yield from comment(choices.base_reason, "  ")
            yield f"  - override /root: {choices.base} # auto, fixed, free"
        if choices.base != "legged" or choices.actuators == "none":
            yield from comment(f"{choices.actuators_reason}; others: linkwright explain actuators", "  ")
            yield f"  - override /actuators: {choices.actuators}"
    mesh, formats = robot.collider or "ladder", robot.export or "[urdf, mjcf]"
    yield f"  - override /mesh: {mesh} # colliders: ladder, hull, coacd, primitives, spheres, raw, visual"
    yield f"  - override /export: {formats} # of urdf, mjcf, sdf, usd, ros2, python; several as [urdf, mjcf]"


def _source(robot: NewRobot) -> Iterator[str]:
    yield "source:"
    keys = {key: value for key, value in robot.source.items() if key != "kind"}
    url = keys.get("url", "")
    if "/w/" in url:
        yield "  # a workspace, whose edits the next build follows; …/v/… is a version, which stays as it is"
    for key, value in keys.items():
        yield entry(key, value, "  ")


def _converted_keys(robot: NewRobot) -> Iterator[str]:
    merged_sections = ("joints", "actuators", "geoms")
    for key, value in robot.converted.items():
        if key not in merged_sections:
            yield entry(key, value)
    if robot.remarks:
        yield "# Options of onshape-to-robot that are left out, or mean something else here:"
    for remark in robot.remarks:
        yield from comment(f"- {remark}", hanging="  ")


def _lines_to_fill_in(robot: NewRobot) -> Iterator[str]:
    """Yields a commented line for each joint that lacks values, also after the conversion."""
    entries: Mapping[str, Mapping[str, Any]] = robot.converted.get("joints", {})
    for row in robot.rows:
        values = [set(keys) for glob, keys in entries.items() if matches_glob(row.name, glob)]
        missing = {
            key: value for key, value in row.missing.items() if not any(key in keys for keys in values)
        }
        if missing and exact_glob(row.name) not in entries:
            yield entry(exact_glob(row.name), missing, "  ", active=False)


def _joints(robot: NewRobot) -> Iterator[str]:
    converted = robot.converted.get("joints", {})
    lines = list(_lines_to_fill_in(robot))
    start_values = {"*": _DYNAMICS} if robot.source["kind"] in ("onshape", "bundle") and not converted else {}
    entries = {**start_values, **converted}
    if not lines and not entries:
        return
    if lines:
        yield from comment(
            "The source has no values for these: limits [rad or m], effort [N m or N], velocity [rad/s or "
            "m/s]. The numbers only show the form. A motor gives effort and velocity (below)."
        )
    yield "joints: # globs on names of joints; later entries win, property by property"
    if start_values:
        yield "  # starting values [N m s/rad, N m, kg m²; of slides N s/m, N, kg]: measure your own"
    for glob, values in (entries or {"*": {}}).items():
        yield entry(glob, values, "  ")
    yield from lines


def _actuators(robot: NewRobot) -> Iterator[str]:
    choices = robot.choices
    converted = robot.converted.get("actuators", {})
    entries = {**(choices.entries if choices else {}), **converted}
    turning_joint = next(
        (exact_glob(row.name) for row in robot.rows if row.is_drivable and row.kind == "turn"), None
    )
    motor_joint = (
        turning_joint
        if choices and choices.actuators == "position" and turning_joint not in entries
        else None
    )
    if not entries and motor_joint is None:
        return
    if choices and choices.entries_reason:
        yield from comment(choices.entries_reason)
    if motor_joint:
        motors = ", ".join(library())
        yield from comment(f"Motors of the library: {motors}; your own: ./motors/NAME.yaml")
    if not entries:
        yield f"#actuators: {flow({motor_joint: {'motor': 'sts3215'}})}"
        return
    yield "actuators:"
    for glob, values in entries.items():
        yield entry(glob, values, "  ")
    if motor_joint:
        yield entry(motor_joint, {"motor": "sts3215"}, "  ", active=False)


def _geoms(robot: NewRobot) -> Iterator[str]:
    entries = {**(robot.choices.geoms if robot.choices else {}), **robot.converted.get("geoms", {})}
    if not entries:
        return
    if robot.choices and robot.choices.geoms_reason:
        yield from comment(robot.choices.geoms_reason)
    yield "geoms:"
    for glob, values in entries.items():
        yield entry(glob, values, "  ")


def _masses(robot: NewRobot) -> Iterator[str]:
    if not robot.studios:
        return
    calls = count(robot.studios, "call")
    yield from comment(
        f"Masses were not asked for (linkwright new --deep does, by {calls}). If parts have no material, the "
        "build ends with E-MASS, which lists them: give them a material in Onshape, or:"
    )
    yield from _REMEDIES["MASS"]
