"""The build: five stages in order, cached, reported, and put into place."""

import json
import pickle
import sys
from dataclasses import asdict, dataclass, field
from hashlib import sha256

import pytest
import yaml

from linkwright.pipeline.config.compose import compose_plan
from linkwright.pipeline.config.plan import Plan
from linkwright.pipeline.errors import AssemblyError, ConfigError, InTheWay, SecretFound, render
from linkwright.pipeline.output import manifest
from linkwright.pipeline.run.build import build, build_files
from linkwright.pipeline.stages.context import FILES, NOTES, notes
from linkwright.pipeline.stages.stage import STAGES
from linkwright.pipeline.terminal.progress import Lines
from linkwright.stages.robot import codec
from linkwright.stages.robot.check import Check
from linkwright.stages.robot.errors import Diagnostic

WARNING = Diagnostic("W-LIMIT", "elbow has no limits", "Arm/Elbow", "set joints.elbow.limits")
PASSED = Check("compiles", True, "no warning")
FAILED = Check("mass", False, "link arm is 1 kg, CAD says 2 kg", 1.0, 2.0)
RUN_FILES = [".linkwright.json", "build.log", "config.yaml", "report.html", "report.json"]
SHOWN = {"graph.svg": b"<svg>arm</svg>", "outline.txt": "└─ elbow\n".encode(), "tables.json": b"[]"}
URL = f"https://cad.onshape.com/documents/{'a' * 24}/w/{'b' * 24}/e/{'c' * 24}"
SECRET = {"ONSHAPE_SECRET_KEY": "s3cr3t-value"}


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
        context.transient(f"some of {self.name}")
        if self.error:
            raise self.error
        return {**self.files, NOTES: notes(f"made {self.name}", self.diagnostics, self.figures, **self.more)}


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
    data = {"name": "arm", "source": {"kind": "sample"}, "output": str(tmp_path / "out" / "arm")}
    data["cache"] = {"dir": str(tmp_path / "cache")}

    def run(stages, progress=None, environ=None, **more):
        return build(Plan.parse(data | more), progress, environ or {}, stages=stages)

    return run


@pytest.fixture
def folder(tmp_path):
    return tmp_path / "out" / "arm"


@pytest.fixture
def failed(folder):
    return folder.with_name("arm.failed")


def files_of(folder):
    paths = [path for path in sorted(folder.rglob("*")) if path.is_file()]
    return {str(path.relative_to(folder)): path.read_bytes() for path in paths}


def report_in(folder):
    return json.loads((folder / "report.json").read_bytes())


def runs_of(stages):
    return [stage.runs for stage in stages]


def test_build_leaves_files_report_plan_and_log(make, folder, capsys):
    stages = fakes(graph={"files": {"robot.json": b"{}", **SHOWN}})
    report = make(stages, Lines(sys.stdout))
    assert {*files_of(folder)} == {*RUN_FILES, "arm.urdf", "assets/a.stl", "graph.svg"}
    assert (report.status, report.exit_status, report.folder) == ("built", 0, str(folder))
    assert set(report.outputs) == {"arm.urdf", "assets/a.stl", "graph.svg"}
    assert report.figures == {"links": 2, "triangles": 12}
    assert report.source == {"kind": "sample", "microversion": "m1"}
    assert report.diagnostics == (WARNING,)
    assert [stage.outputs for stage in report.stages] == [f"made {stage.name}" for stage in STAGES]
    assert report_in(folder)["linkwright-report"] == 1
    left = yaml.safe_load((folder / "config.yaml").read_text())
    assert (Plan.parse(left).output, left["name"]) == (str(folder), "arm")
    log = (folder / "build.log").read_text()
    for text in (
        "graph    ...", "W-LIMIT Arm/Elbow: elbow has no limits", "passed compiles", "at work on mesh",
    ):  # fmt: skip
        assert text in log
    assert "graph    ..." in capsys.readouterr().out
    assert (folder / "graph.svg").read_bytes() == SHOWN["graph.svg"]
    assert report.outline == make(stages).outline == ("└─ elbow",)
    page = (folder / "report.html").read_text()
    assert "<svg>arm</svg>" in page
    assert f">{len(SHOWN['graph.svg'])}</td>" in page


@pytest.mark.parametrize("until", ["fetch", "export", "validate"])
def test_until_stops_after_a_stage_and_all_files_are_listed(make, folder, until):
    report = make(fakes(), until=until)
    assert [stage.name for stage in report.stages][-1] == until
    assert bool(report.checks) == (until == "validate")
    place = folder.with_name("arm.fetch") if until == "fetch" else folder
    assert report.folder == str(place)
    assert [path.name for path in folder.parent.iterdir() if not path.name.startswith(".")] == [place.name]
    digests = {name: sha256(data).hexdigest() for name, data in files_of(place).items()}
    del digests[manifest.NAME]
    assert manifest.written_files(place) == digests


def test_a_second_build_runs_no_stage_and_reports_the_same(make, tmp_path):
    stages = fakes()
    first, second = make(stages), make(stages)
    assert runs_of(stages) == [1] * 5
    assert [stage.cached for report in (first, second) for stage in report.stages] == [False] * 5 + [True] * 5
    for name in ("diagnostics", "figures", "checks", "outputs"):
        assert getattr(second, name) == getattr(first, name)
    assert second.calls == {"made": 0, "saved": 3}
    make(stages, cache={"mode": "refresh", "dir": str(tmp_path / "cache")})
    assert runs_of(stages) == [2] * 5
    for _ in range(2):
        make(stages, cache={"mode": "bypass", "dir": str(tmp_path / "none")})
    assert runs_of(stages) == [4] * 5
    assert not (tmp_path / "none").exists()


def test_source_that_may_change_is_read_again_alone(make):
    stages = fakes(fetch={"pinned": False})
    for data, runs in ((b"{}", [1] * 5), (b"{}", [2, 1, 1, 1, 1]), (b"{ }", [3, 2, 1, 1, 1])):
        stages[0].files = {"manifest.json": data}
        make(stages)
        assert runs_of(stages) == runs, "where graph made the same robot, the rest stays"


def test_stale_source_is_exit_status_3(make, folder):
    fetch = {"more": {"source": {}, "calls": 3, "stale": True}, "pinned": False}
    report = make(fakes(fetch=fetch))
    assert (report.status, report.exit_status) == ("stale", 3)
    assert (folder / "arm.urdf").exists()
    assert report_in(folder)["status"] == "stale"
    assert '<span class="status stale">' in (folder / "report.html").read_text()
    assert make(fakes(checks=[FAILED], fetch=fetch, validate={"version": 2})).status == "invalid"
    fetch["more"]["stale"] = False
    report = make(fakes(fetch=fetch))
    assert (report.status, report.exit_status) == ("built", 0)


@pytest.mark.parametrize(("diagnostics", "status"), [((WARNING,), 3), ((Diagnostic("I-X", "fyi"),), 0)])
def test_warning_fails_a_strict_build(make, diagnostics, status):
    stages = fakes(graph={"diagnostics": diagnostics})
    assert make(stages).exit_status == 0
    strict = make(stages, validate={"level": "strict"})
    assert strict.exit_status == status
    assert (strict.checks[-1].name, strict.checks[-1].passed) == ("no_warnings", status == 0)


def test_failing_stage_leaves_a_report_and_the_last_build(make, folder, failed, monkeypatch):
    monkeypatch.chdir(folder.parents[1])
    make(fakes())
    before = files_of(folder)
    error = AssemblyError("the assembly has no mates", where="Arm", hint="add mates", problems=(WARNING,))
    with pytest.raises(AssemblyError, match="no mates") as caught:
        make(fakes(graph={"error": error, "version": 2}))
    assert render(caught.value).splitlines()[-1] == "  report: out/arm.failed/report.html"
    assert files_of(folder) == before
    assert sorted(files_of(failed)) == RUN_FILES
    report = report_in(failed)
    assert (report["status"], report["exit_status"], report["error"]["where"]) == ("failed", 1, "Arm")
    assert report["error"]["problems"][0]["code"] == "W-LIMIT"
    assert [stage["name"] for stage in report["stages"]] == ["fetch"]
    assert "the assembly has no mates" in (failed / "build.log").read_text()
    make(fakes())
    assert not failed.exists()


def test_failed_build_shows_earlier_stages(make, failed):
    graph = {"files": {"robot.json": b"{}", **SHOWN}}
    with pytest.raises(AssemblyError):
        make(fakes(graph=graph, mesh={"error": AssemblyError("no <mesh>", hint="mend it")}))
    page = (failed / "report.html").read_text()
    for words in ("<svg>arm</svg>", "└─ elbow", "no &lt;mesh&gt;", "mend it"):
        assert words in page
    with pytest.raises(ZeroDivisionError):
        make(fakes(mesh={"error": ZeroDivisionError("oops")}))
    assert "Traceback" in (failed / "build.log").read_text()


def test_problems_before_the_first_stage_come_together(make, folder, tmp_path):
    wrong = {name: {"wrong": ConfigError(f"no {name}", name)} for name in ("fetch", "mesh")}
    with pytest.raises(ConfigError):
        make(fakes(**wrong))
    assert list(tmp_path.iterdir()) == []
    folder.mkdir(parents=True)
    (folder / "config.yaml").write_text("x")
    with pytest.raises(ConfigError) as caught:
        make(fakes(**wrong))
    assert [problem.where for problem in caught.value.problems] == ["fetch", "mesh", "output"]
    with pytest.raises(ConfigError, match="holds the source"):
        make(fakes(), source={"kind": "bundle", "path": str(folder / "config.yaml")})


@pytest.mark.parametrize(
    ("name", "until"), [("arm.urdf", "validate"), ("report.json", "export"), ("build.log", "fetch")]
)
def test_file_in_the_way_stops_a_build_before_its_stages(make, folder, name, until):
    place = folder.with_name("arm.fetch") if until == "fetch" else folder
    place.mkdir(parents=True)
    manifest.write(place, {})
    (place / name).write_text("x")
    stages = fakes()
    with pytest.raises(ConfigError, match=f"{name} is not linkwright's"):
        make(stages, until=until)
    assert stages[0].runs == 0
    assert sorted(files_of(folder.parent)) == [f"{place.name}/{manifest.NAME}", f"{place.name}/{name}"]
    assert make(stages, until=until, overwrite=True).exit_status == 0
    assert (place.with_name(f"{place.name}.replaced") / name).read_text() == "x"


def test_user_file_is_carried_over_or_ends_the_build(make, folder, failed):
    make(fakes())
    (folder / "NOTES.md").write_text("mine")
    make(fakes())
    assert (folder / "NOTES.md").read_text() == "mine"
    assert "kept, since not linkwright's: NOTES.md\n" in (folder / "build.log").read_text()
    (folder / "assets" / "b.stl").write_text("mine")
    more = {"files": {FILES + "arm.urdf": b"<new/>", FILES + "assets/b.stl": b"solid"}, "version": 2}
    with pytest.raises(InTheWay, match=r"assets/b\.stl is not linkwright's"):
        make(fakes(export=more))
    for place, data, model in ((folder, b"mine", b"<robot/>"), (failed, b"solid", b"<new/>")):
        assert ((place / "assets/b.stl").read_bytes(), (place / "arm.urdf").read_bytes()) == (data, model)
    assert report_in(failed)["exit_status"] == 1
    make(fakes(export=more), overwrite=True)
    assert (folder / "assets" / "b.stl").read_text() == "solid"
    assert not failed.exists()


def test_failure_is_raised_also_without_its_report(make, failed, capsys):
    failed.mkdir(parents=True)
    (failed / "build.log").write_text("mine")
    assert make(fakes()).exit_status == 0
    with pytest.raises(AssemblyError, match="no mates"):
        make(fakes(graph={"error": AssemblyError("no mates"), "version": 2}), Lines(sys.stdout))
    assert "no report of this failure could be written" in capsys.readouterr().out
    assert files_of(failed) == {"build.log": b"mine"}


def test_progress_hears_each_stage_and_is_closed(make):
    class Ears:
        def __init__(self):
            self.heard = []

        def __getattr__(self, name):
            return lambda *words: self.heard.append((name, *(getattr(word, "name", word) for word in words)))

    ears = Ears()
    with pytest.raises(AssemblyError):
        make(fakes(graph={"error": AssemblyError("no")}), ears)
    lines = [
        [("start", name), ("detail", name, f"at work on {name}"), ("transient", name, f"some of {name}")]
        for name in ("fetch", "graph")
    ]
    assert ears.heard == [*lines[0], ("done", "fetch"), *lines[1], ("close",)]


def test_secret_reaches_neither_log_nor_files(make, folder, failed):
    with pytest.raises(AssemblyError):
        make(fakes(fetch={"error": AssemblyError("refused s3cr3t-value")}), environ=SECRET)
    assert "refused ***" in (failed / "build.log").read_text()
    assert not [name for name, data in files_of(failed).items() if b"s3cr3t-va" in data]
    make(fakes())
    before = files_of(folder)
    # It came from the cache, where it was kept before the key was known.
    shown = {"robot.json": b"{}", "outline.txt": b"arm: s3cr3t-va...", "tables.json": b"[]"}
    held = {FILES + "arm.urdf": b"<robot>\n<!-- s3cr3t-value -->"}
    stages = fakes(graph={"files": shown, "version": 2}, export={"files": held, "version": 2})
    make(stages, output=str(folder.with_name("other")))
    with pytest.raises(SecretFound) as caught:
        make(stages, environ=SECRET)
    assert caught.value.where == "arm.urdf, line 2"
    assert files_of(folder) == before
    assert not [name for name, data in files_of(failed).items() if b"s3cr3t-va" in data]
    assert report_in(failed)["error"]["type"] == "SecretFound"


@pytest.mark.parametrize(("name", "title"), [(f"onshape_{'c' * 8}", "Left arm"), ("arm", "")])
def test_robot_without_a_name_has_its_assembly_as_title(make, name, title):
    stages = fakes(fetch={"more": {"source": {"title": "Left arm"}}})
    report = make(stages, source={"kind": "onshape", "url": URL}, name=name)
    assert (report.title, report.name, report.source["url"]) == (title, name, URL)


def test_a_key_that_others_can_read_gets_a_remark(make, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / ".env").write_text("ONSHAPE_ACCESS_KEY=acc355-key\nONSHAPE_SECRET_KEY=s3cr3t-key\n")
    for mode, codes in ((0o644, ["I-DOTENV", "W-LIMIT"]), (0o600, ["W-LIMIT"])):
        (tmp_path / ".env").chmod(mode)
        report = make(fakes(), source={"kind": "onshape", "url": URL})
        assert [diagnostic.code for diagnostic in report.diagnostics] == codes
    assert [diagnostic.code for diagnostic in make(fakes()).diagnostics] == ["W-LIMIT"]


@pytest.mark.parametrize("key", ["e", "linkwright-report", '{"status"'])
def test_a_report_stays_whole_and_ours_whatever_the_key_is(make, folder, key):
    environ = {"ONSHAPE_ACCESS_KEY": key, "ONSHAPE_SECRET_KEY": key}
    report = make(fakes(), environ=environ)
    assert set(report_in(folder)) == {"linkwright-report", *asdict(report)} - {"narrow_outline"}
    assert make(fakes(), environ=environ).exit_status == 0


def test_build_and_its_report_can_be_sent_to_another_process(make):
    assert pickle.loads(pickle.dumps(build)) is build
    report = make(fakes())
    assert pickle.loads(pickle.dumps(report)) == report


def test_robot_json_before_the_export_follows_the_keys_of_the_scene(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    body = '<body><joint name="hinge" axis="0 1 0"/><geom size=".1"/></body>'
    loose_body = '<body name="box" pos="1 0 0"><freejoint/><geom size=".1"/></body>'
    actuator = '<actuator><motor joint="hinge"/></actuator>'
    text = f"<mujoco><worldbody>{body}{loose_body}</worldbody>{actuator}</mujoco>"
    (tmp_path / "arm.xml").write_text(text)
    command = ["source=mjcf", "source.path=arm.xml", "until=graph", "cache.dir=cache"]
    for choice, keeps_box in (("keep", True), ("drop", False)):
        plan = compose_plan([*command, f"scene.surroundings={choice}"]).plan
        robot = build_files(plan, in_memory=True).files["robot.json"]
        assert (b'"box"' in robot) == keeps_box
