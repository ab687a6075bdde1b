"""Fits the pieces of links that meet the world: in this process, and in parallel in a second process if
there is a second processor."""

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
from linkwright.stages.mesh.by_contact.ends import End, fit_end
from linkwright.stages.mesh.collide.improvement import TASKS
from linkwright.stages.mesh.configuration.collider_settings import ContactSettings
from linkwright.stages.mesh.cut.chunk import Chunk
from linkwright.stages.robot.system import process_usage
from linkwright.stages.robot.system.guest import ONE_THREAD, Bounds, Ended, Guest

if TYPE_CHECKING:
    from collections.abc import Iterator

_BOUNDS = Bounds(seconds=600, memory=8 << 30, reply=1 << 30, wall_time_factor=4)

FittedEnd = tuple[list[Chunk], End]
"""Pieces of a link that meets the world, and how near they are to the link."""


@dataclass(frozen=True, slots=True, eq=False)
class EndToFit:
    """The task of fitting the pieces of a link that meets the world."""

    surface: Surface
    """Surface of the link."""
    starts: tuple[tuple[Chunk, ...], ...]
    """Sets of pieces with which cutting may start."""
    settings: ContactSettings

    def fitted(self) -> FittedEnd:
        """Fits the pieces, which takes seconds."""
        return fit_end(self.surface, self.starts, self.settings)

    def reply(self) -> bytes:
        """Fits the pieces in a guest process; returns the pickled pieces and `End`. A piece of the starts is
        replaced by its index, so that it keeps its identity in the asking process."""
        numbers = {
            chunk: number for number, chunk in enumerate(chunk for start in self.starts for chunk in start)
        }
        chunks, fit = self.fitted()
        return pickle.dumps(([numbers.get(chunk, chunk) for chunk in chunks], fit))


class EndFitter:
    """Fitter of ends. Its second process, if there is one, starts at once, to be ready when it is needed."""

    def __init__(self, guest: Guest | None, pool: ThreadPoolExecutor) -> None:
        self._guest, self._pool = guest, pool
        if guest is not None:
            pool.submit(self._start, guest)

    def fitted(self, ends: Sequence[EndToFit]) -> list[FittedEnd]:
        """Fits each end. The second process begins with the largest, since this one may have other work."""
        fits_by_index: dict[int, FittedEnd] = {}
        sizes = [len(end.surface.triangles) for end in ends]
        pending = deque(sorted(range(len(ends)), key=lambda number: (sizes[number], number)))

        def work(next_end: Callable[[], int], fit: Callable[[EndToFit], FittedEnd]) -> None:
            with suppress(IndexError):  # raised when no end is waiting
                while True:
                    number = next_end()
                    fits_by_index[number] = fit(ends[number])

        second_process = self._pool.submit(work, pending.pop, self._fitted_by_guest) if self._guest else None
        work(pending.popleft, EndToFit.fitted)
        if second_process is not None:
            second_process.result()
        return [fits_by_index[number] for number in range(len(ends))]

    @staticmethod
    def _start(guest: Guest) -> None:
        with suppress(Ended):
            guest.ask(b"")

    def _fitted_by_guest(self, end: EndToFit) -> FittedEnd:
        """Fits an end in the second process, or in this process if that fails."""
        assert self._guest is not None
        chunks = [chunk for start in end.starts for chunk in start]
        try:
            pieces, fit = pickle.loads(self._guest.ask(pickle.dumps(end)))
        except Ended:
            return end.fitted()
        return [chunks[chunk] if isinstance(chunk, int) else chunk for chunk in pieces], fit


@contextmanager
def end_fitter(workers: int | None = None) -> Iterator[EndFitter]:
    """Provides a fitter with one or two `workers` (default: the number of processors), and ends its second
    process afterwards."""
    halt = threading.Event()
    has_second = (workers or process_usage.processors()) > 1
    guest = Guest(TASKS, _BOUNDS, ONE_THREAD, halt) if has_second else None
    with ThreadPoolExecutor(1, thread_name_prefix="ends") as pool:
        try:
            yield EndFitter(guest, pool)
        finally:
            halt.set()
            pool.shutdown(wait=True, cancel_futures=True)
            if guest is not None:
                guest.close()
