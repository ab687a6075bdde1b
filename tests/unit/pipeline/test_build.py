"""The build: five stages in order, cached, reported, and put into place."""

import json
import pickle
import sys
from dataclasses import asdict, dataclass, field
from hashlib import sha256

import pytest
import yaml

from linkwright.pipeline.config.plan import Plan
from linkwright.pipeline.errors import AssemblyError, ConfigError, InTheWay, SecretFound, render
from linkwright.pipeline.output import manifest
from linkwright.pipeline.run.build import build
from linkwright.pipeline.stages.context import FILES, NOTES, notes
from linkwright.pipeline.stages.stage import STAGES
from linkwright.pipeline.terminal.progress import Lines, Quiet
from linkwright.stages.robot import codec
from linkwright.stages.robot.check import Check
from linkwright.stages.robot.errors import Diagnostic

WARNING = Diagnostic("W-LIMIT", "elbow has no limits", "Arm/Elbow", "set joints.elbow.limits")


@dataclass
class Fake:
    """A stage that hands out `files`, counts its runs, and fails where it is told to."""

    name: str
    files: dict = field(default_factory=dict)
    pinned: bool = True
    diagnostics: tuple = ()
    figures: dict = field(default_factory=dict)
    more: dict = field(default_factory=dict)
    error: Exception | None = None
    wrong: ConfigError | None = None
    runs: int = 0
    version: int = 1
    libraries: tuple = ()
    modules: tuple = ()

    def preflight(self, plan, environ):
        if self.wrong:
            raise self.wrong

    def config(self, context):
        return {"name": context.plan.name} if self.pinned else None

    def force(self, context):
        return False

    def inputs(self, context):
        return {} if self.name == "fetch" else context.digests(list(context.files)[-1])

    def run(self, context):
        self.runs += 1
        context.detail(f"at work on {self.name}")
        if self.error:
            raise self.error
        return {**self.files, NOTES: notes(f"made {self.name}", self.diagnostics, self.figures, **self.more)}


PASSED = Check("compiles", True, "no warning")


def fakes(checks=(PASSED,), **changes):
    stages = {
        "fetch": Fake("fetch", {"manifest.json": b"{}"}, more={"source": {"microversion": "m1"}, "calls": 3}),
        "graph": Fake("graph", {"robot.json": b"{}"}, diagnostics=(WARNING,), figures={"links": 2}),
        "mesh": Fake("mesh", {"geometry.json": b"{}"}, figures={"triangles": 12}),
        "export": Fake("export", {FILES + "arm.urdf": b"<robot/>", FILES + "assets/a.stl": b"solid"}),
        "validate": Fake("validate", {"checks.json": codec.encode_checks(tuple(checks))}),
    }
    for name, change in changes.items():
        for key, value in change.items():
            setattr(stages[name], key, value)
    return tuple(stages.values())


@pytest.fixture
def make(tmp_path):
    """Builds into tmp_path/out/arm with the cache in tmp_path/cache."""

    def run(stages, progress=None, environ=None, **more):
        data = {
            "name": "arm",
            "source": {"kind": "sample"},
            "output": str(tmp_path / "out" / "arm"),
            "cache": {"dir": str(tmp_path / "cache")},
        }
        return build(Plan.parse(data | more), progress, environ or {}, stages=stages)

    return run


@pytest.fixture
def folder(tmp_path):
    return tmp_path / "out" / "arm"


def names(folder):
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file())


def test_a_build_leaves_the_exported_files_with_report_plan_and_log(make, folder):
    report = make(fakes())
    assert names(folder) == [
        ".linkwright.json",
        "arm.urdf",
        "assets/a.stl",
        "build.log",
        "config.yaml",
        "report.html",
        "report.json",
    ]
    assert report.status == "built"
    assert report.exit_status == 0
    assert report.folder == str(folder)
    assert set(report.outputs) == {"arm.urdf", "assets/a.stl"}
    assert report.figures == {"links": 2, "triangles": 12}
    assert report.source == {"kind": "sample", "microversion": "m1"}
    assert report.diagnostics == (WARNING,)
    assert [stage.outputs for stage in report.stages] == [f"made {stage.name}" for stage in STAGES]
    assert json.loads((folder / "report.json").read_bytes())["linkwright-report"] == 1


@pytest.mark.parametrize("until", ["fetch", "validate"])
def test_the_manifest_has_the_digest_of_every_file(make, folder, until):
    make(fakes(), until=until)
    place = folder if until == "validate" else folder.with_name("arm.fetch")
    found = {name: sha256((place / name).read_bytes()).hexdigest() for name in names(place)}
    del found[manifest.NAME]
    assert manifest.ours(place) == found


def test_the_config_that_is_left_behind_is_the_plan(make, folder):
    make(fakes())
    left = yaml.safe_load((folder / "config.yaml").read_text())
    assert Plan.parse(left).output == str(folder)
    assert left["name"] == "arm"


def test_a_second_build_runs_no_stage_and_reports_the_same(make):
    stages = fakes()
    first, second = make(stages), make(stages)
    assert [stage.runs for stage in stages] == [1] * 5
    assert [stage.cached for stage in first.stages] == [False] * 5
    assert [stage.cached for stage in second.stages] == [True] * 5
    assert second.diagnostics == first.diagnostics
    assert second.figures == first.figures
    assert second.checks == first.checks
    assert second.outputs == first.outputs
    assert second.calls == {"made": 0, "saved": 3}


def test_a_source_that_may_change_is_asked_again_and_the_rest_stays_cached(make):
    stages = fakes(fetch={"pinned": False})
    make(stages)
    make(stages)
    assert [stage.runs for stage in stages] == [2, 1, 1, 1, 1]
    stages[0].files = {"manifest.json": b"{ }"}
    make(stages)
    assert [stage.runs for stage in stages] == [3, 2, 1, 1, 1], "graph made the same robot: the rest stays"


def test_refresh_runs_every_stage_and_bypass_keeps_nothing(make, tmp_path):
    stages = fakes()
    make(stages, cache={"mode": "bypass", "dir": str(tmp_path / "cache")})
    assert not (tmp_path / "cache").exists()
    make(stages)
    make(stages, cache={"mode": "refresh", "dir": str(tmp_path / "cache")})
    assert [stage.runs for stage in stages] == [3] * 5


def test_what_was_fetched_last_is_exit_status_3_where_the_newest_was_asked_for(make, folder):
    fetch = {"more": {"source": {}, "calls": 3, "stale": True}, "pinned": False}
    report = make(fakes(fetch=fetch))
    assert (report.status, report.exit_status) == ("stale", 3)
    assert (folder / "arm.urdf").exists()
    assert json.loads((folder / "report.json").read_bytes())["status"] == "stale"
    assert '<span class="status stale">' in (folder / "report.html").read_text()
    bad = Check("mass", False, "link arm is 1 kg, CAD says 2 kg", 1.0, 2.0)
    assert make(fakes(checks=[bad], fetch=fetch, validate={"version": 2})).status == "invalid"
    fetch["more"]["stale"] = False
    assert (make(fakes(fetch=fetch)).status, make(fakes(fetch=fetch)).exit_status) == ("built", 0)


def test_a_failed_check_is_exit_status_3_and_the_build_is_swapped_in(make, folder):
    report = make(fakes(checks=[Check("mass", False, "link arm is 1 kg, CAD says 2 kg", 1.0, 2.0)]))
    assert report.status == "invalid"
    assert report.exit_status == 3
    assert (folder / "arm.urdf").exists()
    left = json.loads((folder / "report.json").read_bytes())
    assert left["exit_status"] == 3
    assert left["checks"][0]["detail"] == "link arm is 1 kg, CAD says 2 kg"


@pytest.mark.parametrize(("diagnostics", "status"), [((WARNING,), 3), ((Diagnostic("I-X", "fyi"),), 0)])
def test_a_warning_fails_a_strict_build_and_information_does_not(make, diagnostics, status):
    stages = fakes(graph={"diagnostics": diagnostics})
    assert make(stages).exit_status == 0
    strict = make(stages, validate={"level": "strict"})
    assert strict.exit_status == status
    assert (strict.checks[-1].name, strict.checks[-1].passed) == ("no_warnings", status == 0)


def test_a_failing_stage_leaves_a_report_beside_and_the_last_build_whole(make, folder):
    make(fakes())
    before = {name: (folder / name).read_bytes() for name in names(folder)}
    error = AssemblyError("the assembly has no mates", where="Arm", hint="add mates", problems=(WARNING,))
    with pytest.raises(AssemblyError, match="no mates"):
        make(fakes(graph={"error": error, "version": 2}))
    assert {name: (folder / name).read_bytes() for name in names(folder)} == before
    failed = folder.with_name("arm.failed")
    assert names(failed) == [".linkwright.json", "build.log", "config.yaml", "report.html", "report.json"]
    report = json.loads((failed / "report.json").read_bytes())
    assert (report["status"], report["exit_status"]) == ("failed", 1)
    assert report["error"]["where"] == "Arm"
    assert report["error"]["problems"][0]["code"] == "W-LIMIT"
    assert [stage["name"] for stage in report["stages"]] == ["fetch"]
    assert "the assembly has no mates" in (failed / "build.log").read_text()
    make(fakes())
    assert not failed.exists()


def test_a_fault_of_the_program_leaves_its_traceback_in_the_log(make, folder):
    with pytest.raises(ZeroDivisionError):
        make(fakes(mesh={"error": ZeroDivisionError("oops")}))
    assert "Traceback" in folder.with_name("arm.failed").joinpath("build.log").read_text()


def test_what_is_wrong_before_the_first_stage_leaves_nothing(make, tmp_path):
    with pytest.raises(ConfigError):
        make(fakes(fetch={"wrong": ConfigError("no key")}))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("name", "until"),
    [("arm.urdf", "validate"), ("report.json", "export"), ("build.log", "fetch")],
)
def test_a_file_of_others_in_the_way_stops_a_build_before_the_first_stage(make, folder, name, until):
    place = folder.with_name("arm.fetch") if until == "fetch" else folder
    place.mkdir(parents=True)
    manifest.write(place, {})
    (place / name).write_text("x")
    stages = fakes()
    with pytest.raises(ConfigError, match=f"{name} is not linkwright's"):
        make(stages, until=until)
    assert stages[0].runs == 0
    assert names(folder.parent) == [f"{place.name}/{manifest.NAME}", f"{place.name}/{name}"]
    assert make(stages, until=until, overwrite=True).exit_status == 0
    assert (place.with_name(f"{place.name}.replaced") / name).read_text() == "x"


def test_what_a_user_keeps_there_is_carried_over_and_named_in_the_log(make, folder):
    make(fakes())
    (folder / "NOTES.md").write_text("mine")
    make(fakes())
    assert (folder / "NOTES.md").read_text() == "mine"
    assert "kept, since not linkwright's: NOTES.md\n" in (folder / "build.log").read_text()


def test_a_new_path_that_is_taken_ends_the_build_and_keeps_both(make, folder):
    make(fakes())
    (folder / "assets" / "b.stl").write_text("mine")
    more = {"files": {FILES + "arm.urdf": b"<new/>", FILES + "assets/b.stl": b"solid"}, "version": 2}
    with pytest.raises(InTheWay, match=r"assets/b\.stl is not linkwright's"):
        make(fakes(export=more))
    failed = folder.with_name("arm.failed")
    assert (folder / "assets" / "b.stl").read_text() == "mine"
    assert (folder / "arm.urdf").read_text() == "<robot/>"
    assert (failed / "assets" / "b.stl").read_text() == "solid"
    assert (failed / "arm.urdf").read_text() == "<new/>"
    assert json.loads((failed / "report.json").read_bytes())["exit_status"] == 1
    make(fakes(export=more), overwrite=True)
    assert (folder / "assets" / "b.stl").read_text() == "solid"
    assert not failed.exists()


def test_a_report_that_cannot_be_left_is_reported_and_the_failure_is_the_one_to_raise(make, folder, capsys):
    folder.with_name("arm.failed").mkdir(parents=True)
    (folder.with_name("arm.failed") / "build.log").write_text("mine")
    assert make(fakes()).exit_status == 0
    with pytest.raises(AssemblyError, match="no mates"):
        make(fakes(graph={"error": AssemblyError("no mates"), "version": 2}), Lines(sys.stdout))
    assert "no report of this failure could be written" in capsys.readouterr().out
    assert names(folder.with_name("arm.failed")) == ["build.log"]


def test_an_output_that_holds_the_source_is_refused(make, folder):
    folder.mkdir(parents=True)
    (folder / "arm.zip").write_bytes(b"")
    with pytest.raises(ConfigError, match="holds the source"):
        make(fakes(), source={"kind": "bundle", "path": str(folder / "arm.zip")})


@pytest.mark.parametrize("until", ["fetch", "export"])
def test_until_stops_after_a_stage_and_names_the_folder_by_it(make, folder, until):
    stages = fakes()
    report = make(stages, until=until)
    assert [stage.name for stage in report.stages][-1] == until
    assert report.checks == ()
    place = folder if until == "export" else folder.with_name("arm.fetch")
    assert report.folder == str(place)
    assert (place / "report.json").exists()
    assert [p.name for p in folder.parent.iterdir() if not p.name.startswith(".")] == [place.name]


def test_progress_hears_every_stage_and_is_closed_also_after_an_error(make):
    class Ears:
        def __init__(self):
            self.heard = []

        def start(self, stage):
            self.heard.append(("start", stage))

        def detail(self, stage, line):
            self.heard.append((stage, line))

        def done(self, stage):
            self.heard.append(("done", stage.name))

        def close(self):
            self.heard.append("close")

    ears = Ears()
    with pytest.raises(AssemblyError):
        make(fakes(graph={"error": AssemblyError("no")}), ears)
    assert ears.heard == [
        ("start", "fetch"),
        ("fetch", "at work on fetch"),
        ("done", "fetch"),
        ("start", "graph"),
        ("graph", "at work on graph"),
        "close",
    ]


def test_what_passes_while_a_stage_runs_is_heard_of_that_stage(make):
    heard = []

    class Watcher(Quiet):
        def transient(self, stage, line):
            heard.append((stage, line))

    class Slow(Fake):
        def run(self, context):
            context.transient(f"some of {self.name} received")
            return super().run(context)

    stages = fakes()
    make((Slow("fetch", stages[0].files), *stages[1:]), Watcher())
    assert heard == [("fetch", "some of fetch received")]


def test_no_secret_reaches_the_log(make, folder):
    secret = {"ONSHAPE_SECRET_KEY": "s3cr3t-value"}
    error = AssemblyError("refused s3cr3t-value")
    with pytest.raises(AssemblyError):
        make(fakes(fetch={"error": error}), environ=secret)
    left = folder.with_name("arm.failed")
    assert "refused ***" in (left / "build.log").read_text()
    for name in names(left):
        assert b"s3cr3t-value" not in (left / name).read_bytes()


def test_a_file_with_a_key_is_not_handed_out_and_the_last_good_build_stays(make, folder):
    make(fakes())
    before = {name: (folder / name).read_bytes() for name in names(folder)}
    key = {"ONSHAPE_SECRET_KEY": "s3cr3t-value"}
    # It came from the cache, where it was kept before the key was known.
    shown = {"robot.json": b"{}", "outline.txt": b"arm: s3cr3t-va...", "tables.json": b"[]"}
    held = {FILES + "arm.urdf": b"<robot>\n<!-- s3cr3t-value -->"}
    stages = fakes(graph={"files": shown, "version": 2}, export={"files": held, "version": 2})
    make(stages, output=str(folder.with_name("other")))
    with pytest.raises(SecretFound) as caught:
        make(stages, environ=key)
    assert caught.value.where == "arm.urdf, line 2"
    assert {name: (folder / name).read_bytes() for name in names(folder)} == before
    left = folder.with_name("arm.failed")
    for name in names(left):
        assert b"s3cr3t-va" not in (left / name).read_bytes()
    assert json.loads((left / "report.json").read_bytes())["error"]["type"] == "SecretFound"


@pytest.mark.parametrize(("name", "title"), [(f"onshape_{'c' * 8}", "Left arm"), ("arm", "")])
def test_a_robot_that_nobody_named_is_shown_with_the_name_of_its_assembly(make, tmp_path, name, title):
    url = f"https://cad.onshape.com/documents/{'a' * 24}/w/{'b' * 24}/e/{'c' * 24}"
    stages = fakes(fetch={"more": {"source": {"title": "Left arm"}}})
    report = make(stages, source={"kind": "onshape", "url": url}, name=name)
    assert report.title == title
    assert report.name == name
    assert report.source["url"] == url


def test_the_notes_of_an_error_are_what_a_failed_build_leaves(make, folder, monkeypatch):
    monkeypatch.chdir(folder.parents[1])
    stages = fakes(graph={"error": AssemblyError("no robot", hint="mend it")})
    with pytest.raises(AssemblyError) as caught:
        make(stages)
    assert render(caught.value).splitlines() == [
        "error: no robot",
        "  → mend it",
        "  report: out/arm.failed/report.html",
    ]


def test_a_key_that_others_can_read_gets_a_remark(make, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / ".env").write_text("ONSHAPE_ACCESS_KEY=acc355-key\nONSHAPE_SECRET_KEY=s3cr3t-key\n")
    source = {
        "kind": "onshape",
        "url": f"https://cad.onshape.com/documents/{'a' * 24}/w/{'b' * 24}/e/{'c' * 24}",
    }
    for mode, codes in ((0o644, ["I-DOTENV", "W-LIMIT"]), (0o600, ["W-LIMIT"])):
        (tmp_path / ".env").chmod(mode)
        report = make(fakes(), source=source)
        assert [found.code for found in report.diagnostics] == codes
    assert [found.code for found in make(fakes()).diagnostics] == ["W-LIMIT"]


@pytest.mark.parametrize("key", ["e", "linkwright-report", '{"status"'])
def test_a_report_stays_whole_and_ours_whatever_the_key_is(make, folder, key):
    environ = {"ONSHAPE_ACCESS_KEY": key, "ONSHAPE_SECRET_KEY": key}
    report = make(fakes(), environ=environ)
    assert set(json.loads((folder / "report.json").read_bytes())) == {
        "linkwright-report",
        *asdict(report),
    } - {"narrow_outline"}
    assert make(fakes(), environ=environ).exit_status == 0


def test_everything_that_is_known_before_the_first_stage_is_reported_at_once(make, folder):
    folder.mkdir(parents=True)
    (folder / "config.yaml").write_text("x")
    wrong = {name: {"wrong": ConfigError(f"no {name}", name)} for name in ("fetch", "mesh")}
    with pytest.raises(ConfigError) as caught:
        make(fakes(**wrong))
    assert [problem.where for problem in caught.value.problems] == ["fetch", "mesh", "output"]


def test_build_and_its_report_can_be_sent_to_another_process(make):
    assert pickle.loads(pickle.dumps(build)) is build
    report = make(fakes())
    assert pickle.loads(pickle.dumps(report)) == report


def test_the_log_lists_stages_findings_and_checks(make, folder, capsys):
    make(fakes(), Lines(sys.stdout))
    log = (folder / "build.log").read_text()
    for text in (
        "graph    ...",
        "W-LIMIT Arm/Elbow: elbow has no limits",
        "passed compiles",
        "at work on mesh",
    ):
        assert text in log
    assert "graph    ..." in capsys.readouterr().out


SHOWN = {"graph.svg": b"<svg>arm</svg>", "outline.txt": "└─ elbow\n".encode(), "tables.json": b"[]"}


def test_the_picture_is_an_output_and_the_tree_is_in_the_report(make, folder):
    stages = fakes(graph={"files": {"robot.json": b"{}", **SHOWN}})
    report = make(stages)
    assert (folder / "graph.svg").read_bytes() == SHOWN["graph.svg"]
    assert set(report.outputs) == {"arm.urdf", "assets/a.stl", "graph.svg"}
    assert report.outline == ("└─ elbow",)
    assert make(stages).outline == report.outline
    page = (folder / "report.html").read_text()
    assert "<svg>arm</svg>" in page
    assert f">{len(SHOWN['graph.svg'])}</td>" in page


def test_a_failed_build_shows_what_came_before_in_its_page(make, folder):
    graph = {"files": {"robot.json": b"{}", **SHOWN}}
    with pytest.raises(AssemblyError):
        make(fakes(graph=graph, mesh={"error": AssemblyError("no <mesh>", hint="mend it")}))
    page = (folder.with_name("arm.failed") / "report.html").read_text()
    for words in ("<svg>arm</svg>", "└─ elbow", "no &lt;mesh&gt;", "mend it"):
        assert words in page
