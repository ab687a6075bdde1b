"""Computes the share of the processors for a job of a sweep."""

from collections.abc import Mapping
from typing import Any


def share(launcher: Mapping[str, Any], jobs: int, processors: int) -> int | None:
    """Returns the number of processors that a job may use under the settings of a launcher with `jobs` jobs,
    on a computer with `processors` processors; None if a job may use the whole computer. The share does not
    limit the launcher itself: it keeps jobs on the same computer from taking all processors each.
    """
    name = str(launcher.get("_target_")).rpartition(".")[2]
    if name == "JoblibLauncher":
        return max(1, processors // min(_parallel_jobs(launcher.get("n_jobs"), processors), jobs))
    if name == "LocalLauncher":
        return max(1, processors // jobs)
    if name == "SlurmLauncher":
        return int(launcher.get("cpus_per_task") or 1)
    if name == "RayLauncher":
        return max(1, int(launcher["ray"]["remote"].get("num_cpus") or 1))
    return None


def _parallel_jobs(number: int | None, processors: int) -> int:
    """Returns the number of jobs that joblib runs at once; a negative number leaves some processors free."""
    jobs = 1 if number is None else int(number)
    return max(1, jobs if jobs >= 0 else processors + 1 + jobs)
