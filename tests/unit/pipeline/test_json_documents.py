"""`--json`: one document on the standard output, as its schema says, whatever happens."""

import importlib
import json
import pkgutil
from pathlib import Path

import jsonschema
import pytest

from linkwright.pipeline import json_documents
from linkwright.pipeline.cli import run
from linkwright.pipeline.errors import exit_status
from linkwright.pipeline.json_documents.build import ROLES
from linkwright.pipeline.json_documents.document import CommandDocument
from linkwright.pipeline.output.manifest import DOCUMENTS as DOCUMENTS_OF_A_BUILD
from linkwright.pipeline.reference import schemas
from linkwright.pipeline.report import Report
from linkwright.pipeline.verbs import VERBS
from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.robot.errors import AssemblyError, ConfigError, Diagnostic, NotFound
from tests.config.command_json import DOCUMENTS, name_of
from tests.support.command import called, environment, linkwright
from tests.support.processes import python
from tests.support.stand_in_builds import ended

WITHOUT = {"snapshot", "view"}
"""Verbs without `--json`."""


def parsed(text):
    """The document that is the whole text, after its schema has been applied."""
    document = json.loads(text, parse_constant=lambda word: pytest.fail(word))
    name = document["format"].removeprefix("linkwright-")
    schema = json.loads(schemas()[name].read_text())
    jsonschema.validate(document, schema, jsonschema.Draft202012Validator)
    assert document.keys() <= schema["properties"].keys()
    return document


@pytest.fixture
def printed(capfd, tmp_path, monkeypatch):
    """The document that a command prints in an empty folder, and its messages."""
    monkeypatch.chdir(tmp_path)

    def of(*arguments, build=None):
        status = run(arguments, build)
        out, err = capfd.readouterr()
        document = parsed(out)
        assert document["exit_status"] == status
        return document, err

    return of


def test_each_document_has_a_schema_and_each_schema_a_document():
    for module in pkgutil.iter_modules(json_documents.__path__):
        importlib.import_module(f"{json_documents.__name__}.{module.name}")
    assert set(CommandDocument.__subclasses__()) == set(DOCUMENTS)
    assert schemas().keys() == {name_of(document) for document in DOCUMENTS}
    assert tuple(ROLES.values()) == DOCUMENTS_OF_A_BUILD
    for path in schemas().values():
        jsonschema.Draft202012Validator.check_schema(json.loads(path.read_text()))


REPORT = Report(
    "invalid", "arm", "outputs/arm", "validate", 3,
    figures={"mass": 2.5, "steps_per_second": float("inf")},
    diagnostics=(
        *(Diagnostic("W-LIMIT", f"no limits: {n}", f"joint_{n}", "type them\njoints: {}") for n in (0, 1)),
        *(Diagnostic("W-FLAT", f"flat {n}", f"link_{n}") for n in range(9)),
        Diagnostic("I-BASE", "the base is fixed"),
    ),
    checks=(
        Check("arm.urdf: mass", passed=True, detail="equal", code="C-MASS"),
        Check("start", passed=False, detail="falls", code="C-START", findings=(Finding("body", "", "x"),)),
        Check("home", passed=False, detail="near", code="C-CLOSED", level="warning"),
    ),
    outputs={"robot.json": "0", "arm.urdf": "1", "assets/a.stl": "2"},
    preview="preview.png",
)  # fmt: skip


def test_a_build_tells_what_a_program_decides_by(printed):
    document, _ = printed("--json", "source=sample", build=lambda plan: REPORT)
    assert (document["format"], document["version"], document["status"]) == ("linkwright-build", 1, "invalid")
    assert document["paths"]["report"] == str(Path("outputs/arm", "report.json"))
    assert document["files"] == ["robot.json", "arm.urdf"]
    assert document["figures"] == {"mass": 2.5, "steps_per_second": None}
    assert document["checks"] == {"passed": 1, "warned": 1, "failed": 1}
    assert [(check["code"], check["level"]) for check in document["problems"]] == [
        ("C-START", "error"), ("C-CLOSED", "warning"),
    ]  # fmt: skip
    assert all(check["hint"] for check in document["problems"])
    assert document["counts"] == {"error": 0, "warning": 11, "info": 1}
    assert [finding["code"] for finding in document["diagnostics"]] == ["W-LIMIT"] * 2 + ["W-FLAT"] * 3


@pytest.mark.parametrize(("error", "status", "count"), [
    (ConfigError("is wrong", "source.url", "change it"), 2, 0),
    (NotFound("there is no such document", "https://x", "open it in a browser"), 1, 0),
    (AssemblyError("9 problems", problems=[Diagnostic("E-MASS", f"{n}", "p") for n in range(9)]), 1, 9),
    (KeyboardInterrupt(), 130, 0), (ZeroDivisionError("by zero"), 1, 0),
    (PermissionError(13, "Permission denied", "outputs"), 1, 0),
], ids=lambda value: type(value).__name__ if isinstance(value, BaseException) else str(value))  # fmt: skip
def test_an_error_is_a_document_and_the_usual_message(printed, error, status, count):
    def failing(plan):
        error.add_note("report: outputs/arm.failed/report.html")
        raise error

    document, err = printed("--json", "source=sample", build=failing)
    assert (document["exit_status"], document["count"], document["verb"]) == (status, count, "build")
    assert document["type"] == type(error).__name__
    assert document["message"]
    assert "error: " in err
    if count:
        assert len(document["problems"]) == 3
        assert len(printed("--json", "-v", "source=sample", build=failing)[0]["problems"]) == count
    if status in (1, 2):
        assert document["notes"][0] == "report: outputs/arm.failed/report.html"
    assert status == exit_status(error)


@pytest.mark.parametrize("verb", VERBS)
def test_wrong_usage_of_each_verb_is_a_document(printed, verb):
    document, err = printed(verb, "--json", "--nope")
    assert (document["format"], document["exit_status"], document["verb"]) == ("linkwright-error", 2, verb)
    assert err.startswith("error: ")


def test_a_verb_without_documents_refuses_the_option(printed):
    for verb in WITHOUT:
        document, _ = printed(verb, "--json")
        assert "--json" in document["message"], verb


@pytest.mark.parametrize(("arguments", "message"), [
    (["--json", "--nope"], "there is no option --nope"), (["--json", "--cfg", "job"], "--json belongs to"),
    (["-q", "-v", "--json"], "-q and -v exclude each other"),
])  # fmt: skip
def test_wrong_options_are_a_document(printed, arguments, message):
    document, _ = printed(*arguments)
    assert document["message"].startswith(message)
    assert (document["type"], document["exit_status"]) == ("UsageError", 2)
    assert document["hint"]


def test_help_is_no_document(capsys):
    for arguments in (["--json", "--help"], ["doctor", "--json", "--help"]):
        assert run(arguments) == 0
        assert capsys.readouterr().out.startswith("linkwright")


def test_other_output_goes_to_the_standard_error(tmp_path):
    """Also that of C libraries and of child processes."""
    code = """
import os, subprocess, sys
from linkwright.pipeline import cli
from tests.unit.pipeline.test_json_documents import REPORT
def build(plan):
    print("a plug-in prints", flush=True)
    os.write(1, b"a library writes\\n")
    subprocess.run([sys.executable, "-c", "print('a child writes')"], check=True)
    return REPORT
sys.exit(cli.run(["--json", "source=sample"], build))
"""
    done = python("-c", code, cwd=tmp_path)
    assert parsed(done.stdout)["name"] == "arm"
    assert {"a plug-in prints", "a library writes", "a child writes"} <= {*done.stderr.splitlines()}


def test_keys_and_control_characters_do_not_reach_the_output(printed, monkeypatch):
    monkeypatch.setenv("ONSHAPE_SECRET_KEY", "s" * 48)
    text = f"part \x1b[2J\u202e {'s' * 48} é"

    def failing(plan):
        raise AssemblyError(text, where=text)

    document, err = printed("--json", "source=sample", build=failing)
    assert document["message"] == "part \x1b[2J\u202e *** é"
    assert "s" * 48 not in err + json.dumps(document)


def test_a_sweep_lists_its_jobs(printed):
    def build(plan):
        if plan.root.base == "free":
            raise AssemblyError("has no mates")
        return ended(plan, figures={"mass": 1.0})

    arguments = ("-m", "--json", "source=sample", "root=fixed,free")
    document, _ = printed(*arguments, build=build)
    assert (document["format"], document["exit_status"]) == ("linkwright-sweep", 1)
    assert document["counts"] == {"built": 1, "failed": 1}
    assert [job["message"] for job in document["jobs"]] == ["valid", "has no mates"]
    assert document["jobs"][0]["figures"] == {"mass": 1.0}
    assert Path(document["folder"], "summary.json").is_file()


def test_a_list_of_jobs_is_written_run_and_told(printed):
    arguments = ("-m", "--json", "robot=sample", "until=fetch", "root=fixed,free", "--plan", "jobs.json")
    document, _ = printed(*arguments)
    assert (document["format"], document["size"], document["jobs"]) == ("linkwright-jobs", 2, [])
    assert printed("jobs", "jobs.json", "--json")[0]["counts"] == {"missing": 2}
    assert printed("jobs", "jobs.json", "--fetch", "--json")[0]["failures"] == []
    document, _ = printed("job", "jobs.json", "1", "--json")
    assert document["counts"] == {"built": 1}
    document, _ = printed("jobs", "jobs.json", "-q", "--json")
    assert (document["counts"], document["exit_status"]) == ({"missing": 1, "built": 1}, 1)


@pytest.mark.parametrize(("name", "kind", "keys"), [
    ("W-LIMIT", "code", {"hint", "level", "stages"}), ("C-MASS", "code", {"level"}),
    ("joints.elbow.damping", "key", {"type", "unit", "default", "allowed", "example"}),
    ("mesh", "key", {"keys"}), ("validate.level", "key", {"words"}), ("sts3215", "motor", {"values"}),
    ("LINKWRIGHT_CACHE", "variable", set()), ("hydra/launcher=slurm", "launcher", {"keys"}),
])  # fmt: skip
def test_an_explanation_has_what_the_text_has(printed, name, kind, keys):
    document, _ = printed("explain", name, "--json")
    (entry,) = document["entries"]
    assert entry["kind"] == kind
    assert keys <= entry.keys()
    assert entry["meaning"]


def test_a_schema_is_found_by_its_name(printed, capfd):
    for name in ("robot", "robot_json", *schemas()):
        document, _ = printed("explain", "--schema", name, "--json")
        assert Path(document["entries"][0]["path"]).is_file()
        assert run(["explain", "--schema", name]) == 0
        assert capfd.readouterr().out.strip() == document["entries"][0]["path"]
    assert printed("explain", "--schema", "nope", "--json")[0]["exit_status"] == 2


@pytest.mark.e2e
def test_a_real_build_its_bundle_and_its_cache(tmp_path):
    environ = environment(tmp_path)
    done = linkwright(tmp_path, "--json", "until=graph", environ=environ, status=0)
    assert "graph" in done.stderr
    document = parsed(done.stdout)
    report = json.loads((tmp_path / document["paths"]["report"]).read_bytes())
    for key in ("status", "name", "exit_status", "figures", "calls", "source", "until", "folder"):
        assert document[key] == report[key], key
    again = parsed(called(tmp_path, "--json", "until=graph", "-q", environ=environ, status=0).stdout)
    assert again == document
    bundle = called(tmp_path, "bundle", document["folder"], "a.zip", "--json", environ=environ)
    assert parsed(bundle.stdout)["size"] == (tmp_path / "a.zip").stat().st_size
    for verb, key in (("info", "info"), ("verify", "verified"), ("gc", "cleared")):
        cache = parsed(called(tmp_path, "cache", verb, "--json", environ=environ, status=0).stdout)
        assert cache[key]
        assert [cache[other] for other in ("info", "verified", "cleared") if other != key] == [None, None]
    failed = called(tmp_path, "--json", "until=graph", "root.select=nope", environ=environ, status=1)
    assert parsed(failed.stdout)["notes"][-1].startswith("report: ")
