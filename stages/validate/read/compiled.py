"""Reads the robot of a compiled model, and turns comparisons of robots into checks of compiled models."""

from collections.abc import Callable, Iterable

from linkwright.stages.robot.check import Check
from linkwright.stages.validate.compiled import CheckFunction, CompiledModel
from linkwright.stages.validate.read.mjcf import ReadMjcf
from linkwright.stages.validate.read.mujoco import ReadCompiled
from linkwright.stages.validate.read.urdf import ReadUrdf
from linkwright.stages.validate.same.read_robot import ReadRobot


def read_compiled(compiled: CompiledModel) -> ReadCompiled:
    """Returns the robot of a model that was compiled from a URDF or an MJCF, as comparisons read it."""
    return ReadUrdf(compiled) if compiled.urdf else ReadMjcf(compiled)


def as_model_check(compare: Callable[[ReadRobot], Iterable[Check]]) -> CheckFunction:
    """Turns a comparison of a file's robot (`ReadRobot`), in any format, into a check of a compiled model."""
    return lambda compiled: compare(read_compiled(compiled))
