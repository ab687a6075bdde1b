"""Writes the sections of an MJCF that only come from its source, such as tendons and their actuators, and
restores the source's order of actuators and sensors."""

from collections.abc import Iterable, Iterator

from linkwright.stages.export.mjcf.actuators import KeyedActuator
from linkwright.stages.export.mjcf.placement import write_element
from linkwright.stages.formats.xml import Element, element
from linkwright.stages.robot.model.mjcf_extras import MjcfElement, MjcfExtras, children_of

STATES_OF_DYNAMICS = {"none": 0, "integrator": 1, "filter": 1, "filterexact": 1, "muscle": 1}
"""`dyntype` of an actuator → the number of its states, unless the actuator has the attribute `actdim`, which
an actuator with `user` always has."""


def write_sections(root: Element, sections: Iterable[MjcfElement]) -> None:
    """Adds elements to the sections of a model."""
    for section in sections:
        parent = root.find(section.tag)
        if parent is None:
            parent = element(root, section.tag)
        for child in section.children:
            write_element(parent, child)


def restore_source_order(root: Element, extras: MjcfExtras) -> None:
    """Sorts actuators and sensors into the order of an MJCF source."""
    for tag, _ in extras.order:
        parent = root.find(tag)
        if parent is not None:
            nodes = {node.get("name"): node for node in parent}
            for name in extras.in_order(tag, nodes):
                parent.append(nodes[name])


def keyed_actuators_of(sections: Iterable[MjcfElement]) -> Iterator[KeyedActuator]:
    """Yields the actuators in these sections. Their controls and states are 0 in all keyframes."""
    for actuator in children_of(sections, "actuator"):
        attributes = dict(actuator.attributes)
        default_count = STATES_OF_DYNAMICS.get(attributes.get("dyntype", "none"), 0)
        state_count = int(attributes.get("actdim", default_count))
        yield KeyedActuator(actuator.name, 0.0, (0.0,) * state_count)
