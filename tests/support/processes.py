"""Processes that a test started, or had started."""

import os
import time
from collections.abc import Iterable
from pathlib import Path


def gone(processes: Iterable[int]) -> bool:
    """Whether the processes have ended, in time."""
    until = time.monotonic() + 30
    return all(_ended(process, until) for process in processes)


def _ended(process: int, until: float) -> bool:
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
