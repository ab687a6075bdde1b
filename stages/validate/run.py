"""The run of a validation: every engine reads its files, and every check looks at what it compiled."""

from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

from stages.robot.check import Check
from stages.robot.model import Robot
from stages.validate import CHECKS, ENGINES
from stages.validate.compiled import CheckFunction, CompiledModel, Engine, without_warnings
from stages.validate.coordinates import missing_names


def check_files(folder: Path, robot: Robot, thorough: bool) -> Iterator[Check]:
    """The results of every file that an engine reads; `thorough`: all checks, not only compiling."""
    for name in ENGINES:
        engine: Engine = import_module(f"stages.validate.engines.{name}")
        for file in engine.files(robot.name):
            if (folder / file).exists():
                yield from _check_file(folder / file, robot, engine, thorough)


def _check_file(path: Path, robot: Robot, engine: Engine, thorough: bool) -> list[Check]:
    """The results of one file. Its model is given up afterwards: a large one takes half a gigabyte."""
    loaded = engine.load(path)
    if not thorough or loaded.model is None:
        return [loaded.check]
    compiled = CompiledModel(path, loaded.model, robot)
    with engine.warnings() as warnings:
        found = list(_check_model(compiled))
    return [loaded.check, *found, without_warnings(f"{path.name}: runs", warnings)]


def _check_model(compiled: CompiledModel) -> Iterator[Check]:
    names = CHECKS[:1] if missing_names(compiled) else CHECKS
    for name in names:
        check: CheckFunction = import_module(f"stages.validate.checks.{name}").check
        yield from check(compiled)
