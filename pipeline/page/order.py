"""Renders the order of joints, actuators and sensors in the files, that of a policy's vectors."""

from collections.abc import Mapping, Sequence
from typing import Any

from linkwright.pipeline.page.html.tables import PageTable, plain_table
from linkwright.pipeline.page.html.template import rendered

Row = Mapping[str, Any]

_MUJOCO_TYPES = {"turn": "hinge"}
"""Kind of dof → MuJoCo's type of joint, where they have other names."""


def order(tables: Mapping[str, Any]) -> str:
    """Renders the section; "" without tables. `tables`: `order` of the report's details."""
    mjcf, urdf = tables.get("mjcf", {}), tables.get("urdf", {})
    values = {
        "joints": _joints(mjcf.get("joints", [])),
        "actuators": _actuators(mjcf.get("actuators", [])),
        "sensors": _sensors(mjcf.get("sensors", [])),
        "urdf": _urdf(urdf.get("joints", [])),
    }
    return rendered("order", **values) if any(values.values()) else ""


def _joints(rows: Sequence[Row]) -> PageTable | None:
    header = ["joint", "type", "qpos", "dof", "unit", "in the URDF", "CAD"]
    cells = [
        [
            row["name"],
            _MUJOCO_TYPES.get(row["kind"], row["kind"]),
            _span(*row["qpos"]),
            _span(*row["dof"]),
            row["unit"],
            ", ".join(row["urdf"]),
            row["cad"],
        ]
        for row in rows
    ]
    return plain_table(header, cells)


def _actuators(rows: Sequence[Row]) -> PageTable | None:
    header = ["actuator", "ctrl", "type", "joint", "range", "unit", "CAD"]
    cells = [
        [
            row["name"],
            _span(*row["ctrl"]),
            row["type"],
            row["joint"],
            _range(row["range"]),
            row["unit"],
            row["cad"],
        ]
        for row in rows
    ]
    return plain_table(header, cells)


def _sensors(rows: Sequence[Row]) -> PageTable | None:
    header = ["sensor", "sensordata", "type", "on", "unit", "CAD"]
    cells = [
        [
            row["name"],
            "" if row["address"] is None or row["dim"] is None else _span(row["address"], row["dim"]),
            *(row[key] for key in ("type", "on", "unit", "cad")),
        ]
        for row in rows
    ]
    return plain_table(header, cells)


def _urdf(rows: Sequence[Row]) -> PageTable | None:
    header = ["joint", "in the file", "in the tree", "type", "unit", "follows", "CAD"]
    keys = ("name", "index", "tree", "type", "unit", "follows", "cad")
    return plain_table(header, [[row[key] for key in keys] for row in rows])


def _span(first: int, count: int) -> str:
    """Returns an index, or the first and the last index of several."""
    return str(first) if count == 1 else f"{first} to {first + count - 1}"


def _range(ends: Sequence[float] | None) -> str:
    return "" if ends is None else f"{ends[0]:.6g} to {ends[1]:.6g}"
