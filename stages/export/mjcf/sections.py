"""The sections of an MJCF that its source alone fills: tendons, and what names them."""

from collections.abc import Iterable, Iterator

from linkwright.stages.export.mjcf.actuators import KeyedActuator
from linkwright.stages.export.mjcf.placement import write_element
from linkwright.stages.formats.xml import Element, element
from linkwright.stages.robot.model.mjcf_extras import MjcfElement, MjcfExtras, children_of

STATES = {"none": 0, "integrator": 1, "filter": 1, "filterexact": 1, "muscle": 1}
"""Numbers of states of an actuator by its dynamics; those of a user say how many."""


def write_sections(root: Element, sections: Iterable[MjcfElement]) -> None:
    """Adds elements to the sections of a model."""
    for section in sections:
        above = root.find(section.tag)
        if above is None:
            above = element(root, section.tag)
        for one in section.children:
            write_element(above, one)


def ordered(root: Element, extras: MjcfExtras) -> None:
    """Brings actuators and sensors in the order of the source."""
    for tag, _ in extras.order:
        above = root.find(tag)
        if above is not None:
            nodes = {node.get("name"): node for node in above}
            for name in extras.in_order(tag, nodes):
                above.append(nodes[name])


def drives_of(sections: Iterable[MjcfElement]) -> Iterator[KeyedActuator]:
    """The controls of the actuators in these sections, which are 0 in every keyframe, as their states are."""
    for actuator in children_of(sections, "actuator"):
        own = dict(actuator.attributes)
        states = int(own.get("actdim", STATES.get(own.get("dyntype", "none"), 0)))
        yield KeyedActuator(actuator.name, 0.0, (0.0,) * states)
