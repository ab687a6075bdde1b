"""Ends fitted side by side: in this process, and in a second one where there is a second processor."""

from __future__ import annotations

import pickle
import threading
from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING

from linkwright.stages.formats.meshes.surface import Surface
from linkwright.stages.mesh.by_contact.ends import End, fitted_end
from linkwright.stages.mesh.collide.improvement import TASKS
from linkwright.stages.mesh.configuration.collider_settings import ContactSettings
from linkwright.stages.mesh.cut.piece import Chunk
from linkwright.stages.robot.system import process_usage
from linkwright.stages.robot.system.guest import ONE_THREAD, Bounds, Ended, Guest

if TYPE_CHECKING:
    from collections.abc import Iterator

_BOUNDS = Bounds(seconds=600, memory=8 << 30, reply=1 << 30, shared=4)

FittedEnd = tuple[list[Chunk], End]
"""The pieces of a link that meets the world, and how near they are to it."""


@dataclass(frozen=True, slots=True, eq=False)
class EndToFit:
    """A link that meets the world: its `surface`, and the pieces that cutting may start from."""

    surface: Surface
    starts: tuple[tuple[Chunk, ...], ...]
    settings: ContactSettings

    def fitted(self) -> FittedEnd:
        """Takes seconds."""
        return fitted_end(self.surface, self.starts, self.settings)

    def reply(self) -> bytes:
        """What a guest answers: a number for each of the pieces that it had before, other pieces themselves,
        and the `End`."""
        given = {
            chunk: number for number, chunk in enumerate(chunk for start in self.starts for chunk in start)
        }
        made, fit = self.fitted()
        return pickle.dumps(([given.get(chunk, chunk) for chunk in made], fit))


class EndFitter:
    """Fits ends. Its second process, if it has one, starts at once, so that it is there when it is needed."""

    def __init__(self, guest: Guest | None, pool: ThreadPoolExecutor) -> None:
        self._guest, self._pool = guest, pool
        if guest is not None:
            pool.submit(self._started, guest)

    def fitted(self, ends: Sequence[EndToFit]) -> list[FittedEnd]:
        """Each end fitted. The second process begins with the largest, since this one may have other work."""
        done: dict[int, FittedEnd] = {}
        sizes = [len(end.surface.triangles) for end in ends]
        waiting = deque(sorted(range(len(ends)), key=lambda number: (sizes[number], number)))

        def work(next_end: Callable[[], int], fit: Callable[[EndToFit], FittedEnd]) -> None:
            with suppress(IndexError):  # when all have been begun
                while True:
                    number = next_end()
                    done[number] = fit(ends[number])

        beside = self._pool.submit(work, waiting.pop, self._asked) if self._guest else None
        work(waiting.popleft, EndToFit.fitted)
        if beside is not None:
            beside.result()
        return [done[number] for number in range(len(ends))]

    @staticmethod
    def _started(guest: Guest) -> None:
        with suppress(Ended):
            guest.ask(b"")

    def _asked(self, end: EndToFit) -> FittedEnd:
        """The same by the second process, or by this one where that fails."""
        assert self._guest is not None
        given = [chunk for start in end.starts for chunk in start]
        try:
            made, fit = pickle.loads(self._guest.ask(pickle.dumps(end)))
        except Ended:
            return end.fitted()
        return [given[chunk] if isinstance(chunk, int) else chunk for chunk in made], fit


@contextmanager
def end_fitter(workers: int | None = None) -> Iterator[EndFitter]:
    """A fitter with as many `workers` as there are processors, at most two; no process is left behind."""
    halt = threading.Event()
    two = (workers or process_usage.processors()) > 1
    guest = Guest(TASKS, _BOUNDS, ONE_THREAD, halt) if two else None
    with ThreadPoolExecutor(1, thread_name_prefix="ends") as pool:
        try:
            yield EndFitter(guest, pool)
        finally:
            halt.set()
            pool.shutdown(wait=True, cancel_futures=True)
            if guest is not None:
                guest.close()
