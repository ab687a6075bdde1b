"""Converts `joint_properties` of onshape-to-robot to the keys `joints`, `actuators` and `attributes`."""

from collections.abc import Callable, Mapping, Sequence
from fnmatch import fnmatchcase
from typing import Any

from linkwright.pipeline.new_robot.joint_table import JointRow
from linkwright.stages.export.configuration.actuator_section import fields_of
from linkwright.stages.robot.model.robot import Dof, Robot
from linkwright.stages.robot.text.globs import exact_glob

_JOINT = {
    "max_effort": "effort",
    "effort": "effort",
    "max_velocity": "velocity",
    "friction": "friction",
    "frictionloss": "friction",
    "damping": "damping",
    "armature": "armature",
}
"""Property → our key of `joints`."""

_ACTUATOR = ("kp", "kv", "dampratio", "forcerange")
_TYPES = ("position", "velocity", "motor", "intvelocity", "damper", "general")
_LEFT_OUT = {
    "class": "default classes of your own: see `class` in PEERS.md",
    "range": "the ranges of controls are those of the joints",
    "type": "a joint's type is that of its mate",
}

Note = Callable[[str, str], None]


def converted_joints(
    properties: Mapping[str, Mapping[str, Any]], robot: Robot, rows: Sequence[JointRow], note: Note
) -> dict[str, dict[str, Any]]:
    """Returns the entries of the keys `joints`, `actuators` and `attributes`; later globs win, as there.

    Entries of limits, and of gains, which depend on the kind of joint, name each joint. `note(option, text)`
    takes what is left out.
    """
    keys: dict[str, dict[str, Any]] = {"joints": {}, "actuators": {}, "attributes": {}}
    dofs = {dof.name: dof for dof in robot.dofs}
    # The defaults come first, wherever they stand in the file.
    order = sorted(properties.items(), key=lambda item: item[0] != "default")
    for glob, values in order:
        ours = "*" if glob == "default" else glob
        matches = [row for row in rows if not row.loop and fnmatchcase(row.name, ours)]
        if not matches:
            note("joint_properties", f"no joint matches {glob!r}: left out")
            continue
        dynamics = {
            _JOINT[name]: value for name, value in values.items() if name in _JOINT and value is not None
        }
        if dynamics:
            keys["joints"].setdefault(ours, {}).update(dynamics)
        for row in matches:
            _add_limits(keys["joints"], dofs[row.name], values.get("limits"))
            _add_actuator(keys["actuators"], row, values)
            if values.get("stiffness"):
                keys["attributes"][row.name] = {"stiffness": values["stiffness"]}
        _note_others(glob, values, note)
    _drop_unfit(keys["actuators"], note)
    return {section: entries for section, entries in keys.items() if entries}


def _add_limits(joints: dict[str, Any], dof: Dof, limits: Any) -> None:
    """Adds limits to the entry of a joint, in the mate's own value: there they count from the saved pose."""
    if isinstance(limits, Sequence) and len(limits) == 2 and dof.kind in ("turn", "slide"):
        ends = sorted(round(dof.mate_value.of(float(end)), 9) for end in limits)
        joints.setdefault(exact_glob(dof.name), {})["limits"] = ends


def _add_actuator(actuators: dict[str, Any], row: JointRow, values: Mapping[str, Any]) -> None:
    name = exact_glob(row.name)
    if values.get("actuated") is False:
        actuators[name] = "none"
        return
    if not row.driven:
        return
    entry: dict[str, Any] = {"type": values["type"]} if values.get("type") in _TYPES else {}
    entry |= {key: values[key] for key in _ACTUATOR if values.get(key) is not None}
    if isinstance(entry.get("forcerange"), int | float):
        entry["forcerange"] = [-entry["forcerange"], entry["forcerange"]]
    if values.get("actuated") and actuators.get(name) == "none":
        del actuators[name]
    if entry:
        earlier = actuators.get(name)
        actuators[name] = {**earlier, **entry} if isinstance(earlier, Mapping) else entry


def _drop_unfit(actuators: dict[str, Any], note: Note) -> None:
    """Removes the parameters that the type of an actuator does not have."""
    for name, entry in actuators.items():
        if isinstance(entry, dict):
            fields = fields_of(entry.get("type", "position"))
            unfit = [key for key in _ACTUATOR if key in entry and key not in fields]
            if "kv" in entry and "dampratio" in entry and "dampratio" not in unfit:
                unfit.append("dampratio")  # kv and dampratio exclude each other
            for key in unfit:
                del entry[key]
            if unfit:
                text = f"{', '.join(unfit)} of {name!r}: its type does not take them together: left out"
                note("joint_properties", text)


def _note_others(glob: str, values: Mapping[str, Any], note: Note) -> None:
    taken = {*_JOINT, *_ACTUATOR, "limits", "actuated", "stiffness"}
    for name, value in values.items():
        if name in taken or (name == "type" and value in _TYPES) or (name == "range" and value is True):
            continue
        why = _LEFT_OUT.get(name, "onshape-to-robot has no such property")
        note("joint_properties", f"{name} of {glob!r}: {why}: left out")
