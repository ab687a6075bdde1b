"""Selects the reader of a compiled model, and turns comparisons into checks of compiled models."""

from collections.abc import Callable, Iterable

from linkwright.stages.robot.check import Check
from linkwright.stages.validate.compiled import CheckFunction, CompiledModel
from linkwright.stages.validate.read.mjcf import ReadMjcf
from linkwright.stages.validate.read.mujoco import ReadCompiled
from linkwright.stages.validate.read.urdf import ReadUrdf
from linkwright.stages.validate.same.read_robot import ReadRobot


def read_compiled(compiled: CompiledModel) -> ReadCompiled:
    """Returns the reader of a model that was compiled from a URDF or an MJCF."""
    return ReadUrdf(compiled) if compiled.urdf else ReadMjcf(compiled)


def as_model_check(compare: Callable[[ReadRobot], Iterable[Check]]) -> CheckFunction:
    """Turns a comparison, which takes what a reader of any format returns, into a check of a compiled
    model."""
    return lambda compiled: compare(read_compiled(compiled))
