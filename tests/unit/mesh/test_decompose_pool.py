"""Decompositions side by side: the same results for any number of workers, and an end when interrupted."""

import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from stages.mesh.decompose import DecomposeOptions, Guest, decomposition
from stages.mesh.decompose.pool import Making, processors, side_by_side
from stages.robot.errors import DecompositionFailed
from tests.support.places import PROJECT
from tests.unit.mesh.test_decompose import BRACKET, CLAMP

OPTIONS = DecomposeOptions(0.001)


def made(surface):
    return lambda halt: decomposition(surface, OPTIONS, Guest(halt=halt))


@pytest.mark.slow
def test_one_worker_and_two_make_the_same_in_any_order() -> None:
    makings = [Making("bracket", made(BRACKET)), Making("clamp", made(CLAMP))]
    one = side_by_side(makings, workers=1)
    two = side_by_side(makings[::-1], workers=2)
    assert one == two[::-1]
    assert all(isinstance(result, bytes) for result in one)


def test_a_failure_is_the_result_of_its_own_maker_alone() -> None:
    def fails(halt: threading.Event) -> int:
        raise DecompositionFailed("no")

    first, second, third = side_by_side(
        [Making("a", lambda _: 1), Making("b", fails), Making("c", lambda _: 3)]
    )
    assert (first, third) == (1, 3)
    assert isinstance(second, DecompositionFailed)


def test_it_tells_what_runs_and_how_much_is_done() -> None:
    lines: list[tuple[list[str], int, int]] = []
    gate = threading.Event()

    def shown(running, done, total) -> None:
        lines.append((list(running), done, total))
        if running == ["slow"]:
            gate.set()

    side_by_side([Making("quick", lambda _: 0), Making("slow", lambda _: gate.wait(30))], shown, workers=2)
    assert (["slow"], 1, 2) in lines
    assert lines[-1] == ([], 2, 2)


def test_another_error_ends_the_guests_of_all(tmp_path, monkeypatch) -> None:
    monkeypatch.syspath_prepend(tmp_path)
    place = tmp_path / "started"
    (tmp_path / "sleeper.py").write_text(
        "def answer(request):\n"
        "    import time\n"
        f"    open({str(place)!r}, 'w').close()\n"
        "    time.sleep(1000)\n"
    )

    def sleeps(halt: threading.Event) -> bytes:
        return decomposition(CLAMP, OPTIONS, Guest("sleeper", halt=halt))

    def breaks(halt: threading.Event) -> bytes:
        while not place.exists():
            time.sleep(0.01)
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        side_by_side([Making("sleeps", sleeps), Making("breaks", breaks)], workers=2)


INTERRUPTED = """
import sys, threading
from stages.mesh.decompose import DecomposeOptions, Guest, decomposition
from stages.mesh.decompose.pool import Making, side_by_side
from tests.unit.mesh.test_decompose import CLAMP
sys.path.append(sys.argv[1])
def sleeps(halt):
    return decomposition(CLAMP, DecomposeOptions(0.001), Guest("sleeper", halt=halt))
try:
    side_by_side([Making("one", sleeps), Making("two", sleeps), Making("three", sleeps)], workers=2)
except KeyboardInterrupt:
    print("interrupted", flush=True)
"""


@pytest.mark.skipif(os.name == "nt", reason="another signal")
def test_ctrl_c_ends_all_guests(tmp_path: Path) -> None:
    (tmp_path / "sleeper.py").write_text(
        "def answer(request):\n"
        "    import os, time\n"
        f"    open(f'{tmp_path}/{{os.getpid()}}.pid', 'w').close()\n"
        "    time.sleep(1000)\n"
    )
    command = [sys.executable, "-c", INTERRUPTED, str(tmp_path)]
    with subprocess.Popen(command, cwd=PROJECT, stdout=subprocess.PIPE, text=True) as run:
        until = time.monotonic() + 60
        while len(started := list(tmp_path.glob("*.pid"))) < 2 and time.monotonic() < until:
            time.sleep(0.02)
        assert len(started) == 2
        run.send_signal(signal.SIGINT)
        said, _ = run.communicate(timeout=60)
    assert said == "interrupted\n"
    for file in tmp_path.glob("*.pid"):
        with pytest.raises(ProcessLookupError):
            os.kill(int(file.stem), 0)
    assert len(list(tmp_path.glob("*.pid"))) == 2


def test_there_is_at_least_one_processor() -> None:
    assert processors() >= 1
