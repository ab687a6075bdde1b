"""The lines that are shown while a build runs."""

import io
import re

import pytest

from linkwright.pipeline.mesh_details import time_left
from linkwright.pipeline.report import StageReport
from linkwright.pipeline.terminal.display import progress_for
from linkwright.pipeline.terminal.progress import Lines, Log, Tee
from linkwright.pipeline.terminal.spinner import Terminal
from tests.support.terminal import Screen

DONE = StageReport("graph", True, 0.123, "2 links")


def test_a_pipe_gets_one_plain_line_a_stage_and_a_terminal_the_same_sentence():
    stream, screen = io.StringIO(), Screen()
    assert isinstance(progress_for(screen), Terminal)
    for progress in (progress_for(stream), progress_for(screen)):
        progress.start("graph")
        progress.done(DONE)
        progress.close()
    assert stream.getvalue() == "graph    ... 0.12 s (cached)  2 links\n"
    assert "0.12 s (cached)  2 links" in screen.getvalue()
    progress_for(screen).detail("output", "waiting for another build of [arm]")
    assert "output: waiting for another build of [arm]" in screen.getvalue(), "before the first stage"


@pytest.mark.parametrize(("environ", "line", "shown"), [
    ({"ONSHAPE_ACCESS_KEY": "acc355-key"}, "asked as acc355-key", "asked as ***"),
    ({}, "of-the-file and s3cr3t-key", "*** and ***"),
    ({"ONSHAPE_ACCESS_KEY": "", "ONSHAPE_SECRET_KEY": ""}, "text", "text"),
])  # fmt: skip
def test_the_log_holds_what_the_terminal_showed_without_keys(tmp_path, monkeypatch, environ, line, shown):
    (tmp_path / ".env").write_text("ONSHAPE_ACCESS_KEY=of-the-file\nONSHAPE_SECRET_KEY=s3cr3t-key\n")
    monkeypatch.chdir(tmp_path)
    log = Log(environ)
    both = Tee(log, Lines(io.StringIO()))
    both.start("fetch")
    both.detail("fetch", line)
    both.done(DONE)
    both.close()
    lines = log.content().decode().splitlines()
    assert [line.split("  ")[-1] for line in lines] == [f"fetch: {shown}", "2 links"]
    assert float(lines[0].split()[0]) >= 0


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


@pytest.mark.parametrize(("seconds", "done", "total", "words"), [
    (10.0, 0, 9, ""),
    (10.0, 1, 5, ", about 40 s left"),
    (2.0, 9, 10, ", about 5 s left"),
    (60.0, 1, 9, ", about 8 min left"),
    (10.0, 9, 9, ""),
])  # fmt: skip
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
