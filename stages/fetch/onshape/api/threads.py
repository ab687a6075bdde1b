"""Makes a few calls at a time, in threads that never keep the process alive."""

from collections.abc import Callable, Sequence
from concurrent.futures import Future
from threading import Event, Lock, Thread
from typing import TypeVar

T = TypeVar("T")


def run_all(work: Sequence[Callable[[], T]], at_once: int) -> list[Future[T]]:
    """Runs all of `work`, `at_once` at a time; returns futures that are done or, after a failure, cancelled.

    After a failure nothing more begins, but running calls are finished. An interrupt is raised at once: a
    library's pool would wait at the process's end for a server that may take minutes.
    """
    futures: list[Future[T]] = [Future() for _ in work]
    remaining = iter(zip(work, futures, strict=True))
    lock, failed = Lock(), Event()

    def run() -> None:
        while not failed.is_set():
            with lock:
                step = next(remaining, None)
            if step is None:
                return
            call, future = step
            try:
                future.set_result(call())
            except BaseException as error:
                failed.set()
                future.set_exception(error)

    threads = [Thread(target=run, name="fetch", daemon=True) for _ in range(min(at_once, len(work)))]
    try:
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    finally:
        failed.set()
    for future in futures:
        future.cancel()
    return futures
