"""Reads the motors that `actuators` names, and makes them part of the plan: a cached result depends on the
content of their files."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import yaml
from pydantic import ValidationError

from linkwright.pipeline.config.files import yaml_file
from linkwright.pipeline.config.messages import diagnostics, nearest
from linkwright.pipeline.motor_files import FOLDER, library
from linkwright.stages.export.configuration.motor_section import MotorSection
from linkwright.stages.robot.errors import Diagnostic
from linkwright.stages.robot.section import Section


class _Library(Section):
    """A section with motors at the same key as in a plan, so that problems name that key."""

    motors: dict[str, MotorSection]


def with_motors(
    tree: Mapping[str, Any], own_folders: Sequence[Path] = ()
) -> tuple[dict[str, Any], list[Diagnostic]]:
    """Adds the motors that `actuators` names to `motors` of the tree; returns the tree, and the motors'
    problems. A motor that the tree itself defines needs no file. `own_folders`: the user's folders with
    `robot/`."""
    tree_motors = tree.get("motors")
    if tree_motors is not None and not isinstance(tree_motors, Mapping):
        return dict(tree), []
    motors: dict[str, Any] = dict(tree_motors or {})
    problems: list[Diagnostic] = []
    files: dict[str, Path] | None = None
    for key, name in _named_motors(tree.get("actuators")):
        if name in motors:
            continue
        files = library(own_folders) if files is None else files
        if name not in files:
            problems.append(_unknown_motor(key, name, sorted({*files, *(tree_motors or ())}), own_folders))
            continue
        motors[name], file_problems = _read_motor(files[name])
        problems += file_problems
    invalid_names = {name for name, content in motors.items() if content is None}
    motors = {name: content for name, content in motors.items() if name not in invalid_names}
    return ({**tree, "motors": motors} if motors else dict(tree)), problems


def _named_motors(actuators: Any) -> Iterator[tuple[str, str]]:
    """Yields the key and the motor of each entry of `actuators` that names a motor."""
    for glob, entry in actuators.items() if isinstance(actuators, Mapping) else ():
        if isinstance(entry, Mapping) and isinstance(entry.get("motor"), str) and entry["motor"]:
            yield f"actuators.{glob}.motor", entry["motor"]


def _unknown_motor(key: str, name: str, motors: Sequence[str], own_folders: Sequence[Path]) -> Diagnostic:
    suggestion = nearest(name, motors)
    places = " and ".join(str(folder / FOLDER) for folder in own_folders) or f"./{FOLDER}/ beside ./robot/"
    hint = f"{suggestion} motors: {', '.join(motors)}; motors of your own: {places}".strip()
    return Diagnostic("E-MOTOR", f"there is no motor {name}", key, hint)


def _read_motor(file: Path) -> tuple[dict[str, Any] | None, list[Diagnostic]]:
    """Reads a motor's file; returns its content, None if invalid, and its problems, which name the file."""
    try:
        content = yaml_file.read(file)
    except (OSError, ValueError, yaml.YAMLError) as error:
        mark = getattr(error, "problem_mark", None)
        place = str(file) if mark is None else f"{file}, line {mark.line + 1}, column {mark.column + 1}"
        return None, [Diagnostic("E-MOTOR", yaml_file.problem(error), place)]
    if not isinstance(content, dict):
        hint = "title: ..., values: {armature: {value: ..., source: ..., kind: ...}}"
        return None, [Diagnostic("E-MOTOR", "must be a mapping", str(file), hint)]
    try:
        _Library.model_validate({"motors": {file.stem: content}})
    except ValidationError as error:
        problems = diagnostics(error, _Library)
        keys = [problem.where.removeprefix(f"motors.{file.stem}").lstrip(".") for problem in problems]
        texts = [
            f"{key}: {problem.message}" if key else problem.message
            for key, problem in zip(keys, problems, strict=True)
        ]
        return None, [
            Diagnostic("E-MOTOR", text, str(file), problem.hint)
            for text, problem in zip(texts, problems, strict=True)
        ]
    return content, []
