"""The run of a validation: every engine reads its files, and every check looks at what it compiled."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

from linkwright.stages.formats.written import Written
from linkwright.stages.robot.check import Check
from linkwright.stages.robot.model.amendments import Amendment
from linkwright.stages.robot.text.globs import listed
from linkwright.stages.validate.check_options import AS_STANDARD, Asked
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
from linkwright.stages.validate.model.coordinates import missing_names
from linkwright.stages.validate.readiness.finished import Finished
from linkwright.stages.validate.readiness.score import score
from linkwright.stages.validate.reading.guarded import guarded
from linkwright.stages.validate.rows import ModelCheck
from linkwright.stages.validate.user_checks import OwnCheck

OTHERS = (".sdf", ".srdf", ".usda")
"""Endings of files of a build that no engine reads, and that may name assets."""

RUNS = "C-RUNS"


def check_files(
    folder: Path,
    written: Written,
    checks: Sequence[ModelCheck],
    own: Sequence[OwnCheck] = (),
    asked: Asked = AS_STANDARD,
) -> Iterator[Check]:
    """The results of every file in `folder` that one of the engines reads. Without `checks`, whether each
    compiles. `own`: the user's checks, of the first file."""
    for engine in ENGINES:
        files = engine.files(written.robot.name)
        for file in files:
            if (folder / file).exists():
                given = CompiledModel(folder / file, None, written, asked)
                changes = written.amendments.of(file, *files[:1] if file == SCENE else ())
                chosen = [check for check in checks if kinds_of(given.path) & {*check.files}]
                found, own = _check_file(given, engine, chosen, own), ()
                yield from (_with_changes(one, changes) for one in found)


def check_texts(folder: Path, written: Written) -> Iterator[Check]:
    """The checks of files as text, before any engine runs."""
    robot, amendments = written.robot.name, written.amendments
    models = [file for engine in ENGINES for file in engine.files(robot)]
    # What the user's own XML names may be of any package.
    packages = None if amendments.of(f"{robot}.urdf") else (written.urdf_form.package,)
    for one in check_folder(folder, models, (f"{robot}{ending}" for ending in OTHERS), packages):
        file = one.name.partition(":")[0]
        yield _with_changes(one, amendments.of(file) if file in models else ())
    yield from model_config(folder, robot)


def kinds_of(path: Path) -> set[FileKind]:
    """What a model file in its folder is to a check."""
    if path.suffix == ".urdf":
        return {"urdf"}
    if path.name == SCENE:
        return {"scene", "simulated"}
    return {"mjcf"} if (path.parent / SCENE).exists() else {"mjcf", "simulated"}


def check_formats(folder: Path, written: Written, *, quick: bool) -> Iterator[Check]:
    """The results of the files in `folder` that no engine reads. `quick`: only whether each can be read."""
    for row in FORMAT_CHECKS:
        path = folder / f"{written.robot.name}{row.ending}"
        if path.exists():
            found = guarded(f"{path.name}: checks", partial(row.function, path, written, quick))
            yield from (replace(check, code=row.code) for check in found)


def _check_file(
    given: CompiledModel, engine: Engine, checks: Sequence[ModelCheck], own: Sequence[OwnCheck]
) -> list[Check]:
    """The results of one file, yet without its model, which is given up afterwards: a large one takes half a
    gigabyte."""
    path = given.path
    loaded = engine.load(path)
    if not checks or loaded.model is None:
        return [loaded.check]
    compiled = replace(given, model=loaded.model)
    with engine.warnings() as warnings:
        found = [*_check_model(compiled, checks), *(one for mine in own for one in mine.check(compiled))]
    return [loaded.check, *found, without_warnings(f"{path.name}: runs", warnings, RUNS)]


def readiness(folder: Path, written: Written, checks: Sequence[Check]) -> Iterator[Check]:
    """The score of a robot that has an MJCF which compiles. `checks`: the results so far, which prove some of
    its points."""
    for engine in ENGINES:
        there = [
            folder / file
            for file in engine.files(written.robot.name)
            if "urdf" not in kinds_of(folder / file)
        ]
        there = [path for path in there if path.exists()]
        model = engine.load(there[-1]).model if there and there[0].name != SCENE else None
        if model is not None:
            yield score(Finished(folder, written.as_mjcf.robot, model, checks, written.geometry))


def _with_changes(check: Check, changes: Sequence[Amendment]) -> Check:
    """A check that fails says which of the user's own changes to the file may be why: those of what it names,
    else all."""
    if check.passed or not changes:
        return check
    words = set(re.findall(r"[\w.-]+", check.detail))
    near = [one for one in changes if words & {*one.target.split(), *" ".join(one.adds).split()}]
    keys = listed(one.key for one in near or changes)
    return replace(check, detail=f"{check.detail}; the file was changed by {keys}")


def _check_model(compiled: CompiledModel, checks: Sequence[ModelCheck]) -> Iterator[Check]:
    """The results of the checks; of the first alone where a link or joint is missing."""
    for row in checks[:1] if missing_names(compiled) else checks:
        found = guarded(f"{compiled.path.name}: {row.title}", partial(row.function, compiled))
        yield from (replace(check, code=check.code or row.code) for check in found)
