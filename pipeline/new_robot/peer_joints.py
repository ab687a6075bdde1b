"""Converts `joint_properties` of onshape-to-robot to the keys `joints`, `actuators` and `attributes`."""

from collections.abc import Callable, Mapping, Sequence
from fnmatch import fnmatchcase
from typing import Any

from linkwright.pipeline.new_robot.joint_table import JointRow
from linkwright.stages.export.configuration.actuator_section import fields_of
from linkwright.stages.robot.model.robot import Dof, Robot
from linkwright.stages.robot.text.globs import exact_glob

_JOINT_KEYS = {
    "max_effort": "effort",
    "effort": "effort",
    "max_velocity": "velocity",
    "friction": "friction",
    "frictionloss": "friction",
    "damping": "damping",
    "armature": "armature",
}
"""Property → our key of `joints`."""

_ACTUATOR_KEYS = ("kp", "kv", "dampratio", "forcerange")
_ACTUATOR_TYPES = ("position", "velocity", "motor", "intvelocity", "damper", "general")
_OMISSION_REASONS = {
    "class": "default classes of your own: see `class` in PEERS.md",
    "range": "the ranges of controls are those of the joints",
    "type": "a joint's type is that of its mate",
}

Note = Callable[[str, str], None]


def converted_joints(
    properties: Mapping[str, Mapping[str, Any]], robot: Robot, rows: Sequence[JointRow], note: Note
) -> dict[str, dict[str, Any]]:
    """Returns the entries of the keys `joints`, `actuators` and `attributes`; later globs win, as in
    onshape-to-robot.

    Entries of limits, and of gains, which depend on the kind of joint, name each joint. `note(option, text)`
    is called for each property that is left out.
    """
    keys: dict[str, dict[str, Any]] = {"joints": {}, "actuators": {}, "attributes": {}}
    dofs = {dof.name: dof for dof in robot.dofs}
    # The defaults come first, wherever the file has them.
    order = sorted(properties.items(), key=lambda item: item[0] != "default")
    for glob, values in order:
        our_glob = "*" if glob == "default" else glob
        matches = [row for row in rows if not row.loop and fnmatchcase(row.name, our_glob)]
        if not matches:
            note("joint_properties", f"no joint matches {glob!r}: left out")
            continue
        dynamics = {
            _JOINT_KEYS[name]: value
            for name, value in values.items()
            if name in _JOINT_KEYS and value is not None
        }
        if dynamics:
            _add_dynamics(keys["joints"], our_glob, [row.name for row in matches], dynamics)
        for row in matches:
            _add_limits(keys["joints"], dofs[row.name], values.get("limits"))
            _add_actuator(keys["actuators"], row, values)
            if values.get("stiffness"):
                keys["attributes"][row.name] = {"stiffness": values["stiffness"]}
        _note_others(glob, values, note)
    _drop_unsupported(keys["actuators"], note)
    return {section: entries for section, entries in keys.items() if entries}


def _add_dynamics(
    joints: dict[str, Any], glob: str, names: Sequence[str], dynamics: Mapping[str, Any]
) -> None:
    """Adds the dynamics of the joints of these `names`, which `glob` matches, so that they win over all
    earlier entries."""
    if glob not in joints:
        joints[glob] = dict(dynamics)
        return
    # The entry of this glob keeps its place, and entries between would win over it: each joint gets an own
    # entry behind them, with the values that it has by now.
    for name in names:
        values: dict[str, Any] = {}
        for earlier_glob, entry in joints.items():
            values |= entry if fnmatchcase(name, earlier_glob) else {}
        joints.pop(exact_glob(name), None)
        joints[exact_glob(name)] = {**values, **dynamics}


def _add_limits(joints: dict[str, Any], dof: Dof, limits: Any) -> None:
    """Adds limits to the entry of a joint, as values of the mate: in onshape-to-robot they count from the
    saved pose."""
    if isinstance(limits, Sequence) and len(limits) == 2 and dof.kind in ("turn", "slide"):
        ends = sorted(round(dof.mate_value.to_mate(float(end)), 9) for end in limits)
        joints.setdefault(exact_glob(dof.name), {})["limits"] = ends


def _add_actuator(actuators: dict[str, Any], row: JointRow, values: Mapping[str, Any]) -> None:
    name = exact_glob(row.name)
    if values.get("actuated") is False:
        actuators[name] = "none"
        return
    if not row.is_drivable:
        return
    entry: dict[str, Any] = {"type": values["type"]} if values.get("type") in _ACTUATOR_TYPES else {}
    entry |= {key: values[key] for key in _ACTUATOR_KEYS if values.get(key) is not None}
    if isinstance(entry.get("forcerange"), int | float):
        entry["forcerange"] = [-entry["forcerange"], entry["forcerange"]]
    if values.get("actuated") and actuators.get(name) == "none":
        del actuators[name]
    if entry:
        previous_entry = actuators.get(name)
        actuators[name] = {**previous_entry, **entry} if isinstance(previous_entry, Mapping) else entry


def _drop_unsupported(actuators: dict[str, Any], note: Note) -> None:
    """Removes the parameters that the type of an actuator does not have."""
    for name, entry in actuators.items():
        if isinstance(entry, dict):
            fields = fields_of(entry.get("type", "position"))
            extra_keys = [key for key in _ACTUATOR_KEYS if key in entry and key not in fields]
            if "kv" in entry and "dampratio" in entry and "dampratio" not in extra_keys:
                extra_keys.append("dampratio")  # kv and dampratio exclude each other
            for key in extra_keys:
                del entry[key]
            if extra_keys:
                text = f"{', '.join(extra_keys)} of {name!r}: its type does not take them together: left out"
                note("joint_properties", text)


def _note_others(glob: str, values: Mapping[str, Any], note: Note) -> None:
    converted_names = {*_JOINT_KEYS, *_ACTUATOR_KEYS, "limits", "actuated", "stiffness"}
    for name, value in values.items():
        if (
            name in converted_names
            or (name == "type" and value in _ACTUATOR_TYPES)
            or (name == "range" and value is True)
        ):
            continue
        why = _OMISSION_REASONS.get(name, "onshape-to-robot has no such property")
        note("joint_properties", f"{name} of {glob!r}: {why}: left out")
