"""Finds the program of another maker's checker, and its version."""

import functools
import importlib.util
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path

from linkwright.stages.robot.system.programs import program

MAX_VERSION_TIME = 60.0
"""Largest time [s] that a program may take to print its version."""


@dataclass(frozen=True, slots=True)
class Tool:
    """A checker of another maker."""

    name: str
    """The name in `validate.external`."""

    program: str
    """The command."""

    packages: tuple[str, ...]
    """The packages that pip installs, first that of the program."""

    reads: tuple[str, ...]
    """The formats that the checker reads."""

    module: str = ""
    """The Python module of the package; "" if Python cannot run it."""

    main: str = ""
    """The module that `python -m` runs."""

    pythons: tuple[tuple[int, int], ...] = ()
    """The versions of Python on which the packages install, if not all."""

    def command(self, environ: Mapping[str, str]) -> tuple[str, ...] | None:
        """Returns the program on PATH, or the module of this Python; None if there is neither."""
        path = program(self.program, environ)
        if path is not None:
            return (path,)
        if self.module and importlib.util.find_spec(self.module) is not None:
            return sys.executable, "-P", "-m", self.main or self.module
        return None

    def version(self, environ: Mapping[str, str]) -> str:
        """Returns the version; for a program that does not print it, a text that changes with the program."""
        command = self.command(environ)
        return "" if command is None else _version(command, self.packages, environ.get("PATH", ""))


@functools.cache
def _version(command: tuple[str, ...], packages: tuple[str, ...], path: str) -> str:
    version_text = _output((*command, "--version"), path)
    if version_text is None:
        version_text = _output((_interpreter(command[0]), "-I", "-c", _VERSIONS_PROGRAM, *packages), path)
    words = (version_text or "").split()
    return words[-1] if words else sha256(Path(command[0]).read_bytes()).hexdigest()[:12]


_VERSIONS_PROGRAM = (
    "import importlib.metadata as m, sys; print('+'.join(dict.fromkeys(map(m.version, sys.argv[1:]))))"
)
"""A program that prints the versions of packages, equal versions once."""


def _interpreter(program: str) -> str:
    """Returns the Python that runs a script of pip, which its first line names."""
    with open(program, "rb") as file:
        first = file.readline(512)
    interpreter = (
        first.removeprefix(b"#!").strip().decode("utf-8", "replace") if first.startswith(b"#!") else ""
    )
    return interpreter if "python" in interpreter and " " not in interpreter else sys.executable


def _output(command: tuple[str, ...], path: str) -> str | None:
    """Returns the output of a program in an empty working folder; None if the program fails."""
    try:
        with tempfile.TemporaryDirectory(prefix="linkwright-") as empty:
            completed = subprocess.run(
                command,
                cwd=empty,
                env={"PATH": path, "PYTHONSAFEPATH": "1"},
                stdin=subprocess.DEVNULL,
                capture_output=True,
                text=True,
                timeout=MAX_VERSION_TIME,
                check=False,
            )
    except (OSError, subprocess.TimeoutExpired):
        return None
    return completed.stdout if completed.returncode == 0 and completed.stdout.strip() else None
