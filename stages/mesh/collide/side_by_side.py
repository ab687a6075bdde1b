"""Improves colliders in parallel, in guest processes that are reused from collider to collider."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from contextlib import ExitStack, closing
from dataclasses import dataclass
from typing import Generic, TypeVar

from linkwright.stages.mesh import Shown
from linkwright.stages.mesh.collide.improvement import helper
from linkwright.stages.robot.errors import DecompositionFailed
from linkwright.stages.robot.system import process_usage
from linkwright.stages.robot.system.guest import Guest

Made = TypeVar("Made")

_PROGRESS_INTERVAL = 0.2  # s


@dataclass(frozen=True, slots=True)
class Making(Generic[Made]):
    """A task for a guest process."""

    name: str
    """Name that the user sees."""
    make: Callable[[Guest], Made]
    """Function that does the work. Its guest starts with the first request, and may have served others."""


def side_by_side(
    makings: Sequence[Making[Made]], shown: Shown | None = None, workers: int | None = None
) -> list[Made | DecompositionFailed]:
    """Returns the result or the failure of each making, in the order of the makings.

    As many makings run at once as there are `workers`, by default as many as this process may use processors.
    They start in order. `shown` is called in this thread. If this thread is interrupted, or a making raises
    another error, all guests end at once.
    """
    halt = threading.Event()
    idle_guests = [helper(halt) for _ in range(max(1, workers or process_usage.processors()))]
    running: dict[int, str] = {}

    def result(number: int, making: Making[Made]) -> Made | DecompositionFailed:
        running[number] = making.name
        # Takes the guest that was used last, since its process is already running.
        guest = idle_guests.pop()
        try:
            return making.make(guest)
        except DecompositionFailed as failed:
            return failed
        finally:
            idle_guests.append(guest)
            del running[number]

    with (
        ExitStack() as guests_to_close,
        ThreadPoolExecutor(len(idle_guests), thread_name_prefix="improve") as pool,
    ):
        for guest in idle_guests:
            guests_to_close.enter_context(closing(guest))
        futures: list[Future[Made | DecompositionFailed]] = []
        try:
            futures += (pool.submit(result, *numbered) for numbered in enumerate(makings))
            pending = set(futures)
            while pending:
                finished, pending = wait(pending, _PROGRESS_INTERVAL, FIRST_COMPLETED)
                for future in finished:
                    future.result()
                if shown is not None:
                    # A copy, made in one step, since the threads change `running` meanwhile.
                    shown(sorted(running.copy().values()), len(makings) - len(pending), len(makings))
        except BaseException:
            halt.set()
            pool.shutdown(wait=True, cancel_futures=True)
            raise
    return [future.result() for future in futures]
