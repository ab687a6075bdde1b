"""All that is printed, by whomever: no control character gets through, and no key."""

import io
import json
import logging
import sys
import traceback
from dataclasses import replace

import pytest
import yaml

from linkwright.pipeline.cli import run
from linkwright.pipeline.config.files.file_text import as_yaml
from linkwright.pipeline.page.document import page
from linkwright.pipeline.report import Report, StageReport
from linkwright.pipeline.secrets import Secrets
from linkwright.pipeline.sweep.run import Job, Task
from linkwright.pipeline.terminal.closing import print_closing_text
from linkwright.pipeline.terminal.output import clean_standard_streams, clean_stream
from linkwright.pipeline.terminal.progress import Lines, Log
from linkwright.pipeline.terminal.spinner import Terminal
from linkwright.stages.robot.check import Check
from linkwright.stages.robot.errors import AssemblyError, Diagnostic
from tests.support.building import plan_of
from tests.support.terminal import Screen

NASTY = "\x1b[2J\x1b]0;title\x07\r\nerror: forged \x9b31m\u202e\u2066\u2028\u200bé 中"
SHOWN = r"\u001b[2J\u001b]0;title\u0007\u000d"
KEY = "acc355-key"
BAD = [*map(chr, range(0x20)), *map(chr, range(0x7F, 0xA0)), *"\u202e\u2066\u2028\u200b"]
BAD = [letter for letter in BAD if letter not in "\n\x1b\r"]  # the three that rich itself draws with

REPORT = Report(
    status="invalid",
    name="arm",
    folder=f"outputs/{NASTY}",
    until="graph",
    exit_status=3,
    stages=(StageReport("fetch", False, 0.1, NASTY),),
    diagnostics=(Diagnostic("W-LIMIT", NASTY, NASTY, NASTY),),
    checks=(Check(NASTY, False, NASTY, 1.0, 2.0),),
    outline=(NASTY.replace("\n", ""),),
    error={"type": NASTY, "message": NASTY, "where": NASTY, "hint": NASTY, "problems": []},
)


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


def test_the_command_cleans_its_output(capsys):
    assert run(["robot=\x1b[2Jnobody\x9b", f"ground={KEY}"]) == 2
    err = capsys.readouterr().err
    assert harm(err) == []
    assert "nobody" in err


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


def test_log_report_page_and_configuration_hold_no_control_character():
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


def test_an_error_is_as_many_lines_as_it_has_parts():
    error = AssemblyError(NASTY, NASTY, "mend it", [Diagnostic("E-MASS", NASTY, NASTY, "and this")])
    assert len(str(error).splitlines()) == 4


def test_a_job_of_a_sweep_is_clean_in_any_process(capsys):
    def fail(_):
        raise AssemblyError(f"{NASTY} {KEY}")

    Task([Job(0, NASTY, plan_of(output="arm"))], fail)(0)
    err = capsys.readouterr().err
    assert len(err.splitlines()) == 2
    assert harm(err) == []


def test_the_cleaned_stream_is_the_stream_otherwise():
    screen = Screen()
    assert clean_stream(clean_stream(screen)).raw is screen
    assert clean_stream(screen).isatty()
    assert clean_stream(screen).write("\x07") == 1
