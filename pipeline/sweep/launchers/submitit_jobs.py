"""Judges jobs of submitit by the files that they leave, and ends them if the sweep is interrupted.

submitit asks Slurm's accounting, which a cluster may lack: then it waits forever for a job that was killed.
And it reports no job after the first without a result. Here a job without a result is lost if neither its
process runs nor Slurm lists it.
"""

import os
import signal
import subprocess
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from types import FrameType
from typing import Any

import submitit
from hydra.core.utils import JobReturn, JobStatus

RESULT_INTERVAL = 0.2
"""Time [s] between two looks for a result."""

SLURM_INTERVAL = 3.0
"""Time [s] between two requests to Slurm."""

FILE_PATIENCE = 15.0
"""Time [s] that a file of another host may take to appear on this host."""

Lost = Callable[[int, str], Any]
"""Maps the number of a job without a result, and the reason, to the result that the job returns instead."""


@contextmanager
def judge_jobs(lost: Lost) -> Iterator[None]:
    """Makes each job of submitit's executors return its result, or else the result of `lost`."""
    executor: Any = submitit.AutoExecutor
    submit = executor.map_array

    def map_array(self: Any, task: Any, overrides: Any, folder: Any, numbers: Any, *rest: Any) -> list[Any]:
        jobs = submit(self, task, overrides, folder, numbers, *rest)
        listing = _Listing(jobs)
        return [_JobOfSubmitit(job, number, listing, lost) for job, number in zip(jobs, numbers, strict=True)]

    executor.map_array = map_array
    try:
        yield
    finally:
        del executor.map_array


class _JobOfSubmitit:
    """A job in the form of Hydra's launcher: `results` waits, and returns the results of all its tasks."""

    def __init__(self, job: Any, number: int, listing: "_Listing", lost: Lost) -> None:
        self._job, self._number, self._listing, self._lost = job, number, listing, lost

    def results(self) -> list[Any]:
        try:
            self._wait()
        except BaseException:
            self._listing.end()
            raise
        try:
            if self._has_result():
                return list(self._job.results())
            reason = "it was killed"
        except Exception as error:
            reason = _last_line(error)
        log = os.path.relpath(self._job.paths.stderr)
        value = self._lost(self._number, f"{reason}; its log: {log}")
        return [JobReturn(_return_value=value, status=JobStatus.COMPLETED)]

    def _has_result(self) -> bool:
        # The folder is listed each time, since a network file system remembers that a file was missing.
        file = self._job.paths.result_pickle
        with suppress(OSError):
            return file in file.parent.iterdir()
        return False

    def _wait(self) -> None:
        """Waits until there is a result, or none can come any more."""
        missing_since: float | None = None
        while not self._has_result():
            if self._listing.runs(self._job):
                missing_since = None
            elif missing_since is None:
                missing_since = time.monotonic()
            elif time.monotonic() - missing_since > self._listing.patience:
                return
            time.sleep(RESULT_INTERVAL)


class _Listing:
    """Tells which jobs of a sweep still wait or run."""

    def __init__(self, jobs: Sequence[Any]) -> None:
        self._jobs = jobs
        self._is_local = isinstance(jobs[0], submitit.LocalJob)
        self._names: set[str] | None = None
        self._last_request = float("-inf")
        self.patience = 0.0 if self._is_local else FILE_PATIENCE

    def runs(self, job: Any) -> bool:
        if self._is_local:
            return not job.done()
        if time.monotonic() - self._last_request > SLURM_INTERVAL:
            self._names = _active_jobs(self._ids())
            self._last_request = time.monotonic()
        return self._names is None or job.job_id in self._names

    def end(self) -> None:
        """Ends all jobs; those that ended already are unknown to Slurm."""
        if not self._is_local:
            with suppress(OSError):
                subprocess.run(["scancel", *self._ids()], capture_output=True, check=False)
            return
        for job in self._jobs:
            with suppress(OSError):
                os.kill(int(job.job_id), signal.SIGTERM)

    def _ids(self) -> list[str]:
        return sorted({str(job.job_id).partition("_")[0] for job in self._jobs})


def _active_jobs(ids: Iterable[str]) -> set[str] | None:
    """Returns the ids of the jobs of these arrays that wait or run; None if Slurm cannot tell now."""
    command = ["squeue", "--noheader", "--array", "--format=%i", f"--jobs={','.join(ids)}"]
    try:
        process = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    except (OSError, subprocess.TimeoutExpired):
        return None
    if process.returncode == 0:
        return set(process.stdout.split())
    # Slurm forgets arrays that ended.
    return set() if "Invalid job id" in process.stderr else None


def _last_line(error: Exception) -> str:
    lines = [line.strip() for line in str(error).splitlines() if line.strip(" -")]
    messages = [
        line for line in lines if not line.startswith(("You can check full logs", "or at paths", "- "))
    ]
    return messages[-1] if messages else type(error).__name__


def within_a_job() -> None:
    """Makes signals that end the process of a job do so at once.

    If a job is queued again, submitit raises SystemExit, which any code may catch; then the job has a result
    although it runs again. And no child of submitit's local executor obeys SIGTERM.
    """
    if os.environ.get("SUBMITIT_EXECUTOR") == "local":
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
    number = getattr(signal, f"SIG{submitit.JobEnvironment.USR_SIG}")
    handler = signal.getsignal(number)
    if not callable(handler):
        return

    def at_once(received: int, frame: FrameType | None) -> None:
        try:
            handler(received, frame)
        except SystemExit:
            # Other threads end with this process, as after any kill.
            os._exit(1)

    signal.signal(number, at_once)
