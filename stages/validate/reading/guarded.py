"""Checks of files that may be anything: one that breaks over a file does not take the others with it."""

from collections.abc import Callable, Iterable, Iterator

from linkwright.stages.robot.check import Check


def guarded(name: str, make: Callable[[], Iterable[Check]]) -> Iterator[Check]:
    """The results that `make` gives; where it breaks off, one called `name` that fails and says why."""
    try:
        yield from make()
    except Exception as error:
        what = " ".join(f"{type(error).__name__}: {error}".split())
        detail = f"it cannot be checked, since something that it needs is missing or broken ({what})"
        yield Check(name, False, detail)
