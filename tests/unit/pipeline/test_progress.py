"""What is told while a build runs."""

import io
import re

import pytest

from linkwright.pipeline.mesh_details import time_left
from linkwright.pipeline.report import StageReport
from linkwright.pipeline.terminal.progress import Lines, Log, Tee, Terminal, progress_for

DONE = StageReport("graph", True, 0.123, "2 links")


class Screen(io.StringIO):
    def isatty(self):
        return True


def test_a_pipe_gets_one_plain_line_a_stage():
    stream = io.StringIO()
    progress = progress_for(stream)
    progress.start("graph")
    progress.done(DONE)
    progress.close()
    assert stream.getvalue() == "graph    ... 0.12 s (cached)  2 links\n"


def test_a_terminal_gets_the_same_sentence():
    screen = Screen()
    progress = progress_for(screen)
    assert isinstance(progress, Terminal)
    progress.start("graph")
    progress.detail("graph", "[3 of 4] parts")
    progress.done(DONE)
    progress.close()
    assert "0.12 s (cached)  2 links" in screen.getvalue()


def test_the_log_holds_what_the_terminal_showed_without_secrets():
    stream, log = io.StringIO(), Log({"ONSHAPE_ACCESS_KEY": "acc355-key"})
    both = Tee(log, Lines(stream))
    both.start("fetch")
    both.detail("fetch", "asked as acc355-key")
    both.done(DONE)
    both.close()
    lines = log.content().decode().splitlines()
    assert [line.split("  ")[-1] for line in lines] == ["fetch: asked as ***", "2 links"]
    assert float(lines[0].split()[0]) >= 0


def test_a_key_from_the_env_file_is_blanked_too(tmp_path, monkeypatch):
    (tmp_path / ".env").write_text("ONSHAPE_ACCESS_KEY=acc355-key\nONSHAPE_SECRET_KEY=s3cr3t-key\n")
    monkeypatch.chdir(tmp_path)
    log = Log({})
    log.line("acc355-key and s3cr3t-key")
    assert log.content().endswith(b"*** and ***\n")


def test_a_terminal_is_reported_what_comes_before_the_first_stage():
    screen = Screen()
    progress_for(screen).detail("output", "waiting for another build of [arm]")
    assert "output: waiting for another build of [arm]" in screen.getvalue()


def test_the_line_of_a_running_stage_is_one_however_long(monkeypatch):
    monkeypatch.setenv("COLUMNS", "60")
    screen = Screen()
    progress = progress_for(screen)
    progress.start("mesh")
    progress.transient("mesh", "colliders: 1 of 9 parts: " + "Column sleeve <1>, " * 9)
    progress.close()
    rows = re.split(r"[\r\n]|\x1b\[2K|\x1b\[1A", screen.getvalue())
    assert max(len(re.sub(r"\x1b\[[0-9;?]*[a-zA-Z]", "", row)) for row in rows) <= 60
    assert "mesh (colliders: 1 of 9 parts: Column" in screen.getvalue()


@pytest.mark.parametrize(
    ("seconds", "done", "total", "words"),
    [
        (10.0, 0, 9, ""),
        (10.0, 1, 5, ", about 40 s left"),
        (2.0, 9, 10, ", about 5 s left"),
        (60.0, 1, 9, ", about 8 min left"),
        (10.0, 9, 9, ""),
    ],
)
def test_the_time_that_is_left_is_that_of_what_was_done(seconds, done, total, words):
    assert time_left(seconds, done, total) == words


def test_what_arrives_is_seen_on_a_terminal_and_kept_nowhere():
    stream, screen, log = io.StringIO(), Screen(), Log({})
    both = Tee(log, Lines(stream), progress_for(screen))
    both.start("fetch")
    both.detail("fetch", "4 part studios: 8 calls, 0 kept")
    both.transient("fetch", "12.5 MB received [of many]")
    both.done(DONE)
    both.close()
    assert "fetch: 4 part studios: 8 calls, 0 kept (12.5 MB received [of many])" in screen.getvalue()
    assert "received" not in stream.getvalue()
    assert b"received" not in log.content()


def test_an_empty_environment_blanks_nothing():
    log = Log({"ONSHAPE_ACCESS_KEY": ""})
    log.line("text")
    assert log.content().endswith(b"  text\n")
