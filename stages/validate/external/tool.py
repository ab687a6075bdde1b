"""A checker of another maker: where its program is, and which version."""

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

PATIENCE = 60.0
"""How long a program may take to say its version [s]."""


@dataclass(frozen=True, slots=True)
class Tool:
    """`name` as in `validate.external`; `program`: its command; `package`: what pip installs; `module`: the
    package's Python module, and `main` the one that `python -m` runs."""

    name: str
    program: str
    package: str
    module: str
    main: str = ""

    def command(self, environ: Mapping[str, str]) -> tuple[str, ...] | None:
        """The program on PATH, or the module of this Python; None where there is neither."""
        found = program(self.program, environ)
        if found is not None:
            return (found,)
        if importlib.util.find_spec(self.module) is not None:
            return sys.executable, "-P", "-m", self.main or self.module
        return None

    def version(self, environ: Mapping[str, str]) -> str:
        """Its version; of a program that does not say it, one that changes where the program does."""
        command = self.command(environ)
        return "" if command is None else _version(command, self.package, environ.get("PATH", ""))


@functools.cache
def _version(command: tuple[str, ...], package: str, path: str) -> str:
    said = _said((*command, "--version"), path)
    if said is None:
        said = _said((_interpreter(command[0]), "-I", "-c", _ASK, package), path)
    words = (said or "").split()
    return words[-1] if words else sha256(Path(command[0]).read_bytes()).hexdigest()[:12]


_ASK = "import importlib.metadata, sys; print(importlib.metadata.version(sys.argv[1]))"


def _interpreter(program: str) -> str:
    """The Python that a script of pip's runs with: its first line names it."""
    with open(program, "rb") as file:
        first = file.readline(512)
    named = first.removeprefix(b"#!").strip().decode("utf-8", "replace") if first.startswith(b"#!") else ""
    return named if "python" in named and " " not in named else sys.executable


def _said(command: tuple[str, ...], path: str) -> str | None:
    """What a program prints, in an empty working folder; None where it fails."""
    try:
        with tempfile.TemporaryDirectory(prefix="linkwright-") as empty:
            done = subprocess.run(
                command,
                cwd=empty,
                env={"PATH": path, "PYTHONSAFEPATH": "1"},
                stdin=subprocess.DEVNULL,
                capture_output=True,
                text=True,
                timeout=PATIENCE,
                check=False,
            )
    except (OSError, subprocess.TimeoutExpired):
        return None
    return done.stdout if done.returncode == 0 and done.stdout.strip() else None
