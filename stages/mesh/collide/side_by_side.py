"""Colliders improved side by side, in as many guest processes, which stay for all of them."""

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

_SHOWN_EVERY = 0.2  # s


@dataclass(frozen=True, slots=True)
class Making(Generic[Made]):
    """What is to be made, and the name by which a user knows it.

    `make` gets a guest that starts when it is asked, and that others asked before it.
    """

    name: str
    make: Callable[[Guest], Made]


def side_by_side(
    makings: Sequence[Making[Made]], shown: Shown | None = None, workers: int | None = None
) -> list[Made | DecompositionFailed]:
    """What each makes, or how it failed, in the order of the makings, whoever is done first.

    As many run at once as this process may use processors, or `workers`; those given first start first.
    `shown` is called in this thread. Where this thread is interrupted, or one raises another error, all
    guests end at once.
    """
    halt = threading.Event()
    idle = [helper(halt) for _ in range(max(1, workers or process_usage.processors()))]
    running: dict[int, str] = {}

    def result(number: int, making: Making[Made]) -> Made | DecompositionFailed:
        running[number] = making.name
        # The one that was used last: it runs already.
        guest = idle.pop()
        try:
            return making.make(guest)
        except DecompositionFailed as failed:
            return failed
        finally:
            idle.append(guest)
            del running[number]

    with ExitStack() as closed, ThreadPoolExecutor(len(idle), thread_name_prefix="improve") as pool:
        for guest in idle:
            closed.enter_context(closing(guest))
        futures: list[Future[Made | DecompositionFailed]] = []
        try:
            futures += (pool.submit(result, *numbered) for numbered in enumerate(makings))
            waiting = set(futures)
            while waiting:
                done, waiting = wait(waiting, _SHOWN_EVERY, FIRST_COMPLETED)
                for future in done:
                    future.result()
                if shown is not None:
                    # Copied in one step: the threads change it meanwhile.
                    shown(sorted(running.copy().values()), len(makings) - len(waiting), len(makings))
        except BaseException:
            halt.set()
            pool.shutdown(wait=True, cancel_futures=True)
            raise
    return [future.result() for future in futures]
