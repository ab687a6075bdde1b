"""Processes that a test started, or had started."""

import os
import subprocess
import sys
import time
from pathlib import Path

from tests.support.places import PROJECT


def gone(processes):
    """Whether the processes have ended, in time."""
    until = time.monotonic() + 30
    return all(_ended(process, until) for process in processes)


def _ended(process, until):
    while time.monotonic() < until:
        try:
            os.kill(process, 0)
            state = Path(f"/proc/{process}/stat")
            if state.exists() and state.read_text().rpartition(")")[2].split()[0] == "Z":
                return True
        except (ProcessLookupError, FileNotFoundError):
            return True
        time.sleep(0.01)
    return False


def python(*arguments, cwd=PROJECT, **more):
    """Runs this Python in a folder, with the product on its path."""
    environ = {**os.environ, "PYTHONPATH": str(PROJECT), **more}
    command = [sys.executable, *arguments]
    return subprocess.run(
        command, cwd=cwd, env=environ, capture_output=True, text=True, timeout=120, check=False
    )
