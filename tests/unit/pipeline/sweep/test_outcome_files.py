"""The outcomes of a sweep's jobs, from its folder alone."""

import json
import shutil
import threading
from contextlib import chdir
from dataclasses import replace
from pathlib import Path

import pytest

from linkwright.pipeline.cli import run
from linkwright.pipeline.errors import ConfigError
from linkwright.pipeline.sweep import outcome_files
from linkwright.pipeline.sweep.folder import write_summaries
from linkwright.pipeline.sweep.outcome import sweep_status
from linkwright.pipeline.sweep.outcome_files import begin, outcomes_of
from linkwright.pipeline.sweep.summary_updates import updating_summary
from linkwright.stages.robot.errors import MeshError
from tests.support.processes import python
from tests.support.stand_in_builds import ended

SWEEP = ["-m", "source=sample", "root=auto,fixed,free", "output=there"]

KILLS_ITSELF = f"""
import os, signal
from linkwright.pipeline.cli import run
from tests.support.stand_in_builds import ended

def build(plan):
    if plan.root.base == "fixed":
        os.kill(os.getpid(), signal.SIGKILL)
    return ended(plan, figures={{"mass": 2.5}})

run({SWEEP!r}, build)
"""


@pytest.fixture(autouse=True)
def _in_an_empty_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def building(plan):
    if plan.root.base == "free":
        msg = "no triangles"
        raise MeshError(msg)
    return ended(plan, figures={"mass": 2.5})


def rows(root):
    return [(outcome.number, outcome.state, outcome.message) for outcome in outcomes_of(root)]


def states(root):
    return [outcome.state for outcome in outcomes_of(root)]


def job_folder(root, base):
    return next(Path(outcome.folder) for outcome in outcomes_of(root) if outcome.overrides["root"] == base)


def test_the_folder_alone_has_all_outcomes_wherever_it_is_read(tmp_path, monkeypatch):
    assert run(SWEEP, building) == 1
    expected = [(0, "built", "valid"), (1, "built", "valid"), (2, "failed", "no triangles")]
    assert rows(Path("there")) == expected
    # Without the summary's copy, and after a move to another place.
    Path("there").rename("moved")
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    monkeypatch.chdir(elsewhere)
    assert rows(Path("../moved")) == expected
    first = next(outcomes_of(tmp_path / "moved"))
    assert first.folder.startswith("../moved/root=auto-")
    assert (first.figures, first.overrides["root"]) == ({"mass": 2.5}, "auto")


def test_after_a_kill_of_the_sweep_each_job_has_its_own_outcome(tmp_path):
    done = python("-c", KILLS_ITSELF, cwd=tmp_path, LINKWRIGHT_CACHE=str(tmp_path / "cache"))
    assert done.returncode < 0, done.stderr
    root = tmp_path / "there"
    killed = (1, "failed", "was killed before its end")
    assert rows(root) == [(0, "built", "valid"), killed, (2, "missing", "missing")]
    assert sweep_status(outcomes_of(root)) == 1
    write_summaries(outcomes_of(root), root)
    assert "killed" in (root / "summary.csv").read_text()
    # What a killed sweep left is in the way of none.
    assert run(SWEEP, building) == 1
    assert states(root) == ["built", "built", "failed"]


def test_outcome_of_a_job_is_its_newest_on_any_host(monkeypatch):
    run(SWEEP, building)
    root = Path("there")
    with monkeypatch.context() as patch:
        patch.setattr(outcome_files.socket, "gethostname", lambda: "another-host")
        begin(job_folder(root, "auto"))
    assert states(root) == ["running", "built", "failed"]
    write_summaries(outcomes_of(root), root)
    failed = list(outcomes_of(root))[2]
    assert failed.folder == str(job_folder(root, "free"))
    outcome_files.leave(replace(failed, status=0, message="valid"), root / Path(failed.folder).name)
    write_summaries(outcomes_of(root), root)
    assert states(root) == ["running", "built", "built"]


def test_a_new_run_begins_without_the_outcomes_of_the_last(capsys):
    run(SWEEP, building)

    def interrupted(plan):
        if plan.root.base == "fixed":
            raise KeyboardInterrupt
        return building(plan)

    assert run(SWEEP, interrupted) == 130
    assert capsys.readouterr().err.endswith("\njob 1 starts: root=fixed\nerror: interrupted\n")
    assert states(Path("there")) == ["built", "missing", "missing"]
    # An interrupted sweep has its summary.
    assert "1 of 3 jobs built and valid" in Path("there/summary.html").read_text()


def test_the_summary_is_written_while_jobs_run(monkeypatch):
    pages = []

    def build(plan):
        page = Path("there/summary.html")
        for _ in range(200 if len(pages) < 2 else 0):
            text = page.read_text() if page.is_file() else ""
            if "of 3 jobs" in text and text not in pages:
                pages.append(text)
                break
            outcome_files_changed.wait(0.05)
        return building(plan)

    outcome_files_changed = threading.Event()
    monkeypatch.setattr(
        "linkwright.pipeline.sweep.command.updating_summary", lambda root: updating_summary(root, pause=0.05)
    )
    run(SWEEP, build)
    counts = [text[: text.index(" of 3 jobs built and valid")][-1] for text in pages]
    assert counts[0] == "0"
    assert len(pages) >= 2


def test_a_full_disk_loses_no_outcome(monkeypatch):
    def full(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(outcome_files.lock, "beside", full)
    assert run([*SWEEP[:2], "root=auto,free", "output=there"], building) == 1
    text = Path("there/summary.csv").read_text()
    assert [line.split(",")[2] for line in text.splitlines()] == ["state", "built", "failed"]


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    """A sweep's folder."""
    folder = tmp_path_factory.mktemp("kept")
    with chdir(folder):
        run(SWEEP, building)
    return folder / "there"


@pytest.mark.parametrize("change", [
    {"gpu": "a key of a later version"}, {"number": None}, {"status": "0"}, {"folder": 3}, {"label": 3},
    {"overrides": []}, {"figures": None}, {"problems": [3]}, 3, [3], [{}],
], ids=str)  # fmt: skip
def test_summary_that_was_edited_is_refused_by_its_name(kept, change):
    """A change of a job, or what is there in place of the jobs."""
    shutil.copytree(kept, "there")
    summary = Path("there/summary.json")
    record = json.loads(summary.read_bytes())
    if isinstance(change, dict):
        record["runs"][-1]["jobs"][1].update(change)
    else:
        record["runs"][-1]["jobs"] = change
    summary.write_text(json.dumps(record))
    with pytest.raises(ConfigError, match="of a later version, or was edited") as caught:
        list(outcomes_of(Path("there")))
    assert caught.value.where == str(summary)
    assert "remove it and run the sweep again" in caught.value.hint


@pytest.mark.slow
def test_ten_thousand_jobs_take_little_memory():
    jobs, *_, memory, page, table, _ = map(
        float, python("-m", "tests.benchmarks.sweeps", "10000").stdout.split()
    )
    assert jobs == 10_000
    assert memory < 300
    assert max(page, table) < 5
