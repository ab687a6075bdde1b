"""Writes the actuators of a USD as prims of MuJoCo's own schema."""

from collections.abc import Mapping, Sequence

from linkwright.stages.export.usd.layer import Prim
from linkwright.stages.formats.usd.actuator_facts import supported_actuators
from linkwright.stages.robot.model.actuation import Actuator


def write_actuators(above: Prim, actuators: Sequence[Actuator], joints: Mapping[str, Prim]) -> None:
    """Writes a prim for each actuator that the schema knows and whose dof is a joint. `joints`: dof →
    prim."""
    for name, actuator, attributes in supported_actuators(actuators, joints):
        prim = above.child(name, "MjcActuator")
        if name != actuator.name:
            prim.set_display_name(actuator.name)
        prim.point_to("mjc:target", joints[actuator.dof])
        for attribute, token in attributes.tokens.items():
            prim.token(attribute, token)
        for attribute, values in attributes.arrays.items():
            prim.doubles(attribute, values)
        for attribute, value in attributes.numbers.items():
            prim.number(attribute, value, "double", uniform=True)
