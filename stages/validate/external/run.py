"""Runs the checkers of other makers, each on a separate copy of the files."""

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
    SIMREADY,
    NoVerdict,
    Opinion,
    of_mjcf_doctor,
    of_simcheck,
    of_simready,
    of_urdf_validator,
)
from linkwright.stages.validate.external.tool import Tool

SECONDS = 600.0
"""Largest time [s] that a checker may take for a file."""

FILES, REPORTS, EMPTY = "files", "reports", "empty"
"""Folders of a checker's run: the copied files, its reports, and its empty working folder."""


@dataclass(frozen=True, slots=True)
class HowUsed:
    """The use of a tool."""

    files: tuple[str, ...]
    """The endings, after the robot's name, of the files that it reads. `scene.xml` is a whole name: the scene
    includes the model, and is replaced by the MJCF if there is no scene."""

    arguments: Callable[[Path, Path], list[str]]
    """Returns the arguments for a file and a folder for reports."""

    verdict: Callable[[str, Path], Opinion]
    """Reads the output and the folder of reports."""


def _simcheck(file: Path, _: Path) -> list[str]:
    srdf = file.with_suffix(".srdf")
    moveit = ["--srdf", str(srdf)] if file.suffix == ".urdf" and srdf.exists() else []
    return ["check", str(file), "--no-config", "--no-cache", "--format", "json", *moveit]


PROFILE = ("--profile", "Robot-Body", "--version", "3.0.0")
"""The profile of SimReady's standard by which a robot is checked."""


def _simready(file: Path, reports: Path) -> list[str]:
    return [*PROFILE, "--output", str(reports / SIMREADY), str(file)]


USES = {
    "simcheck": HowUsed((".urdf", ".xml"), _simcheck, of_simcheck),
    "mjcf_doctor": HowUsed(("scene.xml",), lambda file, _: ["check", str(file), "--json"], of_mjcf_doctor),
    "urdf_validator": HowUsed(
        (".urdf",), lambda file, reports: [str(file), "--output-dir", str(reports)], of_urdf_validator
    ),
    "simready": HowUsed((".usda",), _simready, of_simready),
}
"""How each tool is used."""


def checks(folder: Path, robot: str, tools: Sequence[Tool], environ: Mapping[str, str]) -> Iterator[Check]:
    """Yields a check for each tool and file, which passes if the tool has neither errors nor warnings."""
    for tool in tools:
        for file in _files(folder, robot, USES[tool.name].files):
            with tempfile.TemporaryDirectory(prefix="linkwright-") as name:
                place = Path(name).resolve()
                # Links are copied as files, since the checker may write into its files.
                shutil.copytree(folder, place / FILES, copy_function=shutil.copyfile)
                # A file in the robot's folder could have the name of a module that the checker looks for.
                (place / EMPTY).mkdir()
                (place / REPORTS).mkdir()
                yield _checked(tool, place, file, environ)


def _files(folder: Path, robot: str, endings: Sequence[str]) -> list[str]:
    names = []
    for ending in endings:
        name = ending if ending == "scene.xml" else f"{robot}{ending}"
        if ending == "scene.xml" and not (folder / name).exists():
            name = f"{robot}.xml"
        names += [name] if (folder / name).exists() else []
    return names


def _checked(tool: Tool, place: Path, file: str, environ: Mapping[str, str]) -> Check:
    name = f"{file}: {tool.program} {tool.version(environ)}"
    use = USES[tool.name]
    try:
        arguments = use.arguments(place / FILES / file, place / REPORTS)
        output = _output(tool, arguments, place, environ)
        verdict = use.verdict(output, place / REPORTS)
    except NoVerdict as error:
        return Check(name, False, f"no verdict: {error}", code=CODE)
    except subprocess.TimeoutExpired:
        return Check(name, False, f"no verdict: it took longer than {SECONDS:g} s", code=CODE)
    except (OSError, ValueError, KeyError, TypeError) as error:
        detail = f"no verdict: its output cannot be read ({type(error).__name__})"
        return Check(name, False, detail, code=CODE)
    return _check(name, verdict)


def _check(name: str, verdict: Opinion) -> Check:
    errors, warnings = verdict.errors, verdict.warnings
    message = f"{verdict.words}; " if verdict.words else ""
    detail = f"{message}{count(len(errors), 'error')}, {count(len(warnings), 'warning')}"
    first: Sequence[Finding] = errors or warnings
    if first:
        detail += f": {first[0].message}"
    level: CheckLevel = "warning" if warnings and not errors else "error"
    return Check(name, not first, detail, float(len(errors)), 0.0, CODE, level, (*errors, *warnings))


def _output(tool: Tool, arguments: Sequence[str], place: Path, environ: Mapping[str, str]) -> str:
    """Returns the output of a tool, with paths from the robot's folder. The tool gets no environment variable
    of this process except PATH, and a separate home."""
    command = tool.command(environ)
    if command is None:
        raise FileNotFoundError(tool.program)
    environment = {"PATH": environ.get("PATH", ""), "HOME": str(place), "LANG": "C.UTF-8", "NO_COLOR": "1"}
    completed = subprocess.run(
        [*command, *arguments],
        cwd=place / EMPTY,
        env={**environment, "PYTHONSAFEPATH": "1", "PYTHONDONTWRITEBYTECODE": "1", "OMP_NUM_THREADS": "1"},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        timeout=SECONDS,
        check=False,
    )
    text = completed.stdout.decode("utf-8", "replace").replace("\r\n", "\n")
    return text.replace(f"{place / FILES}{os.sep}", "")
