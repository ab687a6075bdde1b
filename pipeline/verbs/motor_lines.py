"""Describes a motor and its values in lines of text."""

from pathlib import Path

from linkwright.pipeline.config.plan import Plan
from linkwright.stages.export.configuration.motor_section import QUANTITIES


def motor_lines(name: str) -> tuple[str, str, list[tuple[str, str]]]:
    """Returns the title and the notes of a motor, and for each of its values the line and its source;
    raises ConfigError if its file is wrong."""
    tree = {"source": {"kind": "sample"}, "actuators": {"*": {"motor": name}}}
    motor = Plan.parse(tree, folders=[Path.cwd()]).motors[name]
    lines = []
    for quantity, value in motor.values.items():
        unit = "" if QUANTITIES[quantity] == "-" else f" {QUANTITIES[quantity]}"
        lines.append((f"  {quantity:<15} {value.value:g}{unit} ({value.kind})", value.source))
    return motor.title, motor.notes or "", lines
