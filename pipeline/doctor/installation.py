"""Examines Python, the packages, the extras, and whether MuJoCo runs."""

import platform
import re
import subprocess
import sys
from collections.abc import Iterator
from importlib.metadata import PackageNotFoundError, requires

from packaging.requirements import Requirement

from linkwright.pipeline.doctor.examination import ExaminationResult
from linkwright.stages.robot.system.install import install, installed

EXTRAS = {
    "optuna": "sweeps that search (hydra/sweeper=optuna)",
    "proxy": "SOCKS proxies",
    "ray": "sweeps on Ray (hydra/launcher=ray)",
    "slurm": "sweeps on Slurm (hydra/launcher=slurm)",
    "sweep": "sweeps on several cores (hydra/launcher=workstation)",
    "turn": "page.preview=turn",
    "urdf": "xacro files, and meshes in DAE",
    "usd": "export=usd",
    "validate": "Pinocchio, a second engine that checks the URDF",
}
"""Extra → its purpose. The extras for the project's own tests are left out."""

_PROBE = "linkwright.stages.mujoco.probe"
_MAX_SECONDS = 60
"""Time [s] that MuJoCo may take to answer."""

_EXTRA = re.compile(r"""extra\s*==\s*["']([^"']+)["']""")
_REINSTALL = "install Linkwright again, in a fresh virtual environment"


def examine() -> Iterator[ExaminationResult]:
    """Yields the rows about the installation."""
    system = f"{platform.system()} {platform.machine()}"
    yield ExaminationResult("python", "ok", f"{platform.python_version()} on {system}: {sys.executable}")
    try:
        texts = requires("linkwright") or []
    except PackageNotFoundError:
        yield ExaminationResult(
            "linkwright", "wrong", "it runs from a folder and is not installed", "pip install ."
        )
        return
    yield ExaminationResult("linkwright", "ok", installed("linkwright"))
    yield _packages([text for text in texts if not _EXTRA.search(text)])
    yield from _extras([text for text in texts if _EXTRA.search(text)])
    yield _mujoco()


def _packages(texts: list[str]) -> ExaminationResult:
    problems = [problem for text in texts if (problem := _problem(Requirement(text)))]
    if problems:
        return ExaminationResult("packages", "wrong", "; ".join(problems), _REINSTALL)
    return ExaminationResult("packages", "ok", f"all {len(texts)} have a version that is accepted")


def _extras(texts: list[str]) -> Iterator[ExaminationResult]:
    for extra, purpose in EXTRAS.items():
        requirements = [Requirement(text) for text in texts if _EXTRA.findall(text) == [extra]]
        missing = [requirement for requirement in requirements if _problem(requirement)]
        if missing:
            detail = f"not installed; needed for {purpose}"
            names = [requirement.name for requirement in missing]
            yield ExaminationResult(f"extra {extra}", "note", detail, install(*names))
        else:
            yield ExaminationResult(f"extra {extra}", "ok", f"installed, for {purpose}")


def _problem(requirement: Requirement) -> str:
    """Returns the reason why a requirement is not met; "" if it is met, or does not apply to this
    computer."""
    marker = requirement.marker
    if marker is not None and not any(marker.evaluate({"extra": extra}) for extra in ("", *EXTRAS)):
        return ""
    version = installed(requirement.name)
    if version == "absent":
        return f"{requirement.name} is not installed"
    if requirement.specifier.contains(version, prereleases=True):
        return ""
    # The lower bound first.
    bounds = ",".join(sorted(map(str, requirement.specifier), reverse=True))
    return f"{requirement.name} is {version}, accepted is {bounds}"


def _mujoco() -> ExaminationResult:
    # In a process of its own: a library that does not suit this processor ends the process that loads it.
    try:
        process = subprocess.run(
            [sys.executable, "-m", _PROBE], capture_output=True, text=True, check=False, timeout=_MAX_SECONDS
        )
    except subprocess.TimeoutExpired:
        return ExaminationResult("mujoco", "wrong", f"it did not answer within {_MAX_SECONDS} s", _REINSTALL)
    if process.returncode:
        last_line = (process.stderr.strip().splitlines() or [f"exit status {process.returncode}"])[-1]
        return ExaminationResult("mujoco", "wrong", f"it does not run: {last_line}", _REINSTALL)
    return ExaminationResult("mujoco", "ok", f"{process.stdout.strip()} compiles and moves a model")
