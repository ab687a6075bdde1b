"""Whoever reads what the command tells may leave: that is silent, and the work is done all the same."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.places import PROJECT


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
def test_an_output_that_cannot_be_written_is_one_message_and_a_failure(tmp_path):
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "linkwright", "--version"],
            cwd=tmp_path, env={**os.environ, "PYTHONPATH": str(PROJECT)}, stdout=full,
            stderr=subprocess.PIPE, text=True, check=False,
        )  # fmt: skip
    assert done.returncode == 1
    assert done.stderr == "error: the standard output cannot be written: No space left on device\n"
