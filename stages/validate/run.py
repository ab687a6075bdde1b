"""Runs a validation: every engine reads its files, and every check judges the compiled models."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

from linkwright.stages.formats.written import Written
from linkwright.stages.robot.check import Check
from linkwright.stages.robot.model.amendments import Amendment
from linkwright.stages.robot.text.globs import name_list
from linkwright.stages.targets.section import TargetSection
from linkwright.stages.validate.check_options import DEFAULT_OPTIONS, CheckOptions
from linkwright.stages.validate.compiled import (
    SCENE,
    CompiledModel,
    Engine,
    FileKind,
    without_warnings,
)
from linkwright.stages.validate.engines import ENGINES
from linkwright.stages.validate.files.model_config import model_config
from linkwright.stages.validate.files.run import check_folder
from linkwright.stages.validate.format_checks import FORMAT_CHECKS
from linkwright.stages.validate.model.coordinates import find_missing_names
from linkwright.stages.validate.readiness.finished import FinishedRobot
from linkwright.stages.validate.readiness.score import score
from linkwright.stages.validate.reading.guarded import guarded
from linkwright.stages.validate.rows import ModelCheck
from linkwright.stages.validate.targets.build import check_targets
from linkwright.stages.validate.user_checks import UserCheck

UNREAD_ENDINGS = (".sdf", ".srdf", ".usda")
"""Endings of a build's files that no engine reads, and that may name assets."""

RUNS = "C-RUNS"
"""Code of the check that an engine runs a file without warnings."""


def check_files(
    folder: Path,
    written: Written,
    checks: Sequence[ModelCheck],
    user_checks: Sequence[UserCheck] = (),
    options: CheckOptions = DEFAULT_OPTIONS,
) -> Iterator[Check]:
    """Yields the results of every file in `folder` that an engine reads; without `checks`, only whether each
    file compiles. `user_checks`: the user's own checks, which run only for the first file that compiles."""
    for engine in ENGINES:
        files = engine.files(written.robot.name)
        for file in files:
            if (folder / file).exists():
                path = folder / file
                file_checks = [check for check in checks if kinds_of(path) & {*check.files}]
                results, is_compiled = _check_file(path, written, engine, file_checks, user_checks, options)
                if is_compiled:
                    user_checks = ()
                # A scene includes the engine's first file, and so the user's changes to it.
                changed_files = [file, *files[:1]] if file == SCENE else [file]
                changes = written.amendments.changes_of(*changed_files)
                yield from (_with_changes(result, changes) for result in results)


def check_texts(folder: Path, written: Written) -> Iterator[Check]:
    """Checks files as text, before any engine runs."""
    robot, amendments = written.robot.name, written.amendments
    model_files = [file for engine in ENGINES for file in engine.files(robot)]
    # Files that the user's own XML names may be of any package.
    packages = None if amendments.changes_of(f"{robot}.urdf") else (written.urdf_form.package,)
    other_files = (f"{robot}{ending}" for ending in UNREAD_ENDINGS)
    for result in check_folder(folder, model_files, other_files, packages):
        file = result.name.partition(":")[0]
        yield _with_changes(result, amendments.changes_of(file) if file in model_files else ())
    yield from model_config(folder, robot)


def kinds_of(path: Path) -> set[FileKind]:
    """Returns the kinds of a model file. An MJCF without a scene beside it is itself the file that is
    simulated."""
    if path.suffix == ".urdf":
        return {"urdf"}
    if path.name == SCENE:
        return {"scene", "simulated"}
    return {"mjcf"} if (path.parent / SCENE).exists() else {"mjcf", "simulated"}


def check_formats(folder: Path, written: Written, target: TargetSection, *, quick: bool) -> Iterator[Check]:
    """Yields the results of the formats that no engine of `ENGINES` reads, and of the files for the engines
    of `target`. `quick`: whether to check only that each file can be read."""
    for row in FORMAT_CHECKS:
        path = folder / f"{written.robot.name}{row.ending}"
        if path.exists():
            results = guarded(f"{path.name}: checks", partial(row.function, path, written, quick))
            yield from (replace(result, code=row.code) for result in results)
    yield from check_targets(folder, written, target)


def _check_file(
    path: Path,
    written: Written,
    engine: Engine,
    checks: Sequence[ModelCheck],
    user_checks: Sequence[UserCheck],
    options: CheckOptions,
) -> tuple[list[Check], bool]:
    """Returns the results of a file, and whether it compiles. Its model is freed afterwards, since a large
    model takes half a gigabyte."""
    loaded = engine.load(path)
    if not checks or loaded.model is None:
        return [loaded.check], loaded.model is not None
    compiled = CompiledModel(path, loaded.model, written, options)
    with engine.warnings() as warnings:
        results = [
            *_check_model(compiled, checks),
            *(result for user_check in user_checks for result in user_check.check(compiled)),
        ]
    return [loaded.check, *results, without_warnings(f"{path.name}: runs", warnings, RUNS)], True


def readiness(folder: Path, written: Written, checks: Sequence[Check]) -> Iterator[Check]:
    """Yields the score of a robot whose MJCF compiles. `checks`: the results so far, on which some points of
    the score depend."""
    for engine in ENGINES:
        paths = [
            path
            for file in engine.files(written.robot.name)
            if (path := folder / file).exists() and "urdf" not in kinds_of(path)
        ]
        # A scene without the robot's own file is not scored. The last file is the one that is simulated: the
        # scene if there is one.
        model = engine.load(paths[-1]).model if paths and paths[0].name != SCENE else None
        if model is not None:
            yield score(FinishedRobot(folder, written.as_mjcf.robot, model, checks, written.geometry))


def _with_changes(check: Check, changes: Sequence[Amendment]) -> Check:
    """Adds to the detail of a failed check the user's changes to its file, which may be the cause: the
    changes of elements that the detail names, or all changes if it names none of them."""
    if check.passed or not changes:
        return check
    names_in_detail = set(re.findall(r"[\w.-]+", check.detail))
    related_changes = [
        change
        for change in changes
        if names_in_detail & {*change.target.split(), *" ".join(change.adds).split()}
    ]
    keys = name_list(change.key for change in related_changes or changes)
    return replace(check, detail=f"{check.detail}; the file was changed by {keys}")


def _check_model(compiled: CompiledModel, checks: Sequence[ModelCheck]) -> Iterator[Check]:
    """Yields the results of the checks; if a link or joint is missing, only those of the first check."""
    for model_check in checks[:1] if find_missing_names(compiled) else checks:
        results = guarded(
            f"{compiled.path.name}: {model_check.title}", partial(model_check.function, compiled)
        )
        yield from (replace(result, code=result.code or model_check.code) for result in results)
