"""A sweep: all jobs judged first, each in a folder of its own, the failures told at the end."""

import json
import re
import shutil
from pathlib import Path
from urllib.parse import unquote

import pytest

from linkwright.pipeline.cli import run
from linkwright.pipeline.config.compose import session
from linkwright.pipeline.config.plan import Plan
from linkwright.pipeline.digest import sha256
from linkwright.pipeline.output.folder import Output
from linkwright.pipeline.output.manifest import written_files
from linkwright.pipeline.reference.exit_status import MEANINGS
from linkwright.pipeline.show.live import ENGINE_FILE
from linkwright.pipeline.sweep.folder import prepare, write_summaries
from linkwright.pipeline.sweep.run import Job, compose_sweep
from linkwright.stages.robot.check import Check
from linkwright.stages.robot.errors import AssemblyError, ConfigError, Diagnostic, MeshError
from tests.support.cases import mostly_slow
from tests.support.outputs import OURS, shell
from tests.support.page_reader import Reader
from tests.support.stand_in_builds import Recorder, ended
from tests.support.users import URL, write

SWEEP = ["-m", "source=sample", "root=auto,free", "output=there"]
SAMPLE = "# @package _global_\ndefaults: [{override /source: sample}]\n"


def ending(plan):
    """A build that ends as its plan's base says."""
    if plan.root.base == "free":
        raise SystemExit(5)
    if plan.ground.kind == "none":
        msg = "no triangles"
        raise MeshError(msg, "upper_arm")
    status = 3 if plan.root.base == "fixed" else 0
    return ended(plan, status)


def interrupted(plan):
    raise KeyboardInterrupt


def planned(*arguments, status=0):
    """The plans of a sweep's jobs, none of which fails."""
    build = Recorder()
    assert run(["-m", *arguments], build) == status
    return build.plans


def runs_of(folder):
    return json.loads((folder / "summary.json").read_text())["runs"]


@pytest.fixture(autouse=True)
def _in_an_empty_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize(
    ("values", "status"), [("auto", 0), ("auto,fixed", 3), ("auto,fixed,free", 1), ("free", 1)]
)
def test_the_exit_status_is_that_of_the_worst_job(values, status):
    assert run(["-m", "source=sample", f"root={values}"], ending) == status
    assert status in MEANINGS["sweep"]


def test_job_that_fails_or_exits_stops_no_other(capsys):
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


def test_folder_of_a_job_is_named_by_its_own_keys():
    plans = planned("source=sample", "joints.*.damping=0.1,0.2", "until=graph")
    assert [re.sub(r"[0-9a-f]{8}$", "#", plan.output) for plan in plans] == [
        "outputs/sample.sweep/joints._.damping=0.1-#",
        "outputs/sample.sweep/joints._.damping=0.2-#",
    ]
    assert [plan.joints["*"].damping for plan in plans] == [0.1, 0.2]


def test_output_moves_the_whole_sweep(tmp_path):
    assert run(["-m", "source=sample", "root=auto,fixed", "output=there"], ending) == 3
    assert [path.name for path in tmp_path.iterdir()] == ["there"]
    accounts = {"multirun.yaml", "summary.csv", "summary.html", "summary.json"}
    assert {path.name for path in Path("there").iterdir()} == {".linkwright", ".linkwright.json", *accounts}
    jobs = runs_of(Path("there"))[-1]["jobs"]
    assert [job["status"] for job in jobs] == [0, 3]
    assert all(job["folder"].startswith("root=") for job in jobs)


REFUSED = "error: {} of {} jobs cannot be built; nothing was built\n"


@pytest.mark.parametrize(("line", "shown"), [
    ("source=sample ground.size=[1,2],[3,-1] until=graph,grph jonts=1", REFUSED.format(4, 4) + """\
  E-KEY every job: jonts: unknown key (given 1)
      did you mean joints?
  E-VALUE jobs 1, 3: until: 'grph' is not allowed
      did you mean graph? allowed: fetch, graph, mesh, export, validate
  E-VALUE jobs 2, 3: ground.size[1]: must be greater than 0 (given -1)
"""),
    ("source=sample scene.option.timestep=0.1,0", REFUSED.format(1, 2) + """\
  E-VALUE job 1 (scene.option.timestep=0): scene.option.timestep: must be greater than 0 (given 0)
"""),
    ("source=bundle source.path=a.zip,b.zip", REFUSED.format(2, 2)),
    ("source=sample root=auto,fred", REFUSED.format(1, 2) + """\
  E-OPTION job 1 (root=fred): root=fred: there is no such option
      did you mean free or fixed? options: auto, central, fixed, free
"""),
    ("source=sample root=auto,auto",
     "error: jobs 0 and 1 are the same: root=auto\n  → give each value once\n"),
    ("source=sample output=a,b",
     "error: output: cannot be swept: every job has a folder of its own in the sweep's folder\n"
     "  → give one output, for the sweep's folder\n"),
    ("source=sample hydra/launcher=nope",
     "error: the sweep has a problem\n  E-OPTION hydra/launcher=nope: there is no launcher nope\n"),
    ("source=sample hydra.sweeper.params.x=1 hydra/launcher=basic,joblib root=auto,free x=1", """\
error: the sweep has 3 problems
  E-OVERRIDE hydra.sweeper.params.x=1: this part of Hydra is set by linkwright
      --config-dir adds folders of your own; the key `output` sets the output folder
  E-OVERRIDE hydra/launcher=basic,joblib: cannot be swept
      give one value, for all jobs
  E-KEY every job: x: unknown key (given 1)
"""),
    ("source=bundle source.path=none.zip root=auto,fred", REFUSED.format(2, 2)),
])  # fmt: skip
def test_a_bad_job_is_reported_and_nothing_is_built(line, shown, capsys, tmp_path):
    assert planned(*line.split(), status=2) == []
    assert capsys.readouterr().err.startswith(shown)
    assert list(tmp_path.iterdir()) == []


def test_glob_sweeps_over_the_options_of_a_group():
    plans = planned("source=sample", "ground=glob(*)", r"output='a\${oc.env:HOME}'")
    assert [plan.ground.kind for plan in plans] == ["none", "plane"]
    assert all(plan.output.startswith("a${oc.env:HOME}/") for plan in plans)
    assert (Path("a${oc.env:HOME}") / "multirun.yaml").is_file()
    assert [path.name for path in Path().iterdir()] == ["a${oc.env:HOME}"]


@pytest.mark.parametrize(("script", "status", "shown"), [
    ("echo mine > taken", 2, "/taken is a file\n"),
    ("mkdir taken; touch taken/summary.json", 2, "taken is not empty, and no build made it"),
    (f"mkdir taken; echo '{OURS.decode()}' > taken/report.json", 2, "taken is the folder of a build"),
    ("ln -s /proc/none/x taken", 1, "error: taken: the output folder cannot be written"),
])  # fmt: skip
def test_a_place_that_a_sweep_cannot_have_is_reported(tmp_path, capsys, script, status, shown):
    shell(tmp_path, script)
    before = sorted(tmp_path.rglob("*"))
    assert planned("source=sample", "root=auto,free", "output=taken", status=status) == []
    assert shown in capsys.readouterr().err
    assert sorted(tmp_path.rglob("*")) == before


def test_sweep_over_robots_has_a_folder_of_its_own(tmp_path):
    write(tmp_path, a=SAMPLE, b=SAMPLE)
    for robots in ("robot=a,b", "robot=robot/a.yaml,robot/b.yaml"):
        plans = planned(robots)
        assert [plan.name for plan in plans] == ["a", "b"]
        assert {plan.folder.parent.as_posix() for plan in plans} == {"outputs/robots.sweep"}
        jobs = runs_of(Path("outputs/robots.sweep"))[-1]["jobs"]
        assert [job["overrides"] for job in jobs] == [{"robot": "a"}, {"robot": "b"}]


@pytest.mark.slow
def test_entry_in_the_way_of_a_job_stops_the_whole_sweep(tmp_path, capsys):
    sweep = ["source=sample", "root=auto,free,fixed", "output=there"]
    first = planned(*sweep)
    for plan in first[1:]:
        Output(plan.folder).publish({"report.json": OURS})
        (plan.folder / "scene.xml").write_text("mine")
    before = sorted(tmp_path.rglob("*"))
    assert planned(*sweep, status=2) == []
    shown = capsys.readouterr().err
    assert "2 of 3 jobs cannot be built; nothing was built" in shown
    assert "job 1 (root=free): output:" in shown
    assert "job 2 (root=fixed): output:" in shown
    assert shown.count("scene.xml is not linkwright's") == shown.count("overwrite=true") == 2
    assert sorted(tmp_path.rglob("*")) == before
    assert [plan.folder for plan in planned(*sweep, "overwrite=true")] == [plan.folder for plan in first]


HOW = [
    "overwrite=true", "source.offline=true", "source.refresh=true", "source.max_calls=9", "source.max_wait=1",
    "cache.mode=refresh", "cache={mode: refresh}", "output=outputs/sample.sweep",
]  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("how", mostly_slow(HOW, keep=2))
@pytest.mark.parametrize("values", ["auto,free", "auto"])
def test_the_folder_of_a_job_follows_its_keys_alone(how, values, monkeypatch):
    monkeypatch.setenv("ONSHAPE_ACCESS_KEY", "key-of-a-test")
    monkeypatch.setenv("ONSHAPE_SECRET_KEY", "secret-of-a-test")
    sweep = ["source=onshape", f"source.url='{URL}'", f"root={values}", "name=sample"]
    first, again = planned(*sweep), planned(*sweep, how)
    assert [plan.folder for plan in again] == [plan.folder for plan in first]
    assert not {plan.folder for plan in planned(*sweep, "ground=none")} & {plan.folder for plan in first}


@pytest.mark.slow
def test_user_files_in_a_sweep_stay(capsys):
    for _ in range(2):
        planned(*SWEEP[1:])
        Path("there/NOTES.md").write_text("mine")
    for name in ("summary.json", "multirun.yaml"):
        with Path("there", name).open("a") as file:
            file.write("\n")
        planned(*SWEEP[1:], status=2)
        assert f"{name} was changed since it was built" in capsys.readouterr().err
        planned(*SWEEP[1:], "overwrite=true")
        assert Path("there.replaced", name).read_text().endswith("\n\n")
    assert Path("there/NOTES.md").read_text() == "mine"
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
    return ended(plan, 3, calls=CALLS, figures=FIGURES, checks=CHECKS)


def test_the_summary_has_overrides_as_data_and_figures(tmp_path, capsys):
    typed = [
        "source=sample", "root=fixed,free", "joints.*.limits=[null,0.5]", "vars.y='a b'",
        "vars={x: [1, true]}", "objective={figure: mass, failed: inf}",
    ]  # fmt: skip
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
        # JSON has no number for it.
        "objective": {"figure": "mass", "failed": ".inf"},
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
def test_figures_of_a_failed_job_are_no_earlier_ones():
    def refused(plan):
        msg = "is wrong"
        raise ConfigError(msg)

    for build in (measured, refused):
        run(["-m", "source=sample", "root=free", "output=there"], build)
    calls = [entry["jobs"][0]["calls"] for entry in runs_of(Path("there"))]
    assert calls == [{"made": 5, "saved": 2}, {}]


@pytest.mark.slow
def test_runs_of_a_sweep_are_all_kept():
    old = [{"number": 0, "label": "root=auto", "status": 0, "message": "valid", "folder": "x"}]
    Path("there").mkdir()
    Path("there/summary.json").write_text(json.dumps({"linkwright-sweep": 1, "jobs": old}))
    statuses = []
    for values, build in (
        ("auto,free", interrupted),
        ("auto,fixed", ending),
        ("free", ending),
        ("auto", ending),
    ):
        statuses.append(run(["-m", "source=sample", f"root={values}", "output=there"], build))
    assert statuses == [130, 3, 1, 0]
    first, *runs = runs_of(Path("there"))
    assert (first["started"], first["jobs"][0]["folder"]) == (None, "../x")
    assert [[(job["overrides"]["root"], job["status"]) for job in entry["jobs"]] for entry in runs] == [
        [("auto", None), ("free", None)], [("auto", 0), ("fixed", 3)], [("free", 1)], [("auto", 0)],
    ]  # fmt: skip
    assert {job["message"] for job in runs[0]["jobs"]} == {"missing"}


def test_the_engine_that_the_pages_share_is_the_sweeps_own(tmp_path, monkeypatch):
    monkeypatch.setenv("LINKWRIGHT_PAGE", "whole")
    monkeypatch.setattr("linkwright.pipeline.sweep.folder.engine_file", lambda: b"engine")
    plan = Plan.parse({"name": "arm", "source": {"kind": "sample"}, "output": str(tmp_path / "one" / "job")})
    prepare(tmp_path / "one", [Job(0, "mesh=hull", plan)], ["mesh=hull,coacd"])
    write_summaries([], tmp_path / "one")
    assert (tmp_path / "one" / ENGINE_FILE).read_bytes() == b"engine"
    assert ENGINE_FILE in written_files(tmp_path / "one")
    prepare(tmp_path / "one", [Job(0, "mesh=hull", plan)], ["mesh=hull,coacd"])  # nothing is in the way
    without = plan.model_copy(update={"page": plan.page.model_copy(update={"live": "kinematics"})})
    prepare(tmp_path / "two", [Job(0, "mesh=hull", without)], [])
    assert not (tmp_path / "two" / ENGINE_FILE).exists()


def test_page_of_a_sweep_shows_its_jobs_and_no_secret(monkeypatch):
    secret = "s3cr3t-value-of-a-key"
    monkeypatch.setenv("ONSHAPE_SECRET_KEY", secret)
    figures = {"mass": 1.25, "links": 3}

    def build(plan):
        if plan.root.base == "free":
            raise AssemblyError(f"no {secret}", problems=[Diagnostic("E-MASS", f"no mass {secret}", "Pin")])
        plan.folder.mkdir(parents=True, exist_ok=True)
        (plan.folder / "report.html").touch()
        return ended(plan, figures=figures)

    assert run(SWEEP, build) == 1
    page = Path("there/summary.html").read_bytes()
    read = Reader(page)
    words = ("1 of 2 jobs built and valid, 1 failed", "over root", "E-MASS Pin: no mass ***", "mass 1.25 kg")
    assert not read.lacking(*words)
    files = [path for path in Path("there").rglob("*") if path.is_file()]
    assert any(path.name.endswith(".outcome.json") for path in files)
    assert [path for path in files if secret.encode() in path.read_bytes()] == []
    folder = next(job["folder"] for job in runs_of(Path("there"))[-1]["jobs"] if job["status"] == 0)
    assert f"{folder}/report.html" in [unquote(link) for link in read.links]
    assert written_files(Path("there"))["summary.html"] == sha256(page)
    shutil.rmtree(Path("there", folder))
    assert run(SWEEP, build) == 1
    assert Path("there/summary.html").read_bytes() == page


def test_swept_mappings_are_told_apart(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    swept = ["joints.*={damping:1},{friction:1}", "mesh.tolerance=1e-3"]
    with session() as composer:
        request = composer.with_params(*composer.read(swept, multirun=True))
        jobs = compose_sweep(composer, request, lambda plan: []).jobs
    assert [job.label for job in jobs] == ["joints.*={damping:1}", "joints.*={friction:1}"]
    assert [job.overrides["joints.*"] for job in jobs] == [{"damping": 1}, {"friction": 1}]
