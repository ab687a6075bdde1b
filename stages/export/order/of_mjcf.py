"""The tables of an MJCF: where each joint, actuator and sensor is in MuJoCo's arrays."""

from collections.abc import Iterator, Mapping

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

SIZES = {"turn": (1, 1), "slide": (1, 1), "ball": (4, 3), "free": (7, 6)}
"""Kind of dof → how many numbers it has in `qpos`, and in `qvel`."""

KINDS = {"hinge": "turn", "slide": "slide", "ball": "ball", "free": "free"}
"""MJCF's type of joint → kind of dof."""

UNITS = {"turn": "rad", "slide": "m", "ball": QUATERNION, "free": f"m, {QUATERNION}"}
"""Kind of dof → unit of its numbers in `qpos`."""

_CONTROL = {
    "motor": "force",
    "position": "value",
    "pid": "value",
    "velocity": "speed",
    "intvelocity": "speed",
    "damper": "share",
    "dcmotor": "voltage",
}
"""Type of actuator → what its control is."""

_OF_PID = "pos vel"
"""The controls of MuJoCo's pid unless it says which."""


class MjcfOrder:
    """The tables of one finished file. `mates`: dof → what CAD calls its mate; `urdf`: dof → its joints in
    the URDF."""

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
        every = [*robot.dofs, *(dof for loop in robot.loops for dof in loop.dofs)]
        self._dofs: dict[str, Dof] = {dof.name: dof for dof in every}
        self._actuators = {one.name: one for one in actuation.actuators}

    def record(self) -> MjcfOrderRecord:
        return MjcfOrderRecord(tuple(self._joints()), tuple(self._driven()), tuple(self._sensors()))

    def _joints(self) -> Iterator[MjcfJointRow]:
        qpos = dof = 0
        for node, kind_of_mjcf in joints_in_order(self._root):
            name, kind = node.get("name"), KINDS[kind_of_mjcf]
            numbers, speeds = SIZES[kind]
            yield MjcfJointRow(
                name=name,
                kind=kind,
                unit=UNITS[kind],
                qpos=(qpos, numbers),
                dof=(dof, speeds),
                urdf=tuple(self._urdf.get(name, ())),
                cad=self._mates.get(name),
            )
            qpos, dof = qpos + numbers, dof + speeds

    def _driven(self) -> Iterator[MjcfActuatorRow]:
        nodes = [node for section in self._root.iterchildren("actuator") for node in section]
        first = 0
        for node in (node for node in nodes if isinstance(node.tag, str)):
            own = self._actuators.get(node.get("name"))
            joint = node.get("joint") or (own.dof if own else None)
            count = _controls(node, own)
            yield MjcfActuatorRow(
                name=node.get("name"),
                ctrl=(first, count),
                type=node.tag,
                joint=joint,
                unit=self._unit_of_control(own) if own else None,
                range=_range(node, own),
                cad=self._mates.get(joint or ""),
            )
            first += count

    def _unit_of_control(self, one: Actuator) -> str | None:
        value, force = LENGTHS[one.moves(self._dofs[one.dof].kind)]
        said = {"force": force, "value": value, "speed": f"{value}/s", "share": "-", "voltage": "V"}
        return said.get(_CONTROL.get(one.type, ""))

    def _sensors(self) -> Iterator[MjcfSensorRow]:
        address: int | None = 0
        nodes = [node for section in self._root.iterchildren("sensor") for node in section]
        for index, node in enumerate(node for node in nodes if isinstance(node.tag, str)):
            count = DIMENSIONS.get(node.tag) or (_whole(node.get("dim")) if node.tag == "user" else 0)
            plain = node.tag != "rangefinder" or (node.get("site") and node.get("data") is None)
            known = count if plain else 0
            own = self._actuators.get(node.get("actuator") or "")
            on = node.get("joint") or (own.dof if own else None)
            dof = self._dofs.get(on or "")
            kind = dof.kind if dof else ""
            yield MjcfSensorRow(
                name=node.get("name"),
                index=index,
                type=node.tag,
                on=_on(node),
                address=address,
                dim=known or None,
                unit=unit_of(node.tag, own.moves(kind) if own else kind),
                cad=self._mates.get(on or ""),
            )
            address = address + known if known and address is not None else None


def _controls(node: Element, own: Actuator | None) -> int:
    """How many controls an actuator has: a pid one for each of its inputs."""
    if node.tag != "pid":
        return 1
    said = node.get("input") or (dict(own.terms).get("input") if own else None)
    return len((said or _OF_PID).split())


def _range(node: Element, own: Actuator | None) -> tuple[float, ...] | None:
    """The range of the control, as the file has it, else as the actuator, whose class may hold it."""
    text = node.get("ctrlrange")
    if text is not None:
        try:
            return tuple(as_float(float(end)) for end in text.split())
        except ValueError:
            return None  # It does not compile.
    return None if own is None or own.control is None else tuple(map(as_float, own.control))


def _whole(text: str | None) -> int:
    return int(text) if text is not None and text.isdecimal() else 0


def _on(node: Element) -> str | None:
    """What a sensor is on, by its name."""
    for key in ("joint", "actuator", "site", "objname", "body", "camera", "tendon"):
        if node.get(key) is not None:
            return str(node.get(key))
    return None
