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

SCENE_FILE = "scene.xml"
"""Name of a scene's file."""

SIMREADY_PROFILE = ("--profile", "Robot-Body", "--version", "3.0.0")
"""The profile of SimReady's standard by which a robot is checked."""


@dataclass(frozen=True, slots=True)
class ToolUse:
    """How a checker is run on a file, and how its verdict is read."""

    endings: tuple[str, ...]
    """The endings of the files that the checker reads, after the robot's name. The entry `scene.xml` is
    an exception: it is a whole file name. The scene includes the MJCF; if there is no scene, the MJCF
    itself is read."""

    make_arguments: Callable[[Path, Path], list[str]]
    """Returns the arguments for a file and a folder for reports."""

    read_opinion: Callable[[str, Path], Opinion]
    """Reads the opinion from the output and the folder of reports. Raises NoVerdict if there is none."""


def _simcheck_arguments(file: Path, reports: Path) -> list[str]:
    del reports
    srdf = file.with_suffix(".srdf")
    moveit = ["--srdf", str(srdf)] if file.suffix == ".urdf" and srdf.exists() else []
    return ["check", str(file), "--no-config", "--no-cache", "--format", "json", *moveit]


def _simready_arguments(file: Path, reports: Path) -> list[str]:
    return [*SIMREADY_PROFILE, "--output", str(reports / SIMREADY_REPORT), str(file)]


TOOL_USES = {
    "simcheck": ToolUse((".urdf", ".xml"), _simcheck_arguments, read_simcheck),
    "mjcf_doctor": ToolUse((SCENE_FILE,), lambda file, _: ["check", str(file), "--json"], read_mjcf_doctor),
    "urdf_validator": ToolUse(
        (".urdf",), lambda file, reports: [str(file), "--output-dir", str(reports)], read_urdf_validator
    ),
    "simready": ToolUse((".usda",), _simready_arguments, read_simready),
}
"""Name of a tool, as in `TOOLS` → its use."""


def run_checkers(
    folder: Path, robot_name: str, tools: Sequence[Tool], environ: Mapping[str, str]
) -> Iterator[Check]:
    """Yields a check for each tool and each file of the robot that the tool reads. It passes if the tool
    reports neither errors nor warnings.

    `folder`: the folder of the robot's files; `environ`: environment variables, of which the tool sees only
    PATH.
    """
    for tool in tools:
        for file_name in _existing_file_names(folder, robot_name, TOOL_USES[tool.name].endings):
            with tempfile.TemporaryDirectory(prefix="linkwright-") as temporary_folder:
                run_folder = Path(temporary_folder).resolve()
                # Symbolic links are copied as files (`copytree`'s default), and permissions are not copied
                # (`copyfile`), since the checker may write into its files.
                shutil.copytree(folder, run_folder / FILES_FOLDER, copy_function=shutil.copyfile)
                # The checker's working folder is empty: in the robot's folder, a file could have the name of
                # a module that the checker imports.
                (run_folder / EMPTY_FOLDER).mkdir()
                (run_folder / REPORTS_FOLDER).mkdir()
                yield _check_file(tool, run_folder, file_name, environ)


def _existing_file_names(folder: Path, robot_name: str, endings: Sequence[str]) -> list[str]:
    """Returns the names of the robot's files with these endings (see `ToolUse.endings`) that exist."""
    names = [_file_name(folder, robot_name, ending) for ending in endings]
    return [name for name in names if (folder / name).exists()]


def _file_name(folder: Path, robot_name: str, ending: str) -> str:
    """Returns the name of the robot's file for an entry of `ToolUse.endings`."""
    if ending != SCENE_FILE:
        return f"{robot_name}{ending}"
    return SCENE_FILE if (folder / SCENE_FILE).exists() else f"{robot_name}.xml"


def _check_file(tool: Tool, run_folder: Path, file_name: str, environ: Mapping[str, str]) -> Check:
    """Runs a tool on a file, and returns its opinion as a check, which fails if the tool has no opinion."""
    name = f"{file_name}: {tool.program} {tool.version(environ)}"
    use = TOOL_USES[tool.name]
    reports = run_folder / REPORTS_FOLDER
    arguments = use.make_arguments(run_folder / FILES_FOLDER / file_name, reports)
    try:
        output = _run_tool(tool, arguments, run_folder, environ)
    except subprocess.TimeoutExpired:
        return _no_verdict_check(name, f"it took longer than {MAX_SECONDS:g} s")
    except OSError as error:
        return _no_verdict_check(name, f"it cannot be run ({error})")
    try:
        opinion = use.read_opinion(output, reports)
    except NoVerdict as error:
        return _no_verdict_check(name, str(error))
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        return _no_verdict_check(name, f"its output cannot be read ({type(error).__name__})")
    return _opinion_check(name, opinion)


def _no_verdict_check(name: str, reason: str) -> Check:
    return Check(name, False, f"no verdict: {reason}", code=CODE)


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
    installed, and TimeoutExpired after `MAX_SECONDS`."""
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
        # A checker also exits with an error status if the file has errors; the output lists them.
        check=False,
    )
    text = completed.stdout.decode("utf-8", "replace").replace("\r\n", "\n")
    return text.replace(f"{run_folder / FILES_FOLDER}{os.sep}", "")
