"""Where the limits and dynamics of a dof come from."""

from collections.abc import Iterator, Sequence
from dataclasses import fields

from linkwright.stages.robot.model.actuation import Supplied
from linkwright.stages.robot.model.robot import Dof, Dynamics


def provenance(dof: Dof, estimated: bool = False, motors: Sequence[Supplied] = ()) -> dict[str, str]:
    """By quantity: given (by the configuration), source (by CAD or the file), estimated, a motor with where
    its value comes from, or unset, for which URDF gets a default where it requires a number. `estimated`:
    whether its armature is; `motors`: what those of all dofs give."""
    own = {one.quantity: one.source for one in motors if one.dof == dof.name}
    return dict(_each(dof, estimated)) | own


def _each(dof: Dof, estimated: bool) -> Iterator[tuple[str, str]]:
    ends = {"turn": ("lower", "upper"), "slide": ("lower", "upper"), "ball": ("upper",), "free": ()}
    for side in ends[dof.kind]:
        yield side, _origin(dof, "limits", getattr(dof.limits, side))
    if dof.kind != "free":
        for field in fields(Dynamics):
            made = estimated and field.name == "armature"
            origin = _origin(dof, field.name, getattr(dof.dynamics, field.name))
            yield field.name, "estimated" if made else origin


def _origin(dof: Dof, key: str, value: float | None) -> str:
    if value is None:
        return "unset"
    return "given" if key in dof.given else "source"
