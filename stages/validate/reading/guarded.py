"""Runs checks of files of any content: an exception in a check does not stop the others."""

from collections.abc import Callable, Iterable, Iterator

from linkwright.stages.robot.check import Check


def guarded(name: str, make: Callable[[], Iterable[Check]]) -> Iterator[Check]:
    """Yields the results of `make`; if it raises, a failed result called `name` with the reason."""
    try:
        yield from make()
    except Exception as error:
        reason = " ".join(f"{type(error).__name__}: {error}".split())
        detail = f"it cannot be checked, since something that it needs is missing or broken ({reason})"
        yield Check(name, False, detail)
