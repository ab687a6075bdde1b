"""Nothing in the build's own code runs faster up than the assembly does: lines are counted, not seconds."""

import sys
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from types import FrameType
from typing import Any

import pytest

from stages.export import export
from stages.graph import build_robot
from stages.graph.view.views import views
from stages.robot.bundle import Bundle
from stages.robot.codec import decode_robot, encode_robot
from tests.benchmarks.large import large
from tests.benchmarks.shapes import chain, gears, ladder, screws, star
from tests.building import NO_MESHES, plan_of

STAGES = str(Path(sys.modules["stages.graph"].__file__).parents[1])

TIMES = 4
"""The larger assembly is so many times the smaller one."""

MOST = 2 * TIMES
"""A line that runs more than so many times as often is not of n log n work (of n²: 16)."""

FEW = 300
"""Lines that run less often in the larger assembly do not count: what they grow by is rounding."""

Line = tuple[str, int]


def lines_run(work: Callable[[], object]) -> Counter[Line]:
    """How often each line of the stages runs in `work`; a loop on one line counts every time round."""
    counts: Counter[Line] = Counter()

    def local(frame: FrameType, event: str, _: Any) -> Any:
        if event == "line":
            counts[frame.f_code.co_filename, frame.f_lineno] += 1
        return local

    def enter(frame: FrameType, event: str, _: Any) -> Any:
        return local if frame.f_code.co_filename.startswith(STAGES) else None

    before = sys.gettrace()
    sys.settrace(enter)
    try:
        work()
    finally:
        sys.settrace(before)
    return counts


def whole(bundle: Bundle) -> None:
    """The graph stage with all that it writes, and the export."""
    plan = plan_of()
    robot = build_robot(bundle, plan)
    views(robot)
    export(decode_robot(encode_robot(robot)), NO_MESHES, plan)


@pytest.mark.parametrize(
    ("make", "size"),
    [(large, 3), (chain, 40), (star, 20), (screws, 40), (ladder, 20), (gears, 20)],
    ids=lambda it: getattr(it, "__name__", ""),
)
def test_no_line_runs_more_often_than_the_assembly_grows(make: Callable[[int], Bundle], size: int) -> None:
    small, big = make(size), make(TIMES * size)
    whole(small)  # imports, and what is remembered of them
    before, after = lines_run(lambda: whole(small)), lines_run(lambda: whole(big))
    grown = {line: (before[line], count) for line, count in after.items() if count > FEW}
    assert grown, "nothing was counted"
    beyond = {line: pair for line, pair in grown.items() if pair[1] > MOST * pair[0]}
    told = [f"{file}:{line} {first} -> {then}" for (file, line), (first, then) in sorted(beyond.items())]
    assert not told, "\n".join(told)


def test_a_loop_within_a_loop_would_be_seen() -> None:
    """The measure itself, on a stage's function that looks at each pair of names."""
    from stages.graph.globs import entries_of
    from stages.graph.notes import Notes

    def every_pair(count: int) -> Counter[Line]:
        names = [{f"n{number}"} for number in range(count)]
        wanted = {f"n{number}": None for number in range(count)}
        return lines_run(lambda: list(entries_of(names, wanted, "here", "name", Notes())))

    before, after = every_pair(10), every_pair(40)
    assert max(after[line] / before[line] for line in after if after[line] > FEW) > MOST
