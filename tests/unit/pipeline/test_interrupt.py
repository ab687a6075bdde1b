"""Ctrl-C ends a command with exit status 130, also where Python or a library loses it."""

import os
import signal
import subprocess
import sys
import threading

import pytest

from linkwright.pipeline import interrupt
from linkwright.pipeline.caching.actions import Action, opened
from linkwright.pipeline.cli import run as run_command
from linkwright.pipeline.config.plan import Plan
from linkwright.pipeline.run.build import build
from tests.support import stand_in_builds
from tests.support.places import PROJECT
from tests.unit.pipeline.test_build import Fake, fakes

pytestmark = [
    pytest.mark.skipif(sys.platform == "win32", reason="needs POSIX signals"),
    pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning"),
]

HEAD = """\
import os, signal, sys
from linkwright.pipeline import interrupt

def press():
    os.kill(os.getpid(), signal.SIGINT)

class Loses:
    def __del__(self):
        press()

class Converts:
    def __set_name__(self, owner, name):
        press()

def converted():
    class Owner:
        one = Converts()

"""


def ended(code, **more):
    """What a process says that runs this code after `HEAD`."""
    line = [sys.executable, "-c", HEAD + code]
    return subprocess.run(line, cwd=PROJECT, capture_output=True, text=True, timeout=60, check=False, **more)


@pytest.mark.parametrize(("work", "status", "lines"), [
    ("press()", 130, ["error: interrupted"]),
    ("Loses(); interrupt.check()", 130, ["error: interrupted"]),
    ("Loses(); sys.exit", 0, []),
    ("Loses(); return 3", 3, []),
    ("Loses(); return 1", 130, []),
    ("Loses(); return 2", 130, []),
    ("return 3", 3, []),
])  # fmt: skip
def test_a_command_ends_with_130_or_as_it_finished(work, status, lines):
    done = ended(f"def run():\n    {work}\n    return 0\nsys.exit(interrupt.command(run))\n")
    said = [line for line in done.stderr.splitlines() if line.startswith("error:")]
    assert (done.returncode, said) == (status, lines)


def test_after_its_end_a_command_has_its_own_status():
    done = ended("status = interrupt.command(lambda: 3)\npress()\nLoses()\nsys.exit(status)\n")
    assert (done.returncode, done.stderr) == (3, "")
    done = ended("status = interrupt.command(press)\npress()\nsys.exit(status)\n")
    assert (done.returncode, done.stderr) == (130, "error: interrupted\n")
    # A command that ignores Ctrl-C from the start still does.
    code = "def run():\n    press()\n    interrupt.check()\n    return 0\nsys.exit(interrupt.command(run))\n"
    done = ended(code, preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_IGN))
    assert (done.returncode, done.stderr) == (0, "")


def test_a_ring_of_errors_has_an_end():
    first, second = ValueError("a"), ValueError("b")
    first.__context__, second.__context__ = second, first
    assert not interrupt.is_cause_of(first)
    second.__cause__ = KeyboardInterrupt()
    assert interrupt.is_cause_of(first)


TOLD = """from linkwright.pipeline.terminal import error_border
    error_border.print_error = lambda error, whole: press()
    press()"""


@pytest.mark.parametrize("build", ["converted()", TOLD])
def test_a_converted_and_a_second_signal_are_the_interrupt(build):
    """As `cached_property` converts it in Python 3.11, for one of the first imports; and while it is told."""
    code = f"from linkwright.pipeline import cli\n\ndef build(plan):\n    {build}\n"
    done = ended(f"{code}\nsys.exit(interrupt.command(lambda: cli.run(['source=sample'], build)))\n")
    assert (done.returncode, done.stderr.splitlines()[-1]) == (130, "error: interrupted")
    assert "bug in linkwright" not in done.stderr


@pytest.mark.slow
def test_it_waits_until_the_import_of_a_compiled_module_ends():
    code = """
def heard(event, arguments):
    if event == "import" and arguments[0] == "orjson.orjson" and arguments[1] is not None:
        press()

def run():
    import time
    import orjson
    print("imported\\n", end="", flush=True)  # in one piece, which Ctrl-C does not cut
    time.sleep(30)

sys.addaudithook(heard)
sys.exit(interrupt.command(run))
"""
    done = ended(code)
    assert (done.returncode, done.stdout, done.stderr) == (130, "imported\n", "error: interrupted\n")


@pytest.fixture
def watched(monkeypatch):
    """Signals are noted as in a command, of which nothing is left after the test."""
    monkeypatch.setattr(interrupt, "_CAME", threading.Event())
    before = signal.signal(signal.SIGINT, interrupt._handle_signal)
    yield
    signal.signal(signal.SIGINT, before)


class Loses:
    """An object of which the end is where Ctrl-C comes: Python prints that exception, and goes on."""

    def __del__(self):
        os.kill(os.getpid(), signal.SIGINT)


class Losing(Fake):
    """A stage in which Ctrl-C comes and is lost."""

    def run(self, context):
        Loses()
        return super().run(context)


class Converting(Fake):
    """A stage in which a library makes another error of it."""

    def run(self, context):
        try:
            os.kill(os.getpid(), signal.SIGINT)
        except KeyboardInterrupt as error:
            raise RuntimeError("cannot set a name") from error
        return {}


def plan(folder):
    data = {"name": "arm", "source": {"kind": "sample"}, "output": str(folder / "out" / "arm")}
    return Plan.parse(data | {"cache": {"dir": str(folder / "cache")}})


@pytest.mark.parametrize("kind", [Losing, Converting])
@pytest.mark.parametrize("name", ["fetch", "graph", "validate"])
def test_build_ends_where_the_signal_was_lost(tmp_path, watched, kind, name):
    build(plan(tmp_path), environ={}, stages=fakes())
    left = sorted((tmp_path / "out").rglob("*"))
    stages = [kind(s.name, s.files, version=2) if s.name == name else s for s in fakes()]
    with pytest.raises(KeyboardInterrupt):
        build(plan(tmp_path), environ={}, stages=tuple(stages))
    assert sorted((tmp_path / "out").rglob("*")) == left
    interrupt._CAME.clear()
    again = fakes(**{name: {"version": 2}})
    assert build(plan(tmp_path), environ={}, stages=again).exit_status == 0
    (made,) = [stage for stage in again if stage.name == name]
    assert made.runs == 1, "what was cut short was not kept"


def test_error_caused_by_a_signal_is_an_interrupt(tmp_path, monkeypatch):
    monkeypatch.setattr(interrupt, "_CAME", threading.Event())
    with pytest.raises(KeyboardInterrupt):
        build(plan(tmp_path), environ={}, stages=(Converting("fetch"), *fakes()[1:]))
    assert not (tmp_path / "out" / "arm.failed").exists()


def test_a_long_step_that_says_what_it_does_ends(tmp_path, watched):
    class Long(Fake):
        def run(self, context):
            Loses()
            for _ in range(1000):
                context.transient("at work")
            raise AssertionError

    with pytest.raises(KeyboardInterrupt):
        build(plan(tmp_path), environ={}, stages=(Long("fetch"), *fakes()[1:]))


def test_a_result_that_it_may_have_cut_short_is_not_kept(tmp_path, watched):
    with opened("use", str(tmp_path / "cache")) as cache:
        action = Action("mesh", 1, config={})

        def make():
            Loses()
            return {"value": b"half"}

        with pytest.raises(KeyboardInterrupt):
            cache.run(action, make)
        interrupt._CAME.clear()
        assert cache.run(action, lambda: {"value": b"whole"})[0]["value"] == b"whole"


@pytest.mark.parametrize("lost", [True, False])
def test_a_sweep_ends_with_the_job_in_which_it_was_lost(tmp_path, monkeypatch, capsys, watched, lost):
    monkeypatch.chdir(tmp_path)
    started = []

    def lost_build(job):
        started.append(job)
        if not lost:
            Converting("fetch").run(None)
        Loses()
        return stand_in_builds.ended(job)

    assert run_command(["-m", "source=sample", "root=auto,free,fixed"], lost_build) == 130
    assert len(started) == 1
    assert "error: interrupted" in capsys.readouterr().err
