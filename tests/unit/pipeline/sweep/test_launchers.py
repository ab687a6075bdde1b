"""Launchers: their settings, what they leave of the processors to a job, and jobs that are killed."""

import json
import os
import re
import signal
import subprocess
import sys
import time
from contextlib import suppress
from importlib.util import find_spec
from pathlib import Path

import pytest
from hydra.core.plugins import Plugins
from hydra.plugins.launcher import Launcher

from linkwright.pipeline.cli import run
from linkwright.pipeline.sweep.launchers.processors import share
from linkwright.stages.robot.system import process_usage
from linkwright.stages.robot.system.install import install
from tests.support.places import PROJECT
from tests.support.processes import gone
from tests.support.stand_in_builds import ended
from tests.unit.pipeline.sweep.test_sweep import ending, planned

SWEEP = ["-m", "source=sample", "root=auto,fixed"]
LOCAL = "hydra/launcher=slurm_local"


@pytest.fixture(autouse=True)
def _in_an_empty_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    # Processes of submitit's find this file, and not the one of the process that starts them.
    monkeypatch.setenv("PYTHONPATH", str(PROJECT))


def finishing(plan):
    """A build that succeeds, and tells how many processors it may use."""
    return ended(plan, figures={"processors": float(process_usage.processors())})


def killed_once(plan):
    """A build whose process is killed with one of the robots, when it is first built."""
    mark = Path("was_killed")
    if plan.root.base == "fixed" and not mark.exists():
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return finishing(plan)


def jobs():
    return json.loads(Path("outputs/sample.sweep/summary.json").read_text())["runs"][-1]["jobs"]


@pytest.mark.parametrize(("settings", "jobs", "processors", "expected"), [
    ({"_target_": "x.JoblibLauncher", "n_jobs": -1}, 64, 8, 1),
    ({"_target_": "x.JoblibLauncher", "n_jobs": -1}, 2, 8, 4),
    ({"_target_": "x.JoblibLauncher", "n_jobs": 3}, 64, 8, 2),
    ({"_target_": "x.JoblibLauncher", "n_jobs": -2}, 64, 8, 1),
    ({"_target_": "x.JoblibLauncher", "n_jobs": None}, 64, 8, 8),
    ({"_target_": "x.JoblibLauncher", "n_jobs": 20}, 64, 8, 1),
    ({"_target_": "x.LocalLauncher"}, 3, 8, 2),
    ({"_target_": "x.LocalLauncher"}, 64, 8, 1),
    ({"_target_": "x.SlurmLauncher", "cpus_per_task": 4}, 64, 8, 4),
    ({"_target_": "x.SlurmLauncher", "cpus_per_task": None}, 64, 8, 1),
    ({"_target_": "x.RayLauncher", "ray": {"remote": {"num_cpus": 2}}}, 64, 8, 2),
    ({"_target_": "x.RayLauncher", "ray": {"remote": {}}}, 64, 8, 1),
    ({"_target_": "x.BasicLauncher"}, 64, 8, None),
])  # fmt: skip
def test_jobs_side_by_side_share_the_processors(settings, jobs, processors, expected):
    assert share(settings, jobs, processors) == expected


def test_a_process_uses_no_more_processors_than_its_share():
    everything = process_usage.processors()
    with process_usage.limited_processors(1):
        assert process_usage.processors() == 1
        with process_usage.limited_processors(None):
            assert process_usage.processors() == everything
    with process_usage.limited_processors(everything + 5):
        assert process_usage.processors() == everything


@pytest.mark.skipif(find_spec("hydra_plugins.hydra_ray_launcher") is not None, reason="Ray is installed")
def test_launcher_without_its_plug_in_comes_with_its_command(tmp_path, capsys):
    assert run([*SWEEP, "hydra/launcher=ray"]) == 2
    text = "E-OPTION every job: hydra/launcher=ray: the launcher ray needs a plug-in of Hydra"
    assert text in capsys.readouterr().err
    assert run([*SWEEP[:-1], "root=auto", "hydra/launcher=ray"]) == 2
    assert install("hydra-ray-launcher", "ray") in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("launcher", "typed", "shown"), [
    ("slurm_local", "timeout_min=0", "hydra.launcher.timeout_min: must be at least 1 (given 0)"),
    ("slurm", "array_parallelism=0", "hydra.launcher.array_parallelism: must be at least 1 (given 0)"),
    ("slurm", "mem_gb=2.5", "E-OVERRIDE hydra.launcher.mem_gb: must be a whole number (given 2.5)"),
    ("slurm", "mem_bg=2", "did you mean mem_gb?"),
    ("slurm_local", "colour=red", "settings: submitit_folder, timeout_min, cpus_per_task,"),
    ("workstation", "n_jobs=0", "hydra.launcher.n_jobs: must not be 0"),
    ("slurm", "memory=3", "E-OVERRIDE hydra.launcher.memory: is not a setting of this launcher"),
    ("slurm", "partition=main", "hydra/launcher: Slurm is not on this computer"),
])  # fmt: skip
def test_wrong_settings_of_a_launcher_are_one_message(tmp_path, monkeypatch, capsys, launcher, typed, shown):
    pytest.importorskip("hydra_plugins.hydra_submitit_launcher")
    monkeypatch.setenv("PATH", str(tmp_path))
    assert run([*SWEEP, f"hydra/launcher={launcher}", f"hydra.launcher.{typed}"], finishing) == 2
    err = capsys.readouterr().err
    assert shown in err
    assert err.count("hydra") <= 2
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("detail", [[], pytest.param(["-q"], marks=pytest.mark.slow)])
def test_a_sweep_on_submitit_tells_first_where_its_jobs_go(capsys, detail):
    pytest.importorskip("hydra_plugins.hydra_submitit_launcher")
    assert run([*SWEEP, LOCAL, *detail], finishing) == 0
    line = "2 jobs for slurm_local: outputs/sample.sweep/summary.html shows them\n"
    assert capsys.readouterr().err == ("" if detail else line)


@pytest.mark.slow
@pytest.mark.parametrize("launcher", ["workstation", "slurm_local"])
def test_a_killed_job_is_reported_and_the_next_run_completes(capsys, launcher):
    pytest.importorskip("hydra_plugins.hydra_submitit_launcher")
    sweep = [*SWEEP, f"hydra/launcher={launcher}"]
    assert run(sweep, killed_once) == 1
    first = jobs()
    assert first[1]["status"] == 1
    assert re.search("killed|without a result", first[1]["message"])
    if launcher == "slurm_local":
        # joblib ends all processes with the one that was killed.
        assert first[0]["status"] == 0
    assert run(sweep, killed_once) == 0
    assert [job["status"] for job in jobs()] == [0, 0]
    share = max(1, process_usage.processors() // 2)
    assert [job["figures"]["processors"] for job in jobs()] == [share, share]
    # What submitit leaves is below the folder of the sweep.
    assert [path.name for path in Path("outputs").iterdir()] == ["sample.sweep"]
    assert Path("outputs/sample.sweep/.submitit").is_dir() == (launcher == "slurm_local")


BEGUN = """\
import os, sys, time
from pathlib import Path
from linkwright.pipeline.cli import run
from linkwright.pipeline.interrupt import command

def build(plan):
    Path(f"{plan.root.base}.process").write_text(str(os.getpid()))
    time.sleep(60)

sys.exit(command(lambda: run(sys.argv[1:], build)))
"""


def begun(folder, *arguments):
    """A sweep whose jobs all run, and their processes."""
    (folder / "start.py").write_text(BEGUN)
    sweep = subprocess.Popen(
        [sys.executable, "start.py", *arguments], cwd=folder, stderr=subprocess.PIPE, text=True
    )
    until = time.monotonic() + 60
    while time.monotonic() < until:
        numbers = [file.read_text() for file in folder.glob("*.process")]
        if len(numbers) == 2 and all(numbers):
            break
        time.sleep(0.1)
    return sweep, [int(text) for text in numbers]


@pytest.mark.slow
def test_an_interrupt_ends_the_processes_of_submitit(tmp_path):
    pytest.importorskip("hydra_plugins.hydra_submitit_launcher")
    sweep, processes = begun(tmp_path, *SWEEP, LOCAL)
    sweep.send_signal(signal.SIGINT)
    _, err = sweep.communicate(timeout=60)
    assert (sweep.returncode, err.splitlines()[-1]) == (130, "error: interrupted")
    assert gone(processes)


@pytest.mark.slow
@pytest.mark.parametrize("launcher", ["workstation", "slurm_local"])
def test_killed_sweep_completes_in_the_next_run(tmp_path, launcher):
    pytest.importorskip("hydra_plugins.hydra_submitit_launcher")
    sweep, processes = begun(tmp_path, *SWEEP, f"hydra/launcher={launcher}")
    sweep.kill()
    sweep.wait()
    for process in processes:
        with suppress(ProcessLookupError):
            os.kill(process, signal.SIGKILL)
    assert gone(processes)
    assert run([*SWEEP, f"hydra/launcher={launcher}"], finishing) == 0
    assert [job["status"] for job in jobs()] == [0, 0]


def test_jobs_run_side_by_side_with_joblib(capsys):
    pytest.importorskip("hydra_plugins.hydra_joblib_launcher")
    arguments = ["-m", "source=sample", "root=auto,fixed,free", "hydra/launcher=workstation"]
    assert run([*arguments, "hydra.launcher.n_jobs=2"], ending) == 1
    assert [line.split()[1] for line in capsys.readouterr().out.splitlines()[1:-1]] == ["0", "3", "1"]


@pytest.mark.slow
@pytest.mark.parametrize(("size", "batches"), [("-1", 1), ("2", 2), ("null", 1)])
def test_jobs_may_be_launched_in_batches(size, batches, monkeypatch):
    # Hydra loads its plug-ins itself, so that an import may give another class of that name.
    launchers = {launcher.__name__: launcher for launcher in Plugins.instance().discover(Launcher)}
    basic = launchers["BasicLauncher"]
    launched, launch = [], basic.launch

    def watched(self, jobs, initial_job_idx):
        launched.append(initial_job_idx)
        return launch(self, jobs, initial_job_idx)

    monkeypatch.setattr(basic, "launch", watched)
    plans = planned("source=sample", "root=auto,fixed,free", f"hydra.sweeper.max_batch_size={size}")
    assert [plan.root.base for plan in plans] == ["auto", "fixed", "free"]
    assert launched == [0, 2][:batches]


def test_a_launcher_that_cannot_run_is_reported(capsys):
    pytest.importorskip("hydra_plugins.hydra_joblib_launcher")
    planned(
        "source=sample", "root=auto,free", "hydra/launcher=joblib", "hydra.launcher.batch_size=0", status=2
    )
    message = "error: hydra/launcher: cannot run the jobs: batch_size must be"
    assert capsys.readouterr().err.startswith(message)


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(signal, "pthread_sigmask"), reason="needs signal masks")
def test_an_interrupt_of_many_processes_is_one_message(tmp_path):
    pytest.importorskip("hydra_plugins.hydra_joblib_launcher")
    arguments = ["-m", "root=auto,fixed,free", "ground=plane,none", "hydra/launcher=workstation"]
    sweep = subprocess.Popen(
        [sys.executable, "-m", "linkwright", *arguments],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(PROJECT), "LINKWRIGHT_CACHE": str(tmp_path / "cache")},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    first = sweep.stderr.readline()
    os.killpg(sweep.pid, signal.SIGINT)
    out, err = sweep.communicate(timeout=60)
    assert (sweep.returncode, out) == (130, "")
    lines = [first, *err.splitlines()]
    assert lines[-1] == "error: interrupted"
    assert [line for line in lines[:-1] if not re.match(r"job \d (starts|ended)", line)] == []
