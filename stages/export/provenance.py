"""Tells where the limits and dynamics of a dof come from."""

from collections.abc import Iterator, Sequence
from dataclasses import fields

from linkwright.stages.robot.model.actuation import Supplied
from linkwright.stages.robot.model.robot import Dof, Dynamics


def provenance(dof: Dof, estimated: bool = False, motors: Sequence[Supplied] = ()) -> dict[str, str]:
    """Returns the origin of each quantity: `given` (by the configuration), `source` (by CAD or the file),
    `estimated`, a motor with the source of its value, or `unset` (URDF then gets a default where it requires
    a number). `estimated`: whether the armature is estimated; `motors`: the values of motors, for all
    dofs."""
    by_motor = {supply.quantity: supply.source for supply in motors if supply.dof == dof.name}
    return dict(_origins(dof, estimated)) | by_motor


def _origins(dof: Dof, estimated: bool) -> Iterator[tuple[str, str]]:
    """Yields (quantity, origin), without motors."""
    ends = {"turn": ("lower", "upper"), "slide": ("lower", "upper"), "ball": ("upper",), "free": ()}
    for side in ends[dof.kind]:
        yield side, _origin(dof, "limits", getattr(dof.limits, side))
    if dof.kind != "free":
        for field in fields(Dynamics):
            is_estimate = estimated and field.name == "armature"
            origin = _origin(dof, field.name, getattr(dof.dynamics, field.name))
            yield field.name, "estimated" if is_estimate else origin


def _origin(dof: Dof, key: str, value: float | None) -> str:
    """Returns the origin of a value. `key`: the configuration's name for it, or for its pair of limits."""
    if value is None:
        return "unset"
    return "given" if key in dof.given else "source"
