"""Writes the actuators of a USD as prims of MuJoCo's own schema."""

from collections.abc import Mapping, Sequence

from linkwright.stages.export.usd.layer import Prim
from linkwright.stages.formats.usd.actuator_facts import supported_actuators
from linkwright.stages.robot.model.actuation import Actuator


def write_actuators(scope: Prim, actuators: Sequence[Actuator], prims_by_dof: Mapping[str, Prim]) -> None:
    """Writes a prim below `scope` for each actuator that the schema supports and whose dof has a joint.
    `prims_by_dof`: dof → prim of its joint."""
    for name, actuator, attributes in supported_actuators(actuators, prims_by_dof):
        prim = scope.child(name, "MjcActuator")
        if name != actuator.name:
            prim.set_display_name(actuator.name)
        prim.point_to("mjc:target", prims_by_dof[actuator.dof])
        for attribute, token in attributes.tokens.items():
            prim.token(attribute, token)
        for attribute, values in attributes.arrays.items():
            prim.doubles(attribute, values)
        for attribute, value in attributes.numbers.items():
            prim.number(attribute, value, "double", uniform=True)
