"""Checks the files of a build for each of its targets."""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from linkwright.stages.formats.written import Written
from linkwright.stages.robot.check import Check
from linkwright.stages.targets.engines import ENGINES
from linkwright.stages.validate.compiled import SCENE
from linkwright.stages.validate.targets.judge import ENDINGS, judge_file

if TYPE_CHECKING:
    from linkwright.stages.targets.section import TargetSection


def check_targets(folder: Path, written: Written, section: "TargetSection") -> Iterator[Check]:
    """Yields, for each target, the check of the file that its engine reads. It fails if the file contains
    anything that the engine does not support."""
    file_by_format = {form: f"{written.robot.name}{ending}" for form, ending in ENDINGS.items()}
    formats = [form for form, file in file_by_format.items() if (folder / file).exists()]
    for target, version in section.versions.items():
        engine = ENGINES[target]
        form = engine.format(formats)
        # None: the build has no file in a format that the engine reads.
        if form is None:
            continue
        # Engines whose models MuJoCo compiles load the scene, which includes the robot.
        reads_scene = form == "mjcf" and engine.mujoco is not None
        file = SCENE if reads_scene else file_by_format[form]
        yield from judge_file(target, folder / file, version, written)
