"""Checkers of other makers: found on PATH, run on a copy, their words as checks. Stand-ins play them."""

import json
import os
import stat
import sys
from pathlib import Path
from typing import get_args

import pytest

from linkwright.stages.robot.errors import ConfigError
from linkwright.stages.validate import external
from linkwright.stages.validate.external import TOOLS, check_externally, gave_no_verdict, require, versions
from linkwright.stages.validate.external import run as runs
from linkwright.stages.validate.section import ValidateSection
from tests.support.command import called, environment

FINDINGS = [
    {"check": "inertia.mass", "severity": "error", "message": "no mass", "target": "hand"},
    {"check": "joints.drive", "severity": "warning", "message": "weak", "target": "wrist"},
    {"check": "joints.mimic", "severity": "info", "message": "mimics", "target": "thumb"},
]
SIMCHECK = {"asset": "arm.urdf", "verdict": "FAIL", "score": 70.0, "results": [{"findings": FINDINGS}]}

REMARKS = [
    {"level": "ERROR", "code": "nan", "subject": "elbow", "message": "it explodes"},
    {"level": "WARN", "code": "soft", "subject": "<global>", "message": "it is soft"},
    {"level": "INFO", "code": "stock", "subject": "<global>", "message": "it is stock"},
]
DOCTOR = [{"file": "scene.xml", "errors": 1, "warnings": 1, "findings": REMARKS}]

FEATURES = {
    "FET_001_STANDARD": {
        "passed": False,
        "blocking_failure": True,
        "failing requirements": "['com.nvidia.usd.VG.027', 'com.nvidia.simready.VG.008']",
        "requirement_messages": '{"com.nvidia.usd.VG.027": ["no normals", "no normals"]}',
    },
    "FET_003_STANDARD": {"passed": True, "blocking_failure": False},
    "FET_006_MDL": {"passed": False, "blocking_failure": False, "optional requirements": "['VM.MDL']"},
}
OPTIONAL = {name: row for name, row in FEATURES.items() if "001" not in name}


def report_of(features):
    """Lines that write the report of simready-validate."""
    profile = {"profile_id": "Robot-Body", "profile_version": "3.0.0", "features_summary": features}
    report = {"/somewhere/arm.usda": profile}
    return f"json.dump({report!r}, open(sys.argv[sys.argv.index('--output') + 1], 'w'))"


VALIDATOR = {
    "overall_status": "FAIL",
    "schema": {"status": "FAIL", "critical_issues": ["[SCHEMA] no root"], "warnings": []},
    "critical_issues": ["[INERTIA] link 'hand': negative"],
    "warnings": ["[INERTIA] link 'base': diverges"],
}


def stand_in(folder, program, code, version="1.2.3"):
    """A program that says its version, and else runs some lines of Python."""
    path = folder / program
    path.parent.mkdir(parents=True, exist_ok=True)
    lines = [
        f"#!{sys.executable}",
        "import json, os, sys, time",
        f"if sys.argv[1:] == ['--version']: print('{program} {version}'); sys.exit(0)",
        code,
    ]
    path.write_text("\n".join(lines) + "\n")
    path.chmod(path.stat().st_mode | stat.S_IXUSR)


@pytest.fixture
def path(tmp_path):
    """An environment in which the stand-ins of all are found."""
    tools = tmp_path / "bin"
    stand_in(tools, "simcheck", f"print(json.dumps([{SIMCHECK!r}]))")
    stand_in(tools, "mjcf-doctor", f"print('hello'); print(json.dumps({DOCTOR!r}, indent=2))")
    where = "os.path.join(sys.argv[sys.argv.index('--output-dir') + 1], 'arm_validation.json')"
    stand_in(tools, "urdf_validate", f"json.dump({VALIDATOR!r}, open({where}, 'w'))\nsys.exit(2)")
    stand_in(tools, "simready-validate", f"{report_of(FEATURES)}\nsys.exit(1)")
    return {"PATH": str(tools), "ONSHAPE_SECRET_KEY": "s3cret"}


@pytest.fixture
def folder(tmp_path):
    made = tmp_path / "made"
    made.mkdir()
    for name in ("arm.urdf", "arm.xml", "scene.xml", "arm.usda"):
        (made / name).write_text("<robot/>")
    return made


def test_key_knows_the_tools():
    (literal, _) = get_args(ValidateSection.model_fields["external"].annotation)
    assert set(get_args(literal)) == set(TOOLS) == set(runs.TOOL_USES)


def test_what_each_says_is_a_check_of_its_own(folder, path):
    checks = {check.name: check for check in check_externally(folder, "arm", list(TOOLS), path)}
    assert [*checks] == [
        "arm.urdf: simcheck 1.2.3",
        "arm.xml: simcheck 1.2.3",
        "scene.xml: mjcf-doctor 1.2.3",
        "arm.urdf: urdf_validate 1.2.3",
        "arm.usda: simready-validate 1.2.3",
    ]
    simcheck, _, doctor, validator, simready = checks.values()
    assert (simcheck.fails, simcheck.value) == (True, 1.0)
    assert "FAIL, score 70; 1 error, 1 warning: no mass" in simcheck.detail
    assert [finding.element for finding in simcheck.findings] == ["hand", "wrist"]
    assert [finding.element for finding in doctor.findings] == ["elbow", "<global>"]
    assert doctor.fails
    assert [finding.element for finding in validator.findings] == ["hand", "", "base"]
    assert validator.value == 2.0
    assert (simready.fails, simready.value) == (True, 2.0)
    words = "Robot-Body 3.0.0, 1 of 3 features; not met, and optional: FET_006_MDL; 2 errors, 0 warnings: "
    assert simready.detail == f"{words}no normals, and 1 more (com.nvidia.usd.VG.027)"
    assert [finding.message for finding in simready.findings][1:] == ["not met (com.nvidia.simready.VG.008)"]


SOFT = [{"file": "scene.xml", "findings": REMARKS[1:2]}]
NO_RESULT = "print('Asset: x\\n  [ERROR] Validation produced no result for profile'); sys.exit(1)"


@pytest.mark.parametrize(
    ("tool", "code", "level", "words"),
    [
        ("simready", report_of(OPTIONAL), "",
         "Robot-Body 3.0.0, 1 of 2 features; not met, and optional: FET_006_MDL;"),
        ("simready", NO_RESULT, "none", "no verdict: [ERROR] Validation produced no result for profile"),
        ("simready", "sys.exit(1)", "none", "simready-foundation-tier-core"),
        ("mjcf_doctor", f"print(''); print(json.dumps({SOFT!r}, indent=2))", "warning", "it is soft"),
        ("simcheck", f"print(json.dumps([{SIMCHECK | {'results': []}!r}]))", "", ""),
        ("simcheck", "sys.exit(1)", "none", "no verdict"),
        ("simcheck", "print('[]')", "none", "no verdict"),
        ("simcheck", "print('oops')", "none", "no verdict"),
        ("simcheck", "os.abort()", "none", "no verdict"),
        ("simready", "json.dump([1], open(sys.argv[sys.argv.index('--output') + 1], 'w'))", "none",
         "no verdict: its output cannot be read (AttributeError)"),
    ],
    ids=range(10),
)  # fmt: skip
def test_verdict_is_that_of_the_report(folder, path, tmp_path, tool, code, level, words):
    """ "none": no verdict, which is an error."""
    stand_in(tmp_path / "bin", TOOLS[tool].program, code)
    for check in check_externally(folder, "arm", [tool], path):
        assert (check.passed, check.warns) == (level == "", level == "warning")
        assert words in check.detail
        assert gave_no_verdict(check) == (level == "none")


def test_tool_works_on_a_copy_and_sees_no_secret(folder, path, tmp_path):
    seen = tmp_path / "seen"
    facts = "[dict(os.environ), os.getcwd(), os.listdir(), sys.path, sys.argv[1:]]"
    code = f"open(sys.argv[2], 'w').write('changed')\njson.dump({facts}, open({str(seen)!r}, 'w'))\n"
    stand_in(tmp_path / "bin", "simcheck", f"{code}print(json.dumps([{SIMCHECK!r}]))")
    (folder / "arm.srdf").write_text("<robot/>")
    (folder / "arm.xml").unlink()
    check_externally(folder, "arm", ["simcheck"], path)
    environ, where, files, modules, arguments = json.loads(seen.read_text())
    assert (folder / "arm.urdf").read_text() == "<robot/>"
    assert Path(where) != folder
    assert not any("s3cret" in value for value in environ.values())
    assert files == []
    assert not {where, "", str(Path(arguments[1]).parent)} & set(modules)
    assert [Path(word).name for word in arguments[:2]] == ["check", "arm.urdf"]
    assert [Path(word).name for word in arguments[-2:]] == ["--srdf", "arm.srdf"]
    assert not Path(where).exists()


def test_paths_in_what_a_tool_says_start_in_the_robots_folder(folder, path, tmp_path):
    code = "report = json.loads(" + repr(json.dumps(SIMCHECK)) + ")\nreport['verdict'] = sys.argv[2]\n"
    stand_in(tmp_path / "bin", "simcheck", code + "print(json.dumps([report]))")
    check = check_externally(folder, "arm", ["simcheck"], path)[0]
    assert check.detail.startswith("arm.urdf, score")


def test_no_program_of_the_working_folder_is_a_checker(folder, tmp_path, monkeypatch):
    (tmp_path / "bin").mkdir()
    monkeypatch.chdir(tmp_path / "bin")
    stand_in(tmp_path / "bin", "simcheck", f"print(json.dumps([{SIMCHECK!r}]))")
    for places in ("", ".", os.pathsep, f"..{os.sep}bin"):
        assert TOOLS["simcheck"].command({"PATH": places}) in (None, (sys.executable, "-P", "-m", "simcheck"))
    assert TOOLS["simcheck"].command({"PATH": str(tmp_path / "bin")}) == (str(tmp_path / "bin" / "simcheck"),)


def test_tool_that_does_not_end_is_ended(folder, path, tmp_path, monkeypatch):
    monkeypatch.setattr(runs, "MAX_SECONDS", 0.5)
    stand_in(tmp_path / "bin", "mjcf-doctor", "time.sleep(60)")
    (check,) = check_externally(folder, "arm", ["mjcf_doctor"], path)
    assert "longer than 0.5 s" in check.detail
    assert gave_no_verdict(check)


def test_model_without_a_scene_is_looked_at_itself(folder, path):
    (folder / "scene.xml").unlink()
    (check,) = check_externally(folder, "arm", ["mjcf_doctor"], path)
    assert check.name == "arm.xml: mjcf-doctor 1.2.3"


def test_version_is_what_the_program_says_or_is_of_its_bytes(path, tmp_path):
    assert versions(list(TOOLS), path) == dict.fromkeys(TOOLS, "1.2.3")
    other = tmp_path / "other"
    stand_in(other, "simcheck", "", version="2.0.0")
    assert versions(["simcheck"], {"PATH": str(other)}) == {"simcheck": "2.0.0"}
    silent = []
    for text in ("this", "that"):
        program = tmp_path / text / "simcheck"
        program.parent.mkdir()
        program.write_text(f"#!/bin/sh\n# {text}\nexit 3\n")
        program.chmod(0o755)
        silent.append(versions(["simcheck"], {"PATH": str(program.parent)})["simcheck"])
    assert silent[0]
    assert silent[0] != silent[1] or external.TOOLS["simcheck"].command({"PATH": ""}) is not None


def test_one_that_is_not_installed_is_an_error_that_says_how_to(monkeypatch):
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(ConfigError) as caught:
        require(["simcheck", "urdf_validator"], ["urdf"], {"PATH": ""})
    assert "simcheck and urdf_validate are not installed" in str(caught.value)
    assert "pip install simcheck urdf-validator" in str(caught.value.hint)
    require([], ["urdf"], {"PATH": ""})


@pytest.mark.parametrize(("python", "fits"), [((3, 11), True), ((3, 12), True), ((3, 13), False)])
def test_one_that_needs_another_python_says_which(monkeypatch, python, fits):
    monkeypatch.setattr(sys, "version_info", (*python, 0, "final", 0))
    with pytest.raises(ConfigError) as caught:
        require(["simready"], ["usd"], {"PATH": ""})
    assert "simready-validate is not installed" in str(caught.value)
    hint = str(caught.value.hint)
    assert "pip install simready-validate simready-foundation-tier-core" in hint
    assert ("needs an environment of Python 3.11 or 3.12; this is 3.13" in hint) != fits
    assert ("needs" in hint) != fits


@pytest.mark.parametrize("name", list(TOOLS))
def test_one_that_reads_no_format_of_the_build_is_an_error(path, name):
    reads = TOOLS[name].reads
    with pytest.raises(ConfigError, match=f"{name} reads {' or '.join(reads)}") as caught:
        require([name], ["sdf"], path)
    assert f"export=[sdf,{reads[0]}]" in str(caught.value.hint)
    for form in reads:
        require([name], ["sdf", form], path)


def test_build_asks_before_it_begins(tmp_path):
    if external.TOOLS["simcheck"].command({"PATH": ""}) is not None:
        pytest.skip("simcheck is a module of this Python")
    environ = environment(tmp_path, PATH="/nowhere")
    done = called(tmp_path, "robot=sample", "validate.external=[simcheck]", environ=environ, status=2)
    assert "pip install simcheck" in done.stdout + done.stderr
    assert not (tmp_path / "outputs").exists()
