"""Checks a build for its targets."""

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


def check_targets(folder: Path, written: Written, target: "TargetSection") -> Iterator[Check]:
    """Yields, for each target, the check of the file that it reads: what of it the engine does not take."""
    files = {form: f"{written.robot.name}{ending}" for form, ending in ENDINGS.items()}
    formats = [form for form, file in files.items() if (folder / file).exists()]
    for name, version in target.versions.items():
        form = ENGINES[name].format(formats)
        if form is not None:
            scene = form == "mjcf" and ENGINES[name].mujoco is not None
            yield from judge_file(name, folder / (SCENE if scene else files[form]), version, written)
