"""Runs the checkers of other makers, each on a separate copy of the files."""

import os
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from linkwright.stages.robot.check import Check, CheckLevel
from linkwright.stages.robot.text.plural import count
from linkwright.stages.validate.external import CODE
from linkwright.stages.validate.external.opinions import (
    SIMREADY_REPORT,
    NoVerdict,
    Opinion,
    read_mjcf_doctor,
    read_simcheck,
    read_simready,
    read_urdf_validator,
)
from linkwright.stages.validate.external.tool import Tool

MAX_SECONDS = 600.0
"""Largest time [s] that a checker may take for a file."""

FILES_FOLDER, REPORTS_FOLDER, EMPTY_FOLDER = "files", "reports", "empty"
"""Subfolders of a run: copies of the robot's files, the checker's reports, and its empty working folder."""


@dataclass(frozen=True, slots=True)
class ToolUse:
    """How a checker is run on a file, and how its verdict is read."""

    endings: tuple[str, ...]
    """The endings, after the robot's name, of the files that the checker reads. `scene.xml` is a whole name:
    the scene includes the model, and is replaced by the MJCF if there is no scene."""

    make_arguments: Callable[[Path, Path], list[str]]
    """Returns the arguments for a file and a folder for reports."""

    read_opinion: Callable[[str, Path], Opinion]
    """Reads the opinion from the output and the folder of reports. Raises NoVerdict if there is none."""


def _simcheck_arguments(file: Path, reports: Path) -> list[str]:
    del reports
    srdf = file.with_suffix(".srdf")
    moveit = ["--srdf", str(srdf)] if file.suffix == ".urdf" and srdf.exists() else []
    return ["check", str(file), "--no-config", "--no-cache", "--format", "json", *moveit]


SIMREADY_PROFILE = ("--profile", "Robot-Body", "--version", "3.0.0")
"""The profile of SimReady's standard by which a robot is checked."""


def _simready_arguments(file: Path, reports: Path) -> list[str]:
    return [*SIMREADY_PROFILE, "--output", str(reports / SIMREADY_REPORT), str(file)]


USES = {
    "simcheck": ToolUse((".urdf", ".xml"), _simcheck_arguments, read_simcheck),
    "mjcf_doctor": ToolUse(("scene.xml",), lambda file, _: ["check", str(file), "--json"], read_mjcf_doctor),
    "urdf_validator": ToolUse(
        (".urdf",), lambda file, reports: [str(file), "--output-dir", str(reports)], read_urdf_validator
    ),
    "simready": ToolUse((".usda",), _simready_arguments, read_simready),
}
"""Name of a tool, as in `TOOLS` → its use."""


def run_checkers(
    folder: Path, robot: str, tools: Sequence[Tool], environ: Mapping[str, str]
) -> Iterator[Check]:
    """Yields a check for each tool and each file of the robot that the tool reads. It passes if the tool
    reports neither errors nor warnings.

    `folder`: the folder of the robot's files; `robot`: its name; `environ`: environment variables, of which
    the tool sees only PATH.
    """
    for tool in tools:
        for file in _files(folder, robot, USES[tool.name].endings):
            with tempfile.TemporaryDirectory(prefix="linkwright-") as name:
                run_folder = Path(name).resolve()
                # Links are copied as files, since the checker may write into its files.
                shutil.copytree(folder, run_folder / FILES_FOLDER, copy_function=shutil.copyfile)
                # The checker's working folder is empty: in the robot's folder, a file could have the name of
                # a module that the checker imports.
                (run_folder / EMPTY_FOLDER).mkdir()
                (run_folder / REPORTS_FOLDER).mkdir()
                yield _check_file(tool, run_folder, file, environ)


def _files(folder: Path, robot: str, endings: Sequence[str]) -> list[str]:
    """Returns the names of the robot's files with these endings (see `ToolUse.endings`) that exist."""
    names = []
    for ending in endings:
        name = ending if ending == "scene.xml" else f"{robot}{ending}"
        if ending == "scene.xml" and not (folder / name).exists():
            name = f"{robot}.xml"
        names += [name] if (folder / name).exists() else []
    return names


def _check_file(tool: Tool, run_folder: Path, file: str, environ: Mapping[str, str]) -> Check:
    """Runs a tool on a file, and returns its opinion as a check; a check that fails if it has none."""
    name = f"{file}: {tool.program} {tool.version(environ)}"
    use = USES[tool.name]
    reports = run_folder / REPORTS_FOLDER
    try:
        arguments = use.make_arguments(run_folder / FILES_FOLDER / file, reports)
        opinion = use.read_opinion(_run_tool(tool, arguments, run_folder, environ), reports)
    except NoVerdict as error:
        return Check(name, False, f"no verdict: {error}", code=CODE)
    except subprocess.TimeoutExpired:
        return Check(name, False, f"no verdict: it took longer than {MAX_SECONDS:g} s", code=CODE)
    except (OSError, ValueError, KeyError, TypeError) as error:
        detail = f"no verdict: its output cannot be read ({type(error).__name__})"
        return Check(name, False, detail, code=CODE)
    return _opinion_check(name, opinion)


def _opinion_check(name: str, opinion: Opinion) -> Check:
    """Returns an opinion as a check, whose detail has the tool's summary, and its first error or warning."""
    errors, warnings = opinion.errors, opinion.warnings
    summary = f"{opinion.words}; " if opinion.words else ""
    detail = f"{summary}{count(len(errors), 'error')}, {count(len(warnings), 'warning')}"
    findings = (*errors, *warnings)
    if findings:
        detail += f": {findings[0].message}"
    level: CheckLevel = "warning" if warnings and not errors else "error"
    return Check(name, not findings, detail, float(len(errors)), 0.0, CODE, level, findings)


def _run_tool(tool: Tool, arguments: Sequence[str], run_folder: Path, environ: Mapping[str, str]) -> str:
    """Returns the output of a tool, in which paths start at the robot's folder. The tool gets no environment
    variable of this process except PATH, and a separate home. Raises FileNotFoundError if the tool is not
    installed, and TimeoutExpired."""
    command = tool.command(environ)
    if command is None:
        raise FileNotFoundError(tool.program)
    completed = subprocess.run(
        [*command, *arguments],
        cwd=run_folder / EMPTY_FOLDER,
        env={
            "PATH": environ.get("PATH", ""),
            "HOME": str(run_folder),
            "LANG": "C.UTF-8",
            "NO_COLOR": "1",
            "PYTHONSAFEPATH": "1",
            "PYTHONDONTWRITEBYTECODE": "1",
            "OMP_NUM_THREADS": "1",
        },
        stdin=subprocess.DEVNULL,
        capture_output=True,
        timeout=MAX_SECONDS,
        # The exit status tells of errors in the file, which the output has.
        check=False,
    )
    text = completed.stdout.decode("utf-8", "replace").replace("\r\n", "\n")
    return text.replace(f"{run_folder / FILES_FOLDER}{os.sep}", "")
