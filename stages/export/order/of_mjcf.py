"""Lists where each joint, actuator and sensor of an MJCF is in MuJoCo's arrays."""

from collections.abc import Iterator, Mapping

from linkwright.stages.formats.mjcf.controls import control_count
from linkwright.stages.formats.mjcf.joints import joints_in_order
from linkwright.stages.formats.robot_json.files import (
    MjcfActuatorRow,
    MjcfJointRow,
    MjcfOrderRecord,
    MjcfSensorRow,
)
from linkwright.stages.formats.robot_json.values import as_float
from linkwright.stages.formats.xml import Element
from linkwright.stages.robot.model.actuation import Actuation, Actuator
from linkwright.stages.robot.model.robot import Dof, Robot
from linkwright.stages.robot.model.sensor_kinds import DIMENSIONS, LENGTHS, QUATERNION, unit_of

QPOS_AND_QVEL_SIZES = {"turn": (1, 1), "slide": (1, 1), "ball": (4, 3), "free": (7, 6)}
"""Kind of dof → number of its values in `qpos`, and in `qvel`."""

KINDS = {"hinge": "turn", "slide": "slide", "ball": "ball", "free": "free"}
"""MJCF's type of joint → kind of dof."""

UNITS = {"turn": "rad", "slide": "m", "ball": QUATERNION, "free": f"m, {QUATERNION}"}
"""Kind of dof → unit of its values in `qpos`."""

_CONTROL = {
    "motor": "force",
    "position": "value",
    "pid": "value",
    "velocity": "speed",
    "intvelocity": "speed",
    "damper": "share",
    "dcmotor": "voltage",
}
"""Type of actuator → the quantity of its control."""


class MjcfOrder:
    """Builds the tables of a finished file. `mates`: dof → the name of its mate in CAD; `urdf`: dof → its
    joints in the URDF."""

    def __init__(
        self,
        root: Element,
        robot: Robot,
        actuation: Actuation,
        mates: Mapping[str, str],
        urdf: Mapping[str, list[str]],
    ) -> None:
        self._root = root
        self._mates = mates
        self._urdf = urdf
        all_dofs = [*robot.dofs, *(dof for loop in robot.loops for dof in loop.dofs)]
        self._dofs: dict[str, Dof] = {dof.name: dof for dof in all_dofs}
        self._actuators = {actuator.name: actuator for actuator in actuation.actuators}

    def record(self) -> MjcfOrderRecord:
        """Returns the tables of joints, actuators and sensors."""
        return MjcfOrderRecord(
            tuple(self._joint_rows()), tuple(self._actuator_rows()), tuple(self._sensor_rows())
        )

    def _joint_rows(self) -> Iterator[MjcfJointRow]:
        qpos = dof = 0
        for node, kind_of_mjcf in joints_in_order(self._root):
            name, kind = node.get("name"), KINDS[kind_of_mjcf]
            qpos_size, qvel_size = QPOS_AND_QVEL_SIZES[kind]
            yield MjcfJointRow(
                name=name,
                kind=kind,
                unit=UNITS[kind],
                qpos=(qpos, qpos_size),
                dof=(dof, qvel_size),
                urdf=tuple(self._urdf.get(name, ())),
                cad=self._mates.get(name),
            )
            qpos, dof = qpos + qpos_size, dof + qvel_size

    def _actuator_rows(self) -> Iterator[MjcfActuatorRow]:
        nodes = [node for section in self._root.iterchildren("actuator") for node in section]
        first = 0
        for node in (node for node in nodes if isinstance(node.tag, str)):
            actuator = self._actuators.get(node.get("name"))
            joint = node.get("joint") or (actuator.dof if actuator else None)
            inputs = node.get("input") or (dict(actuator.terms).get("input") if actuator else None)
            count = control_count(str(node.tag), inputs)
            yield MjcfActuatorRow(
                name=node.get("name"),
                ctrl=(first, count),
                type=node.tag,
                joint=joint,
                unit=self._unit_of_control(actuator) if actuator else None,
                range=_range(node, actuator),
                cad=self._mates.get(joint or ""),
            )
            first += count

    def _unit_of_control(self, actuator: Actuator) -> str | None:
        """Returns the unit of an actuator's control; None for the type general, whose control may be any."""
        value, force = LENGTHS[actuator.moves(self._dofs[actuator.dof].kind)]
        units = {"force": force, "value": value, "speed": f"{value}/s", "share": "-", "voltage": "V"}
        return units.get(_CONTROL.get(actuator.type, ""))

    def _sensor_rows(self) -> Iterator[MjcfSensorRow]:
        # None after a sensor whose size only the compiler knows.
        address: int | None = 0
        nodes = [node for section in self._root.iterchildren("sensor") for node in section]
        for index, node in enumerate(node for node in nodes if isinstance(node.tag, str)):
            count = DIMENSIONS.get(node.tag) or (_whole_number(node.get("dim")) if node.tag == "user" else 0)
            fixed_size = node.tag != "rangefinder" or (node.get("site") and node.get("data") is None)
            size = count if fixed_size else 0
            actuator = self._actuators.get(node.get("actuator") or "")
            measured_joint = node.get("joint") or (actuator.dof if actuator else None)
            dof = self._dofs.get(measured_joint or "")
            kind = dof.kind if dof else ""
            yield MjcfSensorRow(
                name=node.get("name"),
                index=index,
                type=node.tag,
                on=_measured_object(node),
                address=address,
                dim=size or None,
                unit=unit_of(node.tag, actuator.moves(kind) if actuator else kind),
                cad=self._mates.get(measured_joint or ""),
            )
            address = address + size if size and address is not None else None


def _range(node: Element, actuator: Actuator | None) -> tuple[float, ...] | None:
    """Returns the range of the control from the file, or else from the actuator: a class may have the
    range."""
    text = node.get("ctrlrange")
    if text is not None:
        try:
            return tuple(as_float(float(end)) for end in text.split())
        except ValueError:
            return None  # It does not compile.
    return None if actuator is None or actuator.control is None else tuple(map(as_float, actuator.control))


def _whole_number(text: str | None) -> int:
    return int(text) if text is not None and text.isdecimal() else 0


def _measured_object(node: Element) -> str | None:
    """Returns the name of the object that a sensor measures."""
    for key in ("joint", "actuator", "site", "objname", "body", "camera", "tendon"):
        if node.get(key) is not None:
            return str(node.get(key))
    return None
