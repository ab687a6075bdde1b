"""A sweep: all jobs judged first, each in a folder of its own, the failures told at the end."""

import json
import os
import re
import shutil
import signal
import subprocess
import sys
from pathlib import Path
from urllib.parse import unquote

import pytest

from linkwright.pipeline.cli import run
from linkwright.pipeline.config.plan import Plan
from linkwright.pipeline.digest import sha256
from linkwright.pipeline.output.folder import Output
from linkwright.pipeline.output.manifest import ours
from linkwright.pipeline.report import Report
from linkwright.pipeline.show.live import ENGINE_FILE
from linkwright.pipeline.sweep.folder import keep, prepare
from linkwright.stages.robot.check import Check
from linkwright.stages.robot.errors import AssemblyError, ConfigError, Diagnostic, MeshError
from tests.support.cases import mostly_slow
from tests.support.page_reader import Reader
from tests.support.places import PROJECT


def ending(plan):
    """A build that ends as its plan's base says."""
    if plan.root.base == "free":
        raise SystemExit(5)
    if plan.ground.kind == "none":
        msg = "no triangles"
        raise MeshError(msg, "upper_arm")
    status = 3 if plan.root.base == "fixed" else 0
    return Report("built", plan.name, str(plan.folder), plan.until, status)


class Recorder:
    """A build that succeeds and remembers its plans."""

    def __init__(self):
        self.plans = []

    def __call__(self, plan):
        self.plans.append(plan)
        return Report("built", plan.name, str(plan.folder), plan.until, 0)


def runs_of(folder):
    return json.loads((folder / "summary.json").read_text())["runs"]


@pytest.fixture(autouse=True)
def _in_an_empty_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize(
    ("values", "status"),
    [("auto", 0), ("auto,fixed", 3), ("auto,fixed,free", 1), ("free", 1)],
)
def test_the_exit_status_is_that_of_the_worst_job(values, status):
    assert run(["-m", "source=sample", f"root={values}"], ending) == status


def test_a_job_that_fails_or_exits_stops_no_other_and_is_reported_in_the_table(capsys):
    run(["-m", "source=sample", "root=free,fixed,auto", "ground=plane,none"], ending)
    out, err = capsys.readouterr()
    rows = [re.split(r"\s{2,}", line) for line in out.splitlines()]
    assert [(row[1], row[2], row[3]) for row in rows[1:-1]] == [
        ("1", "SystemExit: 5", "root=free ground=plane"),
        ("1", "SystemExit: 5", "root=free ground=none"),
        ("3", "a check failed", "root=fixed ground=plane"),
        ("1", "upper_arm: no triangles", "root=fixed ground=none"),
        ("0", "valid", "root=auto ground=plane"),
        ("1", "upper_arm: no triangles", "root=auto ground=none"),
    ]
    assert out.splitlines()[-1] == "1 of 6 jobs built and valid: outputs/sample.sweep"
    shown = [re.sub(r"[0-9.]+ s:", "# s:", line) for line in err.splitlines()]
    assert shown[:2] == ["job 0 starts: root=free ground=plane", "job 0 ended after # s: SystemExit: 5"]
    assert shown[-1] == "job 5 ended after # s: upper_arm: no triangles"
    assert len(shown) == 12


def test_each_job_has_a_folder_of_its_own_named_by_what_sets_it_apart():
    build = Recorder()
    assert run(["-m", "source=sample", "joints.*.damping=0.1,0.2", "until=graph"], build) == 0
    folders = [plan.output for plan in build.plans]
    assert [re.sub(r"[0-9a-f]{8}$", "#", folder) for folder in folders] == [
        "outputs/sample.sweep/joints._.damping=0.1-#",
        "outputs/sample.sweep/joints._.damping=0.2-#",
    ]
    assert [plan.joints["*"].damping for plan in build.plans] == [0.1, 0.2]


@pytest.mark.slow
def test_the_folders_are_the_same_in_the_next_run_and_differ_where_anything_differs():
    first, again, other = Recorder(), Recorder(), Recorder()
    run(["-m", "source=sample", "root=auto,free"], first)
    run(["-m", "root=auto,free", "source=sample", "cache.mode=refresh"], again)
    run(["-m", "source=sample", "root=auto,free", "ground=none"], other)
    folders = [{plan.output for plan in build.plans} for build in (first, again, other)]
    assert folders[0] == folders[1]
    assert not folders[0] & folders[2]


def test_the_key_output_moves_the_sweep(tmp_path):
    build = Recorder()
    assert run(["-m", "source=sample", "root=auto,free", "output=there"], build) == 0
    assert all(plan.output.startswith("there/root=") for plan in build.plans)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["there"]


def test_hydras_account_and_the_summary_lie_beside_the_jobs(tmp_path):
    run(["-m", "source=sample", "root=auto,fixed"], ending)
    folder = tmp_path / "outputs" / "sample.sweep"
    assert sorted(path.name for path in folder.iterdir()) == [
        ".linkwright.json",
        "multirun.yaml",
        "summary.html",
        "summary.json",
    ]
    assert [one["status"] for one in runs_of(folder)[-1]["jobs"]] == [0, 3]


@pytest.mark.parametrize(
    ("arguments", "shown"),
    [
        (
            ["source=sample", "ground.size=[1,2],[3,-1]", "until=graph,grph", "jonts=1"],
            "error: 4 of 4 jobs cannot be built; nothing was built\n"
            "  E-KEY every job: jonts: unknown key (given 1)\n"
            "      did you mean joints?\n"
            "  E-VALUE jobs 1, 3: until: 'grph' is not allowed\n"
            "      did you mean graph? allowed: fetch, graph, mesh, export, validate\n"
            "  E-VALUE jobs 2, 3: ground.size[1]: must be greater than 0 (given -1)\n",
        ),
        (
            ["source=sample", "scene.option.timestep=0.1,0"],
            "error: 1 of 2 jobs cannot be built; nothing was built\n"
            "  E-VALUE job 1 (scene.option.timestep=0): scene.option.timestep: "
            "must be greater than 0 (given 0)\n",
        ),
        (
            ["source=bundle", "source.path=a.zip,b.zip"],
            "error: 2 of 2 jobs cannot be built; nothing was built\n",
        ),
        (
            ["source=sample", "root=auto,fred"],
            "error: 1 of 2 jobs cannot be built; nothing was built\n"
            "  E-OPTION job 1 (root=fred): root=fred: there is no such option\n"
            "      did you mean free or fixed? options: auto, central, fixed, free\n",
        ),
        (
            ["source=sample", "root=auto,auto"],
            "error: jobs 0 and 1 are the same: root=auto\n  → give each value once\n",
        ),
        (
            ["source=sample", "output=a,b"],
            "error: output: cannot be swept: every job has a folder of its own in the sweep's folder\n"
            "  → give one output, for the sweep's folder\n",
        ),
        (
            ["source=sample", "hydra/launcher=nope"],
            "error: the sweep has a problem\n  E-OPTION hydra/launcher=nope: there is no launcher nope\n",
        ),
        (
            [
                "source=sample",
                "hydra.sweeper.params.x=1",
                "hydra/launcher=basic,joblib",
                "root=auto,free",
                "x=1",
            ],
            "error: the sweep has 3 problems\n"
            "  E-OVERRIDE hydra.sweeper.params.x=1: this part of Hydra is set by linkwright\n"
            "      --config-dir adds folders of your own; the key `output` sets the output folder\n"
            "  E-OVERRIDE hydra/launcher=basic,joblib: cannot be swept\n"
            "      give one value, for all jobs\n"
            "  E-KEY every job: x: unknown key (given 1)\n",
        ),
        (
            ["source=bundle", "source.path=none.zip", "root=auto,fred"],
            "error: 2 of 2 jobs cannot be built; nothing was built\n",
        ),
    ],
)
def test_a_bad_job_is_reported_and_nothing_is_built(arguments, shown, capsys, tmp_path):
    build = Recorder()
    assert run(["-m", *arguments], build) == 2
    assert capsys.readouterr().err.startswith(shown)
    assert build.plans == []
    assert list(tmp_path.iterdir()) == []


def test_jobs_run_side_by_side_with_joblib(capsys):
    pytest.importorskip("hydra_plugins.hydra_joblib_launcher")
    arguments = ["-m", "source=sample", "root=auto,fixed,free", "hydra/launcher=workstation"]
    assert run([*arguments, "hydra.launcher.n_jobs=2"], ending) == 1
    assert [line.split()[1] for line in capsys.readouterr().out.splitlines()[1:-1]] == ["0", "3", "1"]


@pytest.mark.slow
@pytest.mark.parametrize(("size", "batches"), [("-1", 1), ("2", 2), ("null", 1)])
def test_jobs_may_be_launched_in_batches(size, batches, monkeypatch):
    from hydra.core.plugins import Plugins
    from hydra.plugins.launcher import Launcher

    # Hydra loads its plug-ins itself, so that an import may give another class of that name.
    (basic,) = (one for one in Plugins.instance().discover(Launcher) if one.__name__ == "BasicLauncher")
    launched, launch = [], basic.launch

    def watched(self, jobs, initial_job_idx):
        launched.append(initial_job_idx)
        return launch(self, jobs, initial_job_idx)

    monkeypatch.setattr(basic, "launch", watched)
    build = Recorder()
    assert (
        run(["-m", "source=sample", "root=auto,fixed,free", f"hydra.sweeper.max_batch_size={size}"], build)
        == 0
    )
    assert [plan.root.base for plan in build.plans] == ["auto", "fixed", "free"]
    assert launched == [0, 2][:batches]


def test_a_launcher_that_cannot_run_is_reported(capsys):
    pytest.importorskip("hydra_plugins.hydra_joblib_launcher")
    arguments = ["source=sample", "root=auto,free", "hydra/launcher=joblib", "hydra.launcher.n_jobs=0"]
    assert run(["-m", *arguments], Recorder()) == 2
    assert capsys.readouterr().err.startswith("error: hydra/launcher: cannot run the jobs: n_jobs == 0")


def test_a_folder_is_no_interpolation():
    build = Recorder()
    assert run(["-m", "source=sample", "root=auto,free", r"output='a\${oc.env:HOME}'"], build) == 0
    assert all(plan.output.startswith("a${oc.env:HOME}/") for plan in build.plans)
    assert (Path("a${oc.env:HOME}") / "multirun.yaml").is_file()
    assert [path.name for path in Path().iterdir()] == ["a${oc.env:HOME}"]


def test_an_interrupt_ends_the_sweep(capsys):
    def interrupted(plan):
        raise KeyboardInterrupt

    assert run(["-m", "source=sample", "root=auto,free"], interrupted) == 130
    assert capsys.readouterr().err == "job 0 starts: root=auto\nerror: interrupted\n"


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


def test_a_glob_sweeps_over_the_options_of_a_group():
    build = Recorder()
    assert run(["-m", "source=sample", "ground=glob(*)"], build) == 0
    assert [plan.ground.kind for plan in build.plans] == ["none", "plane"]


@pytest.mark.parametrize(
    ("make", "status", "shown"),
    [
        (lambda place: place.write_text("mine"), 2, "/taken is a file\n"),
        (
            lambda place: place.mkdir() or (place / "summary.json").touch(),
            2,
            "taken is not empty, and no build made it",
        ),
        (
            lambda place: place.mkdir() or (place / "report.json").write_text('{"linkwright-report": 1}'),
            2,
            "taken is the folder of a build",
        ),
        (
            lambda place: place.symlink_to("/proc/none/x"),
            1,
            "error: taken: the output folder cannot be written",
        ),
    ],
    ids=["a file", "a file of others", "a build", "cannot be made"],
)
def test_a_place_that_a_sweep_cannot_have_is_reported_and_nothing_is_built(
    tmp_path, capsys, make, status, shown
):
    make(tmp_path / "taken")
    before = sorted(tmp_path.rglob("*"))
    build = Recorder()
    assert run(["-m", "source=sample", "root=auto,free", "output=taken"], build) == status
    assert shown in capsys.readouterr().err
    assert build.plans == []
    assert sorted(tmp_path.rglob("*")) == before


@pytest.mark.slow
def test_a_sweep_may_be_run_again_where_it_was(tmp_path):
    for _ in range(2):
        assert run(["-m", "source=sample", "root=auto,free", "output=there"], Recorder()) == 0
    assert [len(one["jobs"]) for one in runs_of(tmp_path / "there")] == [2, 2]


def test_a_sweep_over_robots_lies_in_a_folder_of_its_own(tmp_path):
    own = "# @package _global_\ndefaults: [{override /source: sample}]\n"
    (tmp_path / "robot").mkdir()
    for name in ("a", "b"):
        (tmp_path / "robot" / f"{name}.yaml").write_text(own)
    build = Recorder()
    assert run(["-m", "robot=a,b"], build) == 0
    assert [plan.name for plan in build.plans] == ["a", "b"]
    assert {plan.folder.parent.as_posix() for plan in build.plans} == {"outputs/robots.sweep"}


@pytest.mark.slow
def test_what_is_in_the_way_of_any_job_stops_the_sweep_before_its_first_job(tmp_path, capsys):
    sweep = ["-m", "source=sample", "root=auto,free,fixed", "output=there"]
    first = Recorder()
    assert run(sweep, first) == 0
    for plan in first.plans[1:]:
        Output(plan.folder).publish({"report.json": b'{"linkwright-report": 1}'})
        (plan.folder / "scene.xml").write_text("mine")
    before = sorted(tmp_path.rglob("*"))
    build = Recorder()
    assert run(sweep, build) == 2
    shown = capsys.readouterr().err
    assert "2 of 3 jobs cannot be built; nothing was built" in shown
    assert "job 1 (root=free): output:" in shown
    assert "job 2 (root=fixed): output:" in shown
    assert shown.count("scene.xml is not linkwright's") == shown.count("overwrite=true") == 2
    assert build.plans == []
    assert sorted(tmp_path.rglob("*")) == before
    assert run([*sweep, "overwrite=true"], build) == 0
    assert [plan.folder for plan in build.plans] == [plan.folder for plan in first.plans]


HOW = [
    "overwrite=true",
    "source.offline=true",
    "source.refresh=true",
    "source.max_calls=9",
    "source.max_wait=1",
    "cache.mode=refresh",
    "cache={mode: refresh}",
    "output=outputs/sample.sweep",
]


@pytest.mark.slow
@pytest.mark.parametrize("how", mostly_slow(HOW, keep=2))
@pytest.mark.parametrize("values", ["auto,free", "auto"])
def test_how_a_job_is_run_does_not_move_its_folder(how, values, monkeypatch):
    monkeypatch.setenv("ONSHAPE_ACCESS_KEY", "key-of-a-test")
    monkeypatch.setenv("ONSHAPE_SECRET_KEY", "secret-of-a-test")
    url = f"source.url='https://cad.onshape.com/documents/{'d' * 24}/w/{'a' * 24}/e/{'e' * 24}'"
    sweep = ["-m", "source=onshape", url, f"root={values}", "name=sample"]
    first, again = Recorder(), Recorder()
    assert run(sweep, first) == 0
    assert run([*sweep, how], again) == 0
    assert [plan.folder for plan in again.plans] == [plan.folder for plan in first.plans]


@pytest.mark.slow
def test_what_the_user_keeps_in_a_sweep_stays_and_an_account_that_was_changed_stops_it(tmp_path, capsys):
    sweep = ["-m", "source=sample", "root=auto,free", "output=there"]
    for _ in range(2):
        assert run(sweep, Recorder()) == 0
        (tmp_path / "there" / "NOTES.md").write_text("mine")
    for name in ("summary.json", "multirun.yaml"):
        with (tmp_path / "there" / name).open("a") as file:
            file.write("\n")
        assert run(sweep, Recorder()) == 2
        assert f"{name} was changed since it was built" in capsys.readouterr().err
        assert run([*sweep, "overwrite=true"], Recorder()) == 0
        assert (tmp_path / "there.replaced" / name).read_text().endswith("\n\n")
    assert (tmp_path / "there" / "NOTES.md").read_text() == "mine"


@pytest.mark.slow
def test_a_sweep_that_is_cut_short_may_be_run_again(tmp_path):
    sweep = ["-m", "source=sample", "root=auto,free", "output=there"]

    def cut_short(plan):
        raise KeyboardInterrupt

    for _ in range(2):
        assert run(sweep, cut_short) == 130
    assert run(sweep, Recorder()) == 0


@pytest.mark.slow
def test_a_single_build_into_a_sweep_is_refused(tmp_path, capsys):
    assert run(["-m", "source=sample", "root=auto,free", "output=there"], Recorder()) == 0
    assert run(["source=sample", "output=there"]) == 2
    assert "there is the folder of a sweep" in capsys.readouterr().err


FIGURES = {"mass": 3.28571, "dof": 7.0, "links": 11}
CHECKS = (Check("masses", True, "", 0.0, 1.0), Check("poses", False, "", 2.0, 1.0))
CALLS = {"made": 5, "saved": 2, "remaining": {"all": 9}}


def measured(plan):
    """A build with figures; of a free base it fails, and leaves what it cost."""
    if plan.root.base == "free":
        left = Path(f"{plan.folder}.failed")
        left.mkdir(parents=True, exist_ok=True)
        shown = {"figures": {"links": 2}, "calls": CALLS, "error": {"message": "no triangles"}}
        (left / "report.json").write_text(json.dumps(shown))
        msg = "no triangles"
        raise MeshError(msg)
    return Report(
        "invalid", plan.name, str(plan.folder), plan.until, 3, calls=CALLS, figures=FIGURES, checks=CHECKS
    )


def test_the_summary_has_overrides_as_data_and_figures(tmp_path, capsys):
    typed = [
        "source=sample",
        "root=fixed,free",
        "joints.*.limits=[null,0.5]",
        "vars.y='a b'",
        "vars={x: [1, true]}",
    ]
    assert run(["-m", *typed, "~ground", "output=there"], measured) == 1
    (only,) = runs_of(tmp_path / "there")
    assert only["overrides"] == [*typed, "~ground", "output=there"]
    assert re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ", only["started"])
    first, second = only["jobs"]
    assert first["overrides"] == {
        "source": "sample",
        "root": "fixed",
        "joints.*.limits": [None, 0.5],
        "vars.y": "a b",
        "vars": {"x": [1, True]},
        "~ground": None,
        "output": "there",
    }
    assert (second["overrides"]["root"], second["figures"], second["checks"]) == ("free", {"links": 2}, {})
    assert (first["figures"], first["checks"]) == (FIGURES, {"passed": 1, "warned": [], "failed": ["poses"]})
    assert first["calls"] == second["calls"] == {"made": 5, "saved": 2}
    rows = [re.split(r"\s{2,}", line) for line in capsys.readouterr().out.splitlines()]
    assert rows[0] == ["job", "status", "what", "kg", "dof", "checks", "calls", "folder"]
    assert rows[1][1:8] == ["3", "a check failed", "root=fixed", "3.286", "7", "1/2", "5"]
    assert rows[2][1:5] == ["1", "no triangles", "root=free", "5"]


@pytest.mark.slow
def test_what_an_earlier_build_left_is_no_figure_of_a_failed_job(tmp_path):
    def refused(plan):
        msg = "is wrong"
        raise ConfigError(msg)

    run(["-m", "source=sample", "root=free", "output=there"], measured)
    run(["-m", "source=sample", "root=free", "output=there"], refused)
    assert [one["jobs"][0]["calls"] for one in runs_of(tmp_path / "there")] == [{"made": 5, "saved": 2}, {}]


@pytest.mark.slow
def test_a_sweep_keeps_all_its_runs_also_those_of_other_values(tmp_path):
    for values in ("auto,fixed", "free", "auto"):
        run(["-m", "source=sample", f"root={values}", "output=there"], ending)
    runs = runs_of(tmp_path / "there")
    assert [[job["overrides"]["root"] for job in one["jobs"]] for one in runs] == [
        ["auto", "fixed"],
        ["free"],
        ["auto"],
    ]
    assert [[job["status"] for job in one["jobs"]] for one in runs] == [[0, 3], [1], [0]]


@pytest.mark.slow
def test_a_run_that_is_cut_short_is_kept_and_so_is_one_of_an_older_version(tmp_path):
    def cut_short(plan):
        raise KeyboardInterrupt

    old = [{"number": 0, "label": "root=auto", "status": 0, "message": "valid", "folder": "x"}]
    (tmp_path / "there").mkdir()
    (tmp_path / "there" / "summary.json").write_text(json.dumps({"linkwright-sweep": 1, "jobs": old}))
    assert run(["-m", "source=sample", "root=auto,free", "output=there"], cut_short) == 130
    assert run(["-m", "source=sample", "root=auto", "output=there"], ending) == 0
    assert [len(one["jobs"]) for one in runs_of(tmp_path / "there")] == [1, 0, 1]


def test_robots_by_their_paths_are_named_in_the_summary(tmp_path):
    own = "# @package _global_\ndefaults: [{override /source: sample}]\n"
    (tmp_path / "there").mkdir()
    for name in ("a", "b"):
        (tmp_path / "there" / f"{name}.yaml").write_text(own)
    assert run(["-m", "robot=there/a.yaml,there/b.yaml"], Recorder()) == 0
    (only,) = runs_of(tmp_path / "outputs" / "robots.sweep")
    assert [job["overrides"] for job in only["jobs"]] == [{"robot": "a"}, {"robot": "b"}]


def test_the_engine_that_the_pages_share_is_the_sweeps_own(tmp_path, monkeypatch):
    monkeypatch.setenv("LINKWRIGHT_PAGE", "whole")
    monkeypatch.setattr("linkwright.pipeline.sweep.folder.engine_file", lambda: b"engine")
    plan = Plan.parse({"name": "arm", "source": {"kind": "sample"}})
    prepare(tmp_path / "one", plan, ["mesh=hull,coacd"])
    keep([], tmp_path / "one")
    assert (tmp_path / "one" / ENGINE_FILE).read_bytes() == b"engine"
    assert ENGINE_FILE in ours(tmp_path / "one")
    prepare(tmp_path / "one", plan, ["mesh=hull,coacd"])  # nothing is in the way
    without = plan.model_copy(update={"page": plan.page.model_copy(update={"live": "kinematics"})})
    prepare(tmp_path / "two", without, [])
    assert not (tmp_path / "two" / ENGINE_FILE).exists()


def test_the_page_of_a_sweep_shows_its_jobs_and_no_secret_and_is_the_same_again(tmp_path, monkeypatch):
    secret = "s3cr3t-value-of-a-key"
    monkeypatch.setenv("ONSHAPE_SECRET_KEY", secret)

    def build(plan):
        if plan.root.base == "free":
            raise AssemblyError(f"no {secret}", problems=[Diagnostic("E-MASS", f"no mass {secret}", "Pin")])
        report = Report(
            "built", plan.name, str(plan.folder), plan.until, 0, figures={"mass": 1.25, "links": 3}
        )
        plan.folder.mkdir(parents=True, exist_ok=True)
        (plan.folder / "report.html").touch()
        return report

    sweep = ["-m", "source=sample", "root=auto,free", "output=there"]
    assert run(sweep, build) == 1
    page = (tmp_path / "there" / "summary.html").read_bytes()
    read = Reader(page)
    for words in (
        "1 of 2 jobs built and valid, 1 failed",
        "over root",
        "E-MASS Pin: no mass ***",
        "mass 1.25 kg",
    ):
        assert words in read.text
    assert secret.encode() not in page
    folder = next(one["folder"] for one in runs_of(tmp_path / "there")[-1]["jobs"] if one["status"] == 0)
    assert f"{Path(folder).name}/report.html" in [unquote(link) for link in read.links]
    kept = json.loads((tmp_path / "there" / ".linkwright.json").read_text())["files"]
    assert kept["summary.html"] == sha256(page)
    shutil.rmtree(folder)
    assert run(sweep, build) == 1
    assert (tmp_path / "there" / "summary.html").read_bytes() == page
