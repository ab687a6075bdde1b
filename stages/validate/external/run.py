"""Runs the checkers of other makers, each on a copy of its own."""

import os
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from linkwright.stages.robot.check import Check, CheckLevel, Finding
from linkwright.stages.robot.text.plural import count
from linkwright.stages.validate.external import CODE
from linkwright.stages.validate.external.opinions import (
    Opinion,
    of_mjcf_doctor,
    of_simcheck,
    of_urdf_validator,
)
from linkwright.stages.validate.external.tool import Tool

SECONDS = 600.0
"""How long a checker may take for one file."""

FILES, REPORTS, EMPTY = "files", "reports", "empty"
"""Folders of a run of a checker: the copied files, what it writes, and its working folder."""


@dataclass(frozen=True, slots=True)
class HowUsed:
    """How a tool is used: the endings of the `files` that it reads, of a robot's name (a `scene.xml` stands
    for the model that it includes); its `arguments` for a file and a folder for reports; how its output is
    read."""

    files: tuple[str, ...]
    arguments: Callable[[Path, Path], list[str]]
    verdict: Callable[[str, Path], Opinion]


def _simcheck(file: Path, _: Path) -> list[str]:
    srdf = file.with_suffix(".srdf")
    moveit = ["--srdf", str(srdf)] if file.suffix == ".urdf" and srdf.exists() else []
    return ["check", str(file), "--no-config", "--no-cache", "--format", "json", *moveit]


USES = {
    "simcheck": HowUsed((".urdf", ".xml"), _simcheck, of_simcheck),
    "mjcf_doctor": HowUsed(("scene.xml",), lambda file, _: ["check", str(file), "--json"], of_mjcf_doctor),
    "urdf_validator": HowUsed(
        (".urdf",), lambda file, reports: [str(file), "--output-dir", str(reports)], of_urdf_validator
    ),
}
"""How each tool is used."""


def checks(folder: Path, robot: str, tools: Sequence[Tool], environ: Mapping[str, str]) -> Iterator[Check]:
    """One check for each tool and file: it passes where the tool has neither errors nor warnings."""
    for tool in tools:
        for file in _files(folder, robot, USES[tool.name].files):
            with tempfile.TemporaryDirectory(prefix="linkwright-") as name:
                place = Path(name).resolve()
                # Links are followed: the checker may write into what it is given.
                shutil.copytree(folder, place / FILES, copy_function=shutil.copyfile)
                # A file of the robot could have the name of a module or a program that the checker looks for.
                (place / EMPTY).mkdir()
                (place / REPORTS).mkdir()
                yield _checked(tool, place, file, environ)


def _files(folder: Path, robot: str, endings: Sequence[str]) -> list[str]:
    found = []
    for ending in endings:
        name = ending if ending == "scene.xml" else f"{robot}{ending}"
        if ending == "scene.xml" and not (folder / name).exists():
            name = f"{robot}.xml"
        found += [name] if (folder / name).exists() else []
    return found


def _checked(tool: Tool, place: Path, file: str, environ: Mapping[str, str]) -> Check:
    name = f"{file}: {tool.program} {tool.version(environ)}"
    use = USES[tool.name]
    try:
        arguments = use.arguments(place / FILES / file, place / REPORTS)
        output = _output(tool, arguments, place, environ)
        verdict = use.verdict(output, place / REPORTS)
    except subprocess.TimeoutExpired:
        return Check(name, False, f"no verdict: it took longer than {SECONDS:g} s", code=CODE)
    except (OSError, ValueError, KeyError, TypeError) as error:
        detail = f"no verdict: its output cannot be read ({type(error).__name__})"
        return Check(name, False, detail, code=CODE)
    return _check(name, verdict)


def _check(name: str, verdict: Opinion) -> Check:
    errors, warnings = verdict.errors, verdict.warnings
    words = f"{verdict.words}; " if verdict.words else ""
    detail = f"{words}{count(len(errors), 'error')}, {count(len(warnings), 'warning')}"
    first: Sequence[Finding] = errors or warnings
    if first:
        detail += f": {first[0].message}"
    level: CheckLevel = "warning" if warnings and not errors else "error"
    return Check(name, not first, detail, float(len(errors)), 0.0, CODE, level, (*errors, *warnings))


def _output(tool: Tool, arguments: Sequence[str], place: Path, environ: Mapping[str, str]) -> str:
    """What a tool prints, with paths from the robot's folder. It sees no variable of ours but PATH, and a
    home of its own."""
    command = tool.command(environ)
    if command is None:
        raise FileNotFoundError(tool.program)
    own = {"PATH": environ.get("PATH", ""), "HOME": str(place), "LANG": "C.UTF-8", "NO_COLOR": "1"}
    done = subprocess.run(
        [*command, *arguments],
        cwd=place / EMPTY,
        env={**own, "PYTHONSAFEPATH": "1", "PYTHONDONTWRITEBYTECODE": "1", "OMP_NUM_THREADS": "1"},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        timeout=SECONDS,
        check=False,
    )
    text = done.stdout.decode("utf-8", "replace").replace("\r\n", "\n")
    return text.replace(f"{place / FILES}{os.sep}", "")
