"""The motors that `actuators` names: read when a plan is made, and part of it, so that a cached result knows
what their files held."""

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
    """Motors as the plan has them, so that problems have keys."""

    motors: dict[str, MotorSection]


def with_motors(tree: Mapping[str, Any], own: Sequence[Path] = ()) -> tuple[dict[str, Any], list[Diagnostic]]:
    """The tree with the motors that `actuators` names under `motors`, and the problems of those. What the
    tree itself has there wins, and needs no file."""
    given = tree.get("motors")
    if given is not None and not isinstance(given, Mapping):
        return dict(tree), []
    motors: dict[str, Any] = dict(given or {})
    problems: list[Diagnostic] = []
    known: dict[str, Path] | None = None
    for key, name in _named(tree.get("actuators")):
        if name in motors:
            continue
        known = library(own) if known is None else known
        if name not in known:
            problems.append(_unknown(key, name, sorted({*known, *(given or ())}), own))
            continue
        motors[name], wrong = _content(known[name])
        problems += wrong
    bad = {one for one, content in motors.items() if content is None}
    motors = {name: content for name, content in motors.items() if name not in bad}
    return ({**tree, "motors": motors} if motors else dict(tree)), problems


def _named(actuators: Any) -> Iterator[tuple[str, str]]:
    """(key, motor) of each entry of `actuators` that names one."""
    for glob, entry in actuators.items() if isinstance(actuators, Mapping) else ():
        if isinstance(entry, Mapping) and isinstance(entry.get("motor"), str) and entry["motor"]:
            yield f"actuators.{glob}.motor", entry["motor"]


def _unknown(key: str, name: str, known: Sequence[str], own: Sequence[Path]) -> Diagnostic:
    near = nearest(name, known)
    places = " and ".join(str(folder / FOLDER) for folder in own) or f"./{FOLDER}/ beside ./robot/"
    hint = f"{near} motors: {', '.join(known)}; motors of your own: {places}".strip()
    return Diagnostic("E-MOTOR", f"there is no motor {name}", key, hint)


def _content(file: Path) -> tuple[dict[str, Any] | None, list[Diagnostic]]:
    """The content of a motor's file, and its problems, which name the file."""
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
        found = diagnostics(error, _Library)
        inside = [one.where.removeprefix(f"motors.{file.stem}").lstrip(".") for one in found]
        texts = [
            f"{key}: {one.message}" if key else one.message for key, one in zip(inside, found, strict=True)
        ]
        return None, [
            Diagnostic("E-MOTOR", text, str(file), one.hint) for text, one in zip(texts, found, strict=True)
        ]
    return content, []
