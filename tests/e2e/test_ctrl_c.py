"""Ctrl-C at any moment of a command: it ends with 130, or the build was finished and says so."""

import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.support.command import environment

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="needs POSIX signals")

BEGIN = """
import os, sys
from linkwright.__main__ import main
class Begin:
    def find_spec(self, name, path=None, target=None):
        if name == "linkwright.pipeline":
            os.write({0}, b"x")
sys.meta_path.insert(0, Begin())
sys.exit(main())
"""
"""The command, which says when it has begun: before, there is only Python, which ends in its own way."""

LINE = ("source=sample", "mesh=hull")


class Tries:
    """Runs a command in a folder, and ends it at a moment."""

    def __init__(self, here):
        self.here = here
        here.mkdir()

    def run(self, line, moment, *, all_of_them):
        """Status, output and errors of a command that gets SIGINT `moment` [s] after it began: it alone, or
        with its children, as from a terminal."""
        reader, writer = os.pipe()
        process = subprocess.Popen(
            [sys.executable, "-c", BEGIN.format(writer), *line],
            cwd=self.here,
            env=environment(self.here, seeded=False),
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
            pass_fds=[writer],
        )
        os.close(writer)
        assert os.read(reader, 1) == b"x"
        os.close(reader)
        if moment is not None:
            time.sleep(moment)
            # It is no child that was waited for: the number is still its own.
            (os.killpg if all_of_them else os.kill)(process.pid, signal.SIGINT)
        out, err = process.communicate(timeout=120)
        return process.returncode, out, err


def seconds(tries, line):
    began = time.monotonic()
    assert tries.run(line, None, all_of_them=False)[0] == 0
    return time.monotonic() - began


@pytest.mark.slow
@pytest.mark.parametrize(
    ("line", "cold", "count"),
    [
        (LINE, False, 60),
        ((*LINE, "until=export"), True, 25),
        (("-m", *LINE, "until=graph", "root=auto,free"), False, 25),
    ],
    ids=["cached", "cold", "sweep"],
)
def test_interrupt_at_a_random_moment_ends_or_finishes_the_build(tmp_path, line, cold, count):
    seed = random.Random(str(line))
    longest = seconds(Tries(tmp_path / "first"), line)
    if not cold:
        warm = Tries(tmp_path / "warm")
        seconds(warm, line)
        longest = min(seconds(warm, line) for _ in range(3))
    ends = {130: 0, 0: 0}
    for number in range(count):
        tries = Tries(tmp_path / str(number)) if cold else warm
        moment = seed.uniform(0.0, 1.05 * longest)
        status, out, err = tries.run(line, moment, all_of_them=bool(number % 2))
        shown = f"after {moment:.3f} s of {longest:.3f} s: {status}\n{out}\n{err}"
        assert status in ends, shown
        ends[status] += 1
        assert "bug in linkwright" not in err, shown
        if status == 130:
            assert err.splitlines()[-1] == "error: interrupted", shown
        else:
            assert "outputs/sample" in out, shown
        assert [*tries.here.rglob("*.failed")] == [], shown
        for folder in filter(Path.is_dir, tries.here.glob("outputs/sample*")):
            assert (folder / "report.json").is_file() or (folder / "summary.json").is_file(), shown
    # A machine that gets faster after the builds were timed finishes more of them in time.
    assert ends[130] >= sum(ends.values()) // 4
    if not cold:
        assert warm.run(line, None, all_of_them=False)[0] == 0
