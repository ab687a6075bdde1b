"""Converts the options of onshape-to-robot to keys of a robot's file, or names them.

An option without a key here is named with the reason that the table of PEERS.md gives.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from typing import Any

from linkwright.pipeline.new_robot.joint_table import JointRow
from linkwright.pipeline.new_robot.peer_config import PeerConfig
from linkwright.pipeline.new_robot.peer_joints import converted_joints
from linkwright.pipeline.reference.peers import ONSHAPE_TO_ROBOT
from linkwright.stages.robot.model.robot import Robot
from linkwright.stages.robot.text.globs import exact_glob, without_number
from linkwright.stages.robot.text.names import legal_name

SOURCE_OPTIONS = (
    *("url", "document_id", "version_id", "workspace_id", "element_id", "configuration"),
    *("robot_name", "output_filename"),
)
"""Options of the source and the name, which `peer_config` reads."""

PEER_KEYS = {"conventions": "onshape_to_robot"}
"""The keys of every document made for onshape-to-robot."""

FORMATS = {"urdf": "urdf", "sdf": "sdf", "mujoco": "mjcf"}
"""Value of `output_format` → our format."""

_BYTES_PER_FACE = 50
"""Size of a triangle in a binary STL [bytes]."""

_CONTACT_PROPERTIES = ("friction", "condim", "solref", "solimp", "margin", "priority")


@dataclass(slots=True)
class Conversion:
    """The keys that a configuration comes to, while they are collected."""

    config: PeerConfig
    robot: Robot
    rows: Sequence[JointRow]
    keys: dict[str, Any] = field(default_factory=lambda: dict(PEER_KEYS))
    """Keys of the robot's file."""
    remarks: list[str] = field(default_factory=list)
    """Lines about options that are left out, or that mean something else here."""
    export: str = ""
    """The format; "" if the configuration names none."""
    collider: str = ""
    """The option of the group mesh; "" if the configuration chooses none."""

    def set(self, key: str, value: Any) -> None:
        """Sets a key, given by its full name."""
        *sections, name_in_section = key.split(".")
        section = self.keys
        for name in sections:
            section = section.setdefault(name, {})
        section[name_in_section] = value

    def note(self, option: str, text: str) -> None:
        """Adds a remark about an option."""
        self.remarks.append(f"{option}: {text}")

    def parts(self, glob: str) -> list[str]:
        """Returns the names in CAD of the parts that a glob of onshape-to-robot matches: on names without
        number, in any case, as typed or with underscores."""
        names = {
            without_number(part.name.rpartition("/")[2]) for link in self.robot.links for part in link.parts
        }
        lower_glob = glob.lower()
        return sorted(
            name
            for name in names
            if fnmatchcase(name.lower(), lower_glob) or fnmatchcase(legal_name(name), lower_glob)
        )


def converted(config: PeerConfig, robot: Robot, rows: Sequence[JointRow]) -> Conversion:
    """Returns the keys of a configuration for its robot: its globs are matched with joints and parts."""
    conversion = Conversion(config, robot, rows)
    for option, value in config.options.items():
        if option in SOURCE_OPTIONS:
            continue
        convert = CONVERTERS.get(option)
        row = ONSHAPE_TO_ROBOT.get(option)
        if convert is not None:
            convert(conversion, value)
        elif row is not None:
            conversion.note(option, row.note)
        else:
            conversion.note(option, "onshape-to-robot has no such option: left out")
    return conversion


def _output_format(conversion: Conversion, value: Any) -> None:
    conversion.export = FORMATS.get(str(value), "")
    if not conversion.export:
        conversion.note("output_format", f"{value!r} is not a format of {', '.join(FORMATS)}: left out")


def _ignore_limits(conversion: Conversion, value: Any) -> None:
    if value:
        joints = conversion.keys.setdefault("joints", {})
        # Joints with limits of their own, and the entry of all joints, may come before this option.
        conversion.keys["joints"] = {"*": {"limits": [None, None]}} | joints
        conversion.keys["joints"]["*"] |= {"limits": [None, None]}


def _ignore(conversion: Conversion, value: Any) -> None:
    """Collects the parts that are left out, in the order of the file: `!glob` takes its parts off the
    list."""
    globs = value if isinstance(value, Mapping) else dict.fromkeys(value or (), "all")
    hidden: dict[str, list[str]] = {"visual": [], "collision": []}
    for glob, use in globs.items():
        names = conversion.parts(glob.lstrip("!"))
        if not names:
            conversion.note("ignore", f"no part matches {glob!r}: left out")
        for role in hidden if use == "all" else (use,) if use in hidden else ():
            if glob.startswith("!"):
                hidden[role] = [name for name in hidden[role] if name not in names]
            else:
                hidden[role] += [name for name in names if name not in hidden[role]]
    keys = {role: [exact_glob(name) for name in names] for role, names in hidden.items() if names}
    if keys:
        conversion.set("ignore", keys)


def _geom_properties(conversion: Conversion, value: Any) -> None:
    geoms: dict[str, Any] = {}
    for glob, properties in value.items():
        roles = {role: entry for role, entry in properties.items() if role in ("visual", "collision")}
        roles = roles or {"visual": properties, "collision": properties}
        names = conversion.parts(glob)
        if not names:
            conversion.note("geom_properties", f"no part matches {glob!r}: left out")
        for role, entry in roles.items():
            contact = {
                name: _contact(name, number) for name, number in entry.items() if name in _CONTACT_PROPERTIES
            }
            left_out = sorted(set(entry) - set(contact))
            if left_out:
                text = (
                    f"{', '.join(left_out)} of {glob!r} ({role}): `attributes` sets any attribute of a geom"
                )
                conversion.note("geom_properties", text)
            for name in names if contact else ():
                geoms.setdefault(exact_glob(name), {}).setdefault(role, {}).update(contact)
    if geoms:
        conversion.set("geoms", geoms)


def _contact(name: str, value: Any) -> Any:
    """Returns a property of contact: MuJoCo's texts as numbers, and a friction with all three of its
    numbers."""
    numbers = [float(word) for word in value.split()] if isinstance(value, str) else value
    if name == "friction":
        first = numbers if isinstance(numbers, list) else [numbers]
        # Missing numbers are MuJoCo's defaults: sliding, torsional and rolling friction.
        return [*first, *(1.0, 0.005, 0.0001)[len(first) :]]
    if name in ("condim", "priority") and isinstance(numbers, list):
        return int(numbers[0])
    return numbers[0] if name == "margin" and isinstance(numbers, list) else numbers


def _equalities(conversion: Conversion, value: Any) -> None:
    """Converts attributes of the constraints that close loops: their globs match the names of both frames,
    `closing_NAME_1` and `closing_NAME_2`."""
    attributes: dict[str, Any] = {}
    loops = {
        loop.name: [f"closing_{loop.name.removeprefix('closing_')}_{number}" for number in (1, 2)]
        for loop in conversion.robot.loops
    }
    for glob, entry in value.items():
        names = [name for name in loops if any(fnmatchcase(frame, glob) for frame in loops[name])]
        if not names:
            conversion.note("equalities", f"no loop matches {glob!r}: left out")
        attributes |= {name: dict(entry) for name in names}
    if attributes:
        conversion.keys.setdefault("attributes", {}).update(attributes)


def _additional_xml(conversion: Conversion, value: Any) -> None:
    output = conversion.config.options.get("output_format")
    root_tag = {"urdf": "robot", "mujoco": "mujoco"}.get(str(output))
    for number, file in enumerate([value] if isinstance(value, str) else value, 1):
        path = conversion.config.folder / file
        if root_tag is None or not path.is_file():
            why = "there is no such file" if root_tag else "the SDF takes no elements of your own"
            conversion.note("additional_xml", f"{file}: {why}: left out")
            continue
        element = {"into": {"tag": root_tag}, "formats": [FORMATS[str(output)]], "file": path.as_posix()}
        conversion.set(f"elements.additional_{number}", element)


def _package_name(conversion: Conversion, value: Any) -> None:
    if value and conversion.config.options.get("output_format", "urdf") == "urdf":
        conversion.set("export.urdf", {"meshes": "package", "package": str(value)})


def _merge(conversion: Conversion, value: Any) -> None:
    conversion.set("mesh.visual.merge", "colour" if value in (True, "visual") else "part")


def _fixed_links(conversion: Conversion, value: Any) -> None:
    if value:
        conversion.set("mesh.visual.merge", "part")
        conversion.note("use_fixed_links", ONSHAPE_TO_ROBOT["use_fixed_links"].note)


def _max_size(conversion: Conversion, value: Any) -> None:
    """Converts the size of an STL [MB] to the number of its faces; the size counts only with
    `simplify_stls`."""
    if conversion.config.options.get("simplify_stls"):
        faces = max(1, int(float(value) * 1_000_000 / _BYTES_PER_FACE))
        conversion.set("mesh.visual.max_faces", faces)


def _simplify(conversion: Conversion, value: Any) -> None:
    if value and "max_stl_size" not in conversion.config.options:
        # The default size of onshape-to-robot [MB].
        _max_size(conversion, 3)


def _dummy_base(conversion: Conversion, value: Any) -> None:
    if value:
        names = {link.name for link in conversion.robot.links}
        name = "base_link" if "base_link" not in names else "base_footprint"
        conversion.set(f"links.{name}", {"child": conversion.robot.root.name})


def _collider(option: str, collider: str) -> Callable[[Conversion, Any], None]:
    def convert(conversion: Conversion, value: Any) -> None:
        if value:
            conversion.collider = collider
            conversion.note(option, f"mesh: {collider}, in the defaults above")

    return convert


def _joint_properties(conversion: Conversion, value: Any) -> None:
    keys = converted_joints(value, conversion.robot, conversion.rows, conversion.note)
    for section, entries in keys.items():
        for name, entry in entries.items():
            previous_entry = conversion.keys.setdefault(section, {}).get(name)
            merged_entry = (
                {**previous_entry, **entry}
                if isinstance(previous_entry, Mapping) and isinstance(entry, Mapping)
                else entry
            )
            conversion.keys[section][name] = merged_entry


CONVERTERS: Mapping[str, Callable[[Conversion, Any], None]] = {
    "output_format": _output_format,
    "ignore_limits": _ignore_limits,
    "ignore": _ignore,
    "joint_properties": _joint_properties,
    "geom_properties": _geom_properties,
    "equalities": _equalities,
    "additional_xml": _additional_xml,
    "package_name": _package_name,
    "merge_stls": _merge,
    "use_fixed_links": _fixed_links,
    "simplify_stls": _simplify,
    "max_stl_size": _max_size,
    "add_dummy_base_link": _dummy_base,
    "convex_decomposition": _collider("convex_decomposition", "coacd"),
    "no_collision_meshes": _collider("no_collision_meshes", "visual"),
    "use_scads": _collider("use_scads", "primitives"),
}
"""Option → the function that converts its value."""
