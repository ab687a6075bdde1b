"""All that is printed, by whomever: no control character or key gets through, and a reader may leave."""

import io
import json
import logging
import os
import re
import subprocess
import sys
import traceback
from dataclasses import replace
from pathlib import Path

import pytest
import yaml

from linkwright.pipeline.cli import run
from linkwright.pipeline.config.files.file_text import as_yaml
from linkwright.pipeline.mesh_details import time_left
from linkwright.pipeline.page.document import page
from linkwright.pipeline.report import Report, StageReport
from linkwright.pipeline.secrets import Secrets
from linkwright.pipeline.sweep.run import Job, Task
from linkwright.pipeline.terminal.closing import print_closing_text
from linkwright.pipeline.terminal.display import progress_for
from linkwright.pipeline.terminal.output import clean_standard_streams, clean_stream
from linkwright.pipeline.terminal.progress import Lines, Log, Tee
from linkwright.pipeline.terminal.spinner import Terminal
from linkwright.stages.robot.check import Check
from linkwright.stages.robot.errors import AssemblyError, Diagnostic
from tests.support.building import plan_of
from tests.support.places import PROJECT
from tests.support.terminal import Screen

NASTY = "\x1b[2J\x1b]0;title\x07\r\nerror: forged \x9b31m\u202e\u2066\u2028\u200bé 中"
SHOWN = r"\u001b[2J\u001b]0;title\u0007\u000d"
KEY = "acc355-key"
BAD = [*map(chr, range(0x20)), *map(chr, range(0x7F, 0xA0)), *"\u202e\u2066\u2028\u200b"]
BAD = [letter for letter in BAD if letter not in "\n\x1b\r"]  # the three that rich itself draws with

REPORT = Report(
    "invalid", "arm", f"outputs/{NASTY}", "graph", 3,
    stages=(StageReport("fetch", False, 0.1, NASTY),),
    diagnostics=(Diagnostic("W-LIMIT", NASTY, NASTY, NASTY),),
    checks=(Check(NASTY, False, NASTY, 1.0, 2.0),),
    outline=(NASTY.replace("\n", ""),),
    error={"type": NASTY, "message": NASTY, "where": NASTY, "hint": NASTY, "problems": []},
)  # fmt: skip


@pytest.fixture(autouse=True)
def _with_a_key_in_an_empty_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("ONSHAPE_ACCESS_KEY", KEY)


def harm(text, drawn=""):
    """What must not be in a text that is printed: control characters but those `drawn` by rich, and a key."""
    letters = [letter for letter in (*BAD, "\x1b", "\r") if letter in text and letter not in drawn]
    return letters + [KEY] * (KEY in text)


def test_print_logging_and_tracebacks_are_clean(capsys):
    with clean_standard_streams(), clean_standard_streams():
        print(f"{NASTY} {KEY}")
        handler = logging.StreamHandler()
        handler.emit(logging.LogRecord("x", 30, "x", 1, f"{NASTY} {KEY}", None, None))
        try:
            raise ValueError(f"{NASTY} {KEY}")
        except ValueError:
            traceback.print_exc()
    out, err = capsys.readouterr()
    for text in (out, err):
        assert SHOWN in text
        assert harm(text) == []
    assert out.count("***") == 1


def test_outside_of_the_command_the_streams_are_as_they_were(capsys):
    before = sys.stdout
    with clean_standard_streams():
        assert sys.stdout is not before
    assert sys.stdout is before
    print("\x1b[0m")
    assert capsys.readouterr().out == "\x1b[0m\n"
    screen = Screen()
    assert clean_stream(clean_stream(screen)).raw is screen
    assert clean_stream(screen).isatty()
    assert clean_stream(screen).write("\x07") == 1


def test_the_command_a_job_and_an_error_are_clean(capsys):
    assert run(["robot=\x1b[2Jnobody\x9b", f"ground={KEY}"]) == 2
    err = capsys.readouterr().err
    assert harm(err) == []
    assert "nobody" in err

    def fail(_):
        raise AssemblyError(f"{NASTY} {KEY}")

    Task([Job(0, NASTY, plan_of(output="arm"))], fail)(0)
    err = capsys.readouterr().err
    assert len(err.splitlines()) == 2
    assert harm(err) == []
    error = AssemblyError(NASTY, NASTY, "mend it", [Diagnostic("E-MASS", NASTY, NASTY, "and this")])
    assert len(str(error).splitlines()) == 4, "as many lines as it has parts"


@pytest.mark.parametrize("make", [Lines, Terminal])
def test_progress_cannot_be_forged(make):
    screen = Screen()
    progress = make(screen)
    progress.detail("fetch", f"{NASTY} {KEY}")
    progress.start("graph")
    progress.detail("graph", NASTY)
    progress.done(StageReport("graph", False, 0.1, NASTY))
    progress.close()
    text = screen.getvalue()
    assert SHOWN in text
    assert harm(text, drawn="\x1b\r") == []
    assert [words for words in ("\x1b]0", "\x1b[2J", "\nerror: forged") if words in text] == []


@pytest.mark.parametrize("stream", [io.StringIO, Screen])
def test_the_closing_table_cannot_be_forged(stream):
    screen = stream()
    print_closing_text(REPORT, screen)
    text = screen.getvalue()
    assert SHOWN in text
    assert harm(text, drawn="\x1b\r") == []
    assert [words for words in ("\x1b]0", "\x1b[2J") if words in text] == []
    assert "W-LIMIT" in text
    # The hint alone may have several lines: it is YAML to paste.
    assert text.count("\nerror: forged") == 1


def test_files_of_a_build_have_no_control_character():
    log = Log({})
    log.detail("fetch", NASTY)
    log.line(NASTY)
    data = [log.content(), REPORT.to_json(), page(REPORT, {}, {}, Secrets({})), as_yaml({"name": NASTY})]
    assert [harm(part.decode()) for part in data] == [[]] * 4
    assert len(log.content().splitlines()) == 2
    assert json.loads(REPORT.to_json())["folder"] == REPORT.folder
    assert yaml.safe_load(as_yaml({"name": NASTY})) == {"name": NASTY}
    assert as_yaml({"name": "é 中"}) == "name: é 中\n".encode()
    assert "Größe 👩‍🔧".encode() in replace(REPORT, name="Größe 👩‍🔧").to_json(), "what is clean stays"


DONE = StageReport("graph", True, 0.123, "2 links")


def test_pipe_and_terminal_get_the_same_sentence():
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


def piped(folder, *arguments, read=1, both=False):
    """The exit status of a command whose reader leaves after so many lines, and what it said besides."""
    command = subprocess.Popen(
        [sys.executable, "-m", "linkwright", *arguments],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(PROJECT), "LINKWRIGHT_CACHE": str(folder / "cache")},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT if both else subprocess.PIPE,
        text=True,
    )
    for _ in range(read):
        assert command.stdout.readline()
    command.stdout.close()
    output_text = "" if both else command.stderr.read()
    return command.wait(timeout=120), output_text


@pytest.mark.parametrize(("read", "arguments"), [(1, ["--help"]), (0, ["--version"]), (1, ["cache", "info"])])
def test_a_reader_that_leaves_is_no_error_and_changes_no_status(tmp_path, arguments, read):
    assert piped(tmp_path, *arguments, read=read) == (0, "")
    assert read or piped(tmp_path, "--nonsense", read=0, both=True)[0] == 2


@pytest.mark.e2e
def test_a_build_whose_progress_nobody_reads_any_more_goes_on(tmp_path):
    assert piped(tmp_path, "until=fetch", both=True)[0] == 0
    assert (tmp_path / "outputs" / "sample.fetch" / "report.json").is_file()


@pytest.mark.slow
@pytest.mark.parametrize("launcher", ["basic", "workstation"])
def test_a_sweep_whose_reader_left_goes_on(tmp_path, launcher):
    arguments = ["-m", "root=auto,free", "until=fetch", f"hydra/launcher={launcher}"]
    status, _ = piped(tmp_path, *arguments, both=True)
    assert status == 0
    assert len(list(tmp_path.glob("outputs/sample.sweep/*/report.json"))) == 2


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is always full")
def test_output_that_cannot_be_written_is_one_message(tmp_path):
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "linkwright", "--version"],
            cwd=tmp_path, env={**os.environ, "PYTHONPATH": str(PROJECT)}, stdout=full,
            stderr=subprocess.PIPE, text=True, check=False,
        )  # fmt: skip
    assert done.returncode == 1
    assert done.stderr == "error: the standard output cannot be written: No space left on device\n"
