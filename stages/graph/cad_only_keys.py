"""Reports keys that apply only to CAD assemblies, where the source is a robot's own file."""

from typing import Literal

from linkwright.stages.graph.section import GraphSections
from linkwright.stages.robot.diagnostics import Diagnostics

_CAD_ONLY = ("depth", "hidden", "mirror", "mirrors", "conventions")


def report_unused(keys: GraphSections, source: Literal["URDF", "MJCF"], log: Diagnostics) -> None:
    """Reports E-SOURCE-KEY for each key that is set and does not apply to a robot's own file. `source`: the
    format of that file."""
    default = GraphSections()
    inapplicable = [name for name in _CAD_ONLY if getattr(keys, name) != getattr(default, name)]
    if keys.mass.parts:
        inapplicable.append("mass.parts")
    for name in inapplicable:
        text = f"this key applies only to CAD assemblies, not to {'a' if source == 'URDF' else 'an'} {source}"
        hint = (
            "remove the key"
            if name != "mass.parts"
            else "set the masses of links instead: mass: {links: {...}}"
        )
        log.report("E-SOURCE-KEY", text, name, hint)
