"""Every launcher, from fresh installs of its extra with both Hydras: the bytes of single builds. A real Slurm
without accounting, where jobs are killed and preempted."""

import json
import subprocess
import sys
import sysconfig
from dataclasses import dataclass
from pathlib import Path

import pytest
from filelock import FileLock

from tests.fake_onshape.server import OnshapeServer
from tests.fake_onshape.settable import leaning_stand
from tests.support import slurm
from tests.support.command import environment, robot_files, run_in
from tests.support.places import copy_source

pytestmark = pytest.mark.slow

BUILD = ["source=sample", "mesh=raw", "page.preview=none", "until=graph", "cache.mode=bypass"]
ROOTS = ("auto", "fixed")
PLUG_INS = ("joblib-launcher", "submitit-launcher", "ray-launcher", "optuna-sweeper")
HYDRAS = {
    "1.3": ["hydra-core==1.3.*"],
    "1.4": ["hydra-core==1.4.0rc3", *(f"hydra-{name}==1.4.0rc3" for name in PLUG_INS)],
}
KEY = "a-key-that-no-job-needs"


@dataclass(frozen=True)
class Fresh:
    """A fresh environment: its programs, and what it builds of each robot alone."""

    programs: Path
    expected: dict[str, dict[str, bytes]]


@pytest.fixture
def fresh(hydra, run_folder):
    """The environment with the launchers' extras and this Hydra, made once; skips without an index of
    packages."""
    folder = run_folder / f"hydra{hydra}"
    programs = folder / "venv" / "bin"
    with FileLock(f"{folder}.lock"):
        if not folder.exists():
            refused = install(folder, programs, HYDRAS[hydra])
            (folder / "refused").write_text(refused)
            for root in ROOTS if not refused else ():
                done = linkwright(folder, programs, *BUILD, f"root={root}", f"output={root}")
                assert done.returncode == 0, done.stderr
        refused = (folder / "refused").read_text()
    if refused:
        pytest.skip(f"pip cannot install the launchers' extras: {refused}")
    return Fresh(programs, {root: robot_files(folder / f"{root}.graph") for root in ROOTS})


def install(folder, programs, requirements):
    """Installs a copy of the checkout and what its extras need; why that is not possible here, or nothing."""
    source = folder / "source"
    copy_source(source)
    subprocess.run([sys.executable, "-m", "venv", str(folder / "venv")], check=True)
    # What the tests run with counts as installed, so that pip installs what it lacks, and this Hydra.
    (own,) = (folder / "venv").glob("lib/python*/site-packages")
    (own / "of_the_tests.pth").write_text(f"{sysconfig.get_paths()['purelib']}\n")
    wanted = [f"{source}[sweep,slurm,ray,optuna]", *requirements]
    command = [str(programs / "pip"), "install", "--quiet", "--no-compile", *wanted]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    return "\n".join(done.stderr.splitlines()[-3:]) if done.returncode else ""


def linkwright(here, programs, *arguments, **more):
    environ = environment(here, seeded=False, **{"ONSHAPE_SECRET_KEY": KEY, **more})
    return run_in(here, programs / "linkwright", *arguments, environ=environ, timeout=300)


def jobs(folder):
    return json.loads((folder / "summary.json").read_text())["runs"][-1]["jobs"]


def built(folder):
    """The files of each job by its robot."""
    return {job["overrides"]["root"]: robot_files(folder / job["folder"]) for job in jobs(folder)}


def holding(folder, text):
    """The files of a folder that hold a text."""
    files = [file for file in folder.rglob("*") if file.is_file()]
    return [file for file in files if text.encode() in file.read_bytes()]


@pytest.mark.parametrize("hydra", HYDRAS)
@pytest.mark.parametrize("launcher", ["workstation", "slurm_local", "ray"])
def test_a_sweep_has_the_bytes_of_single_builds(tmp_path, fresh, launcher):
    sweep = ["-m", *BUILD, f"root={','.join(ROOTS)}", f"hydra/launcher={launcher}", "output=sweep"]
    more = {"RAY_TMPDIR": "/tmp"} if launcher == "ray" else {}
    done = linkwright(tmp_path, fresh.programs, *sweep, PYTHONWARNINGS="error::UserWarning", **more)
    assert done.returncode == 0, done
    assert built(tmp_path / "sweep") == fresh.expected
    assert holding(tmp_path, KEY) == []


@pytest.mark.parametrize("hydra", HYDRAS)
def test_so_it_has_on_a_real_slurm(tmp_path, fresh):
    if reason := slurm.missing():
        pytest.skip(reason)
    sweep = ["-m", *BUILD, f"root={','.join(ROOTS)}", "hydra/launcher=slurm", "hydra.launcher.mem_gb=1"]
    with slurm.running(tmp_path / "slurm") as variables:
        nowhere = linkwright(
            tmp_path, fresh.programs, *sweep, "hydra.launcher.partition=none", "output=other", **variables
        )
        done = linkwright(tmp_path, fresh.programs, *sweep, "output=sweep", **variables)
    assert nowhere.returncode == 2
    assert "error: hydra/launcher: cannot run the jobs: sbatch: error: invalid partition" in nowhere.stderr
    assert done.returncode == 0, done
    assert built(tmp_path / "sweep") == fresh.expected
    assert holding(tmp_path, KEY) == []


TROUBLED = """\
import os, signal, sys, time
from pathlib import Path
from linkwright.pipeline.cli import run
from linkwright.pipeline.report import Report

def build(plan):
    mark = Path(f"{plan.root.base}.began")
    if not mark.exists():
        mark.touch()
        if plan.root.base == "fixed":
            os.kill(os.getpid(), signal.SIGKILL)
        if plan.root.base == "free":
            os.system(f"scancel --signal=USR2 {os.environ['SLURM_JOB_ID']}")
            time.sleep(60)
    return Report("built", plan.name, str(plan.folder), plan.until, 0)

sys.exit(run(sys.argv[1:], build))
"""
"""A sweep on Slurm whose job is killed for one robot, and preempted for another, when it first runs."""


@pytest.mark.parametrize("hydra", ["1.3"])
def test_slurm_job_fails_alone_if_killed_and_reruns_if_preempted(tmp_path, fresh):
    if reason := slurm.missing():
        pytest.skip(reason)
    script = tmp_path / "troubled.py"
    script.write_text(TROUBLED)
    sweep = ["-m", "source=sample", "root=auto,fixed,free", "hydra/launcher=slurm"]
    command = [fresh.programs / "python", script, *sweep, "hydra.launcher.mem_gb=1", "output=sweep"]
    with slurm.running(tmp_path / "slurm") as variables:
        environ = environment(tmp_path, seeded=False, **variables)
        ran = [run_in(tmp_path, *command, environ=environ, timeout=150) for _ in range(2)]
    runs = json.loads((tmp_path / "sweep/summary.json").read_text())["runs"]
    statuses = [[job["status"] for job in run["jobs"]] for run in runs]
    assert [done.returncode for done in ran] == [1, 0], [done.stderr for done in ran]
    assert statuses == [[0, 1, 0], [0, 0, 0]]


LENGTHS = ("100 mm", "150 mm", "200 mm", "300 mm", "400 mm", "500 mm")
MOTORS = ("sts3215", "mx64", "xl330_m288", "xl320")
TRIALS = 16


@pytest.mark.parametrize("hydra", HYDRAS)
def test_optuna_finds_the_optimum_of_a_document_and_of_motors(tmp_path, fresh):
    """A search of 16 trials finds, among 24 robots, the robot whose motor holds a payload with the smallest
    share of its torque; an exhaustive sweep is the oracle. Each configuration is fetched once."""
    lengths = ",".join(f"'{length}'" for length in LENGTHS)
    space = [f"source.configuration.leg_length={lengths}", f"vars.motor={','.join(MOTORS)}"]
    robot = ["until=graph", "page.preview=none", "objective.figure=torque_margin", "validate.payload.jaw=0.1"]
    search = ["hydra/sweeper=optuna", f"hydra.sweeper.n_trials={TRIALS}", "hydra.sweeper.sampler.seed=0"]
    with OnshapeServer(leaning_stand()) as server:
        source = ["source=onshape", f"source.url='{server.document_url()}'", *robot]
        sweep = ["-m", *source, *space, "name=stand", "actuators.swing.motor=${vars.motor}"]
        environ = server.environ
        whole = linkwright(tmp_path, fresh.programs, *sweep, "output=whole", **environ)
        assert whole.returncode == 0, whole
        server.reset()
        done = linkwright(tmp_path, fresh.programs, *sweep, *search, "output=searched", **environ)
        assert done.returncode == 0, done
        assert server.count <= 1
    costs = {job["label"]: job["objective"] for job in jobs(tmp_path / "whole")}
    assert len(costs) == len(LENGTHS) * len(MOTORS)
    tried = {job["label"]: job["objective"] for job in jobs(tmp_path / "searched")}
    assert len(tried) <= TRIALS
    assert tried.items() <= costs.items()
    assert min(tried, key=lambda label: tried[label]) == min(costs, key=lambda label: costs[label])
    assert holding(tmp_path, environ["ONSHAPE_SECRET_KEY"]) == []
