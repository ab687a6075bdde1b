"""Colliders improved side by side: the same for any number of workers, and an end when interrupted."""

import os
import signal
import subprocess
import sys
import threading
import time
from functools import partial

import pytest

from linkwright.stages.mesh.collide import side_by_side as pool
from linkwright.stages.mesh.collide.improvement import helper, improved
from linkwright.stages.mesh.collide.side_by_side import Making, side_by_side
from linkwright.stages.robot.errors import DecompositionFailed
from tests.support.decomposing import improved as alone
from tests.support.decomposing import task
from tests.support.places import PROJECT
from tests.support.processes import gone
from tests.unit.mesh.test_decompose import BRACKET, CLAMP, RING

pytestmark = pytest.mark.slow


def made(surface):
    return lambda guest: improved(task(surface), guest)


@pytest.fixture
def stand_in(tmp_path, monkeypatch):
    """Puts another guest in the place of CoACD's, with these lines as its `answer(request)`, and gives the
    numbers of the processes that answered until then."""
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(pool, "helper", partial(helper, module="stand_in"))

    def put(*lines):
        (tmp_path / "stand_in.py").write_text(
            STAND_IN.format(tmp_path) + "".join(f"    {line}\n" for line in lines)
        )
        return lambda: [int(file.stem) for file in tmp_path.glob("*.pid")]

    return put


STAND_IN = """
import os, time
from linkwright.stages.mesh.collide import collision
def answer(request):
    open(f"{}/{{os.getpid()}}.pid", "w").close()
"""
REFUSES = "return collision.encode(collision.Collision(note='no'))"


def test_guests_make_the_same_whatever_they_made_before():
    surfaces = [BRACKET, CLAMP, RING, BRACKET]
    makings = [Making(str(number), made(surface)) for number, surface in enumerate(surfaces)]
    forwards = side_by_side(makings, workers=1)
    backwards = side_by_side(makings[::-1], workers=2)
    assert forwards == backwards[::-1] == [alone(task(surface)) for surface in surfaces]


def test_there_are_no_more_guests_than_workers_and_none_is_left(stand_in):
    guests = stand_in(REFUSES)
    results = side_by_side([Making("", made(CLAMP))] * 9, workers=2)
    assert len(set(results)) == 1
    assert 1 <= len(guests()) <= 2
    assert gone(guests())


def test_failure_is_the_result_of_its_own_maker_alone():
    def fails(guest):
        raise DecompositionFailed("no")

    first, second, third = side_by_side(
        [Making("a", lambda _: 1), Making("b", fails), Making("c", lambda _: 3)]
    )
    assert (first, third) == (1, 3)
    assert isinstance(second, DecompositionFailed)


def test_it_tells_what_runs_and_how_much_is_done():
    lines = []
    gate = threading.Event()

    def shown(running, done, total):
        lines.append((list(running), done, total))
        if running == ["slow"]:
            gate.set()

    side_by_side([Making("quick", lambda _: 0), Making("slow", lambda _: gate.wait(30))], shown, workers=2)
    assert (["slow"], 1, 2) in lines
    assert lines[-1] == ([], 2, 2)


def test_another_error_ends_the_guests_of_all(stand_in):
    guests = stand_in("time.sleep(1000)")

    def breaks(guest):
        until = time.monotonic() + 30
        while not guests() and time.monotonic() < until:
            time.sleep(0.01)
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        side_by_side([Making("sleeps", made(CLAMP)), Making("breaks", breaks)], workers=2)
    assert gone(guests())


ENDED = """
import sys, time
from functools import partial
from linkwright.stages.mesh.collide import side_by_side as pool
from linkwright.stages.mesh.collide.improvement import helper, improved
from tests.support.decomposing import task
from tests.unit.mesh.test_decompose import CLAMP
sys.path.append(sys.argv[1])
pool.helper = partial(helper, module="stand_in")
def idles(guest):
    improved(task(CLAMP, effort="low"), guest)
    time.sleep(2)
def sleeps(guest):
    improved(task(CLAMP), guest)
makings = [pool.Making(make.__name__, make) for make in (idles, sleeps, sleeps)]
try:
    pool.side_by_side(makings, workers=2)
except KeyboardInterrupt:
    print("interrupted", flush=True)
"""


@pytest.mark.skipif(os.name == "nt", reason="other signals")
@pytest.mark.parametrize(("number", "lines"), [("SIGINT", "interrupted\n"), ("SIGKILL", "")])
def test_however_we_end_all_guests_end(number, lines, tmp_path, stand_in):
    guests = stand_in(f"if b'low' in request: {REFUSES}", "time.sleep(1000)")
    command = [sys.executable, "-c", ENDED, str(tmp_path)]
    with subprocess.Popen(command, cwd=PROJECT, stdout=subprocess.PIPE, text=True) as run:
        until = time.monotonic() + 60
        while len(guests()) < 2 and time.monotonic() < until:
            time.sleep(0.02)
        run.send_signal(getattr(signal, number))
        said, _ = run.communicate(timeout=60)
    assert said == lines
    assert gone(guests())
    assert len(guests()) == 2
