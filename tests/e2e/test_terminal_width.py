"""What a terminal of 80 columns shows of a build, and what a pipe gets of the same."""

import fcntl
import os
import pty
import re
import struct
import termios

import pytest

from tests.support.command import COMMAND, environment, linkwright
from tests.support.terminal import ESCAPES

pytestmark = pytest.mark.slow

COLUMNS = 80


def shown(here, *arguments):
    """The lines that the command leaves in a terminal of 80 columns, and those that it replaces there."""
    environ = {name: value for name, value in environment(here).items() if name != "COLUMNS"}
    child, file = pty.fork()
    if child == 0:
        fcntl.ioctl(1, termios.TIOCSWINSZ, struct.pack("HHHH", 40, COLUMNS, 0, 0))
        os.chdir(here)
        os.execvpe(COMMAND, [str(COMMAND), *arguments], {**environ, "TERM": "xterm"})
    written = b""
    while True:
        try:
            piece = os.read(file, 65536)
        except OSError:
            break
        if not piece:
            break
        written += piece
    os.close(file)
    os.waitpid(child, 0)
    return re.split(r"[\r\n]+", ESCAPES.sub(b"", written).decode())


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("until=graph",), "└right_finger_jaw"),
        (("robot=sample", "mesh=visual", "joints.*.effort=0.1"), "WARNING C-TORQUE"),
        (("robot=sample", "joints.knee.damping=1", "until=graph"), "no joint matches 'knee'"),
        (("robot=sample", "mesh.tolerence=1"), "did you mean mesh.tolerance?"),
        (("-m", "robot=sample", "root=fixed,free", "until=graph"), "2 of 2 jobs built"),
        (("--help-all",), "environment:"),
    ],
    ids=lambda value: "" if isinstance(value, tuple) else value,
)
def test_no_line_is_wider_than_the_terminal(tmp_path, arguments, words):
    lines = shown(tmp_path, *arguments)
    assert [line for line in lines if len(line) > COLUMNS] == []
    assert any(words in line for line in lines), lines


def test_a_pipe_gets_each_name_whole(tmp_path):
    done = linkwright(tmp_path, "until=graph")
    rows = [
        line for line in done.stdout.splitlines() if "elbow_plate_pivot" in line and "elbow_plate " in line
    ]
    assert len(rows) == 1, done.stdout
