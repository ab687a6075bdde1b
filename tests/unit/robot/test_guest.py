"""What runs in a guest cannot harm us: bounds, a clean environment, and nothing left behind."""

import contextlib
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from linkwright.stages.robot.errors import ConfigError, SourceError
from linkwright.stages.robot.system import guest, process_usage
from linkwright.stages.robot.system.guest import Bounds, Ended
from tests.support import processes
from tests.support.places import PROJECT, link_package

ENOUGH = Bounds(seconds=60, memory=1 << 30, reply=1000)
ENDLESS = """
import os, subprocess, sys
inner = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(1000)"])
open(request.decode(), "w").write(f"{os.getpid()} {inner.pid}")
while True: pass
"""


def limited(seconds=60, memory=1 << 30, reply=10, **more):
    return Bounds(seconds, memory, reply, **more)


@pytest.fixture
def run_guest(tmp_path, monkeypatch):
    """Has a guest run the lines of a function that gets `request` and returns the answer."""
    monkeypatch.syspath_prepend(tmp_path)

    def ask(lines, request=b"", bounds=ENOUGH, **environ):
        body = "\n".join(f"    {line}" for line in lines.splitlines())
        (tmp_path / "visitor.py").write_text(f"def answer(request):\n{body}\n")
        return guest.ask("visitor", request, bounds, environ)

    return ask


def gone(place):
    """Whether the processes whose numbers are in a file have ended, in time."""
    return processes.gone(map(int, place.read_text().split()))


def test_guest_answers_whatever_it_prints(run_guest):
    assert run_guest("print('noise', flush=True)\nreturn request[::-1]", b"abc\n\0") == b"\0\ncba"


def test_guest_sees_variables_but_no_terminal_or_local_module(run_guest, tmp_path, monkeypatch):
    (tmp_path / "work").mkdir()
    for name in ("colorsys.py", "usercustomize.py"):
        (tmp_path / "work" / name).write_text("raise SystemExit(9)")
    monkeypatch.chdir(tmp_path / "work")
    for name, value in (("ONSHAPE_SECRET_KEY", "very-secret"), ("LD_LIBRARY_PATH", "/nowhere")):
        monkeypatch.setenv(name, value)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path / "work"))
    output = run_guest(
        "import colorsys, json, os, sys\n"
        "alone = os.getpid() == os.getsid(0) == os.getpgid(0)\n"
        "return json.dumps([sorted(os.environ), alone, sys.stdin.read(), sys.flags.isolated]).encode()",
        ROS_PACKAGE_PATH="/opt/ros",
    )
    assert output == b'[["ROS_PACKAGE_PATH"], true, "", 1]'


@pytest.mark.parametrize("kind", [SourceError, ConfigError])
def test_errors_of_a_guest_come_back_as_ours(run_guest, kind):
    lines = f"from linkwright.stages.robot.errors import {kind.__name__} as E\nraise E('no', 'there', 'do')"
    with pytest.raises(kind) as caught:
        run_guest(lines)
    assert (caught.value.message, caught.value.where, caught.value.hint) == ("no", "there", "do")


@pytest.mark.parametrize(("lines", "said"), [
    ("import os\nos.abort()", "crashed (SIGABRT)"),
    ("import ctypes\nctypes.string_at(0)", "crashed (SIGSEGV)"),
    ("import os\nos._exit(3)", "ended with status 3"),
    ("return None + 1", "failed (TypeError: unsupported operand"),
    ("import sys\nsys.exit('enough')", "failed (enough)"),
    ("import os\nos.close(3)\nos._exit(0)", "ended with status 0"),
    ("return bytes(1001)", "made more than 0.001 MB"),
    ("import os\nwhile True: os.write(3, bytes(1 << 16))", "made more than 0.001 MB"),
    ("import os\nos.write(3, b'R' + bytes(8) + b'more')\nos._exit(0)", "ended with status 0"),
    ("import os\nos.write(3, b'E' + bytes(7) + b'\\x02{}')\nos._exit(0)", "reported an invalid error"),
])  # fmt: skip
def test_end_of_a_guest_is_reported_in_words(run_guest, lines, said):
    with pytest.raises(Ended) as caught:
        run_guest(lines)
    assert said in str(caught.value)


def test_guest_without_a_profiling_timer_ends_with_its_status(run_guest, monkeypatch):
    monkeypatch.delattr("signal.SIGPROF", raising=False)
    with pytest.raises(Ended, match="ended with status 0"):
        run_guest("import os\nos._exit(0)")


def test_slow_guest_ends_with_all_that_it_started(run_guest, tmp_path):
    place = tmp_path / "pids"
    with pytest.raises(Ended, match="took longer than 1 s"):
        run_guest(ENDLESS, str(place).encode(), limited(1, wall_time_factor=1000))
    assert gone(place)


def test_guest_that_only_computes_has_its_processor_time(run_guest):
    """What else the machine does is not counted, within `wall_time_factor` times as much by the clock."""
    waits = "import time\ntime.sleep(1.5)\nreturn b'done'"
    assert run_guest(waits, bounds=limited(1, wall_time_factor=20)) == b"done"
    with pytest.raises(Ended, match="took longer than 1 s"):
        run_guest("while True: pass", bounds=limited(1, wall_time_factor=1000))
    with pytest.raises(Ended, match=r"took longer than 0\.2 s"):
        run_guest("import time\ntime.sleep(1000)", bounds=limited(0.2, wall_time_factor=4))


def test_guest_that_needs_too_much_memory_ends(run_guest):
    lines = "import time\nheld = b'x' * (400 << 20)\ntime.sleep(1000)"
    with pytest.raises(Ended, match=r"needed more than 0\.22 GB of memory"):
        run_guest(lines, bounds=limited(memory=210 << 20))


COUNTED = """
import os, threading, time
before = globals().setdefault("before", [])
before.append(request)
word = request.decode()
if len(before) > 1 and word == "crash": os.abort()
if len(before) > 1 and word == "hunger": held = b"x" * (400 << 20); time.sleep(1000)
if len(before) > 1 and word == "garbage": os.write(3, b"garbage" * 3)
if word == "grow": globals()["kept"] = b"x" * (100 << 20)
if word == "die later": threading.Timer(0.2, os.abort).start()
if word == "talk later": threading.Timer(0.2, os.write, (3, b"R" + bytes(8))).start()
return f"{os.getpid()} {len(before)}".encode()
"""
"""Tells its process, and how often that was asked. Fails by what is asked, if asked before."""


@pytest.fixture
def counted(run_guest):
    run_guest(COUNTED)
    bounds = Bounds(seconds=60, memory=300 << 20, reply=1000)
    with contextlib.closing(guest.Guest("visitor", bounds, {})) as used:
        yield lambda word: tuple(map(int, used.ask(word.encode()).split()))


@pytest.mark.parametrize("word", ["crash", "hunger", "garbage"])
def test_guest_stays_but_what_fails_in_it_is_asked_of_a_new_one(counted, word):
    """So that its result does not depend on what was asked before."""
    first, _ = counted("")
    assert counted("") == (first, 2)
    second, times = counted(word)
    assert times == 1
    assert second != first
    assert processes.gone([first])
    assert counted("") == (second, 2)


@pytest.mark.parametrize("word", ["grow", "die later", "talk later"])
def test_guest_that_grew_died_or_talked_is_asked_no_more(counted, word):
    first, _ = counted(word)
    time.sleep(0.5)
    assert counted("")[1] == 1
    assert processes.gone([first])


@pytest.mark.slow
def test_time_is_that_of_each_request(run_guest, monkeypatch):
    """The kernel's limit too."""
    monkeypatch.setattr(guest, "_PATIENCE", 0.2)
    run_guest("import time\ntime.sleep(0.7)\nreturn b'done'")
    for factor in (1.0, 1.001):
        bounds = Bounds(seconds=1.5, memory=1 << 30, reply=10, wall_time_factor=factor)
        with contextlib.closing(guest.Guest("visitor", bounds, {})) as used:
            assert [used.ask(b"") for _ in range(4)] == [b"done"] * 4


def test_interrupt_ends_it_with_all_that_it_started(run_guest, tmp_path, monkeypatch):
    place = tmp_path / "pids"

    def interrupted(process):
        if place.exists() and len(place.read_text().split()) == 2:
            raise KeyboardInterrupt
        return 0

    monkeypatch.setattr(process_usage, "resident_memory", interrupted)
    with pytest.raises(KeyboardInterrupt):
        run_guest(ENDLESS, str(place).encode())
    assert gone(place)


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere it ends when its time is up")
def test_guest_ends_with_its_host_however_that_ends(tmp_path):
    place = tmp_path / "pid"
    lines = f"import os\nopen({str(place)!r}, 'w').write(str(os.getpid()))\nwhile True: pass"
    (tmp_path / "visitor.py").write_text("def answer(request):\n    " + lines.replace("\n", "\n    "))
    code = f"import sys\nsys.path[:0] = [{str(tmp_path)!r}]\n"
    code += "from linkwright.stages.robot.system.guest import *\n"
    code += "ask('visitor', b'', Bounds(60, 1 << 30, 10), {})"
    with subprocess.Popen([sys.executable, "-c", code], cwd=PROJECT) as host:
        until = time.monotonic() + 30
        while not (place.exists() and place.read_text()) and time.monotonic() < until:
            time.sleep(0.01)
        host.send_signal(signal.SIGKILL)
    assert gone(place)


def test_guest_ends_with_the_end_of_its_requests():
    """So it ends with us on every system, once it has nothing to do."""
    head = {"module": "json", "path": sys.path, "seconds": 60, "parent": os.getpid(), "environ": []}
    head["package"] = str(PROJECT)
    line = json.dumps(head).encode() + b"\n"
    done = subprocess.run([sys.executable, "-I", guest._MAIN], input=line, capture_output=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (0, b"", b"")


def test_guest_finds_a_package_that_is_not_installed(tmp_path):
    """Neither by an installation nor by the working folder: as where PYTHONPATH names a copy."""
    (tmp_path / "visitor.py").write_text(
        "import linkwright.stages\ndef answer(request): return linkwright.stages.__file__.encode()"
    )
    code = (
        "from linkwright.stages.robot.system.guest import *\n"
        "print(ask('visitor', b'', Bounds(60, 1 << 30, 1000), {}).decode())"
    )
    link_package(tmp_path / "copy")
    environ = {"PYTHONPATH": os.pathsep.join([str(tmp_path / "copy"), str(tmp_path)])}
    (tmp_path / "stages").mkdir()
    how = {"env": environ, "cwd": tmp_path / "stages", "capture_output": True, "text": True, "check": False}
    done = subprocess.run([sys.executable, "-S", "-c", code], **how)
    assert Path(done.stdout.strip()).resolve() == PROJECT / "stages" / "__init__.py", done.stderr


def test_memory_is_known_without_proc_too(monkeypatch):
    resident = process_usage.resident_memory(os.getpid())
    monkeypatch.setattr(process_usage, "_STATM", "/nowhere/{}")
    assert process_usage.resident_memory(os.getpid()) == pytest.approx(resident, rel=0.2)
    assert process_usage.resident_memory(2**22 + 1) == 0
