"""`linkwright check`: files are compared with robot.json alone, and what is wrong is told in every form."""

import json
import re
import shutil
import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path
from unittest.mock import patch

import pytest

from linkwright.pipeline.checking import ask, wire
from linkwright.pipeline.checking.as_document import as_document, baseline
from linkwright.pipeline.checking.junit import as_junit
from linkwright.pipeline.checking.lines import ElementLines
from linkwright.pipeline.checking.run import checked
from linkwright.pipeline.checking.sarif import as_sarif
from linkwright.pipeline.checking.show import as_text
from linkwright.pipeline.checking.verdict import Verdict
from linkwright.pipeline.cli import run
from linkwright.pipeline.errors import OutputError
from linkwright.pipeline.json_documents.document import text_of
from linkwright.pipeline.reference.codes import remedy
from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.robot.model.robot import Dynamics, Limits
from linkwright.stages.robot.system import guest
from linkwright.stages.validate.checks import MODEL_CHECKS
from tests.support.building import plan_of, write
from tests.support.robots import at, joint, robot_with

EXCLUDE = '<contact><exclude body1="base" body2="hand"/></contact>'
LIMITS = {"arm_joint": Limits(-1.0, 1.0)}


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """The files of a robot of two joints, and nothing else of a build."""
    rows = [
        joint("revolute", "base", "arm", [0.1], limits=LIMITS, dynamics=Dynamics(0.1, 0.1, 0.01, 5, 2)),
        joint("prismatic", "arm", "hand", place=at(0, 0, 0.2), limits={"hand_joint": Limits(0.0, 0.1)}),
    ]
    folder = tmp_path_factory.mktemp("check") / "robot"
    write(robot_with(rows), folder, plan_of(export={"urdf": {}, "mjcf": {}, "sdf": {}}))
    return folder


@pytest.fixture
def folder(built, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shutil.copytree(built, tmp_path / "robot")
    return Path("robot")


def changed(file, change):
    before = file.read_text()
    file.write_text(change(before))
    assert file.read_text() != before


def heavier(file):
    """The last mass of a file, 1 % off."""
    match = list(re.finditer(r'mass(?: value)?="([0-9.]+)"', file.read_text()))[-1]
    mass = repr(float(match[1]) * 1.01)
    changed(file, lambda text: text[: match.start(1)] + mass + text[match.end(1) :])


@pytest.fixture
def output(capsys):
    """What `linkwright check` prints, where it ends with this status."""

    def of(status, *arguments):
        capsys.readouterr()
        assert run(["check", *map(str, arguments)]) == status
        return capsys.readouterr().out

    return of


def test_files_as_they_were_written_pass(folder, output):
    assert not (folder / "report.json").exists()
    out = output(0, folder)
    assert re.fullmatch(r"(\d+) of \1 checks passed", out.strip().splitlines()[-1])
    assert "FAILED" not in out
    assert "checks passed" in output(0, folder / "robot.sdf")


@pytest.mark.usefixtures("guests_at_home")
@pytest.mark.parametrize("name", ["robot.urdf", "robot.xml"])
def test_a_wrong_mass_is_found_in_the_file_that_has_it(folder, name, output):
    heavier(folder / name)
    whole = json.loads(output(3, "--json", folder))
    assert whole["passed"] is False
    wrong = [check for check in whole["checks"] if not check["passed"] and check["level"] == "error"]
    assert "C-MASS" in {check["code"] for check in wrong}
    assert {check["file"] for check in wrong} == {name}
    (mass,) = [check for check in wrong if check["name"] == f"{name}: mass"]
    assert mass["value"] == pytest.approx(0.01, rel=1e-6)
    assert mass["hint"] == remedy("C-MASS")
    for file in ("robot.json", "scene.xml", "robot.urdf", "robot.xml"):
        assert run(["check", str(folder / file)]) == (3 if file in (name, "robot.json") else 0), file


def test_a_usd_is_read_within_the_limits(tmp_path, output):
    """usd-core reserves more addresses than all memory that a check may take."""
    pytest.importorskip("pxr")
    robot = robot_with([joint("revolute", "base", "arm", [0.1])])
    write(robot, tmp_path / "robot", plan_of(export={"usd": {}}))
    assert "checks passed" in output(0, tmp_path / "robot")


@pytest.mark.usefixtures("guests_at_home")
def test_a_file_that_is_gone_is_missed(folder, output):
    (folder / "robot.sdf").unlink()
    (folder / "scene.xml").unlink()
    out = output(3, folder)
    assert "FAILED C-PRESENT robot.json: files: missing: robot.sdf, scene.xml (2, at most 0)" in out
    assert '    file "scene.xml": robot.json lists this file, but it does not exist' in out
    assert f"    → {remedy('C-PRESENT')}" in out


def test_what_a_check_breaks_over_is_one_check_that_fails(folder, output, monkeypatch):
    def breaks(compiled):
        yield compiled.result("first", True, "well")
        raise KeyError("leg")

    broken = [replace(check, function=breaks) if check.title == "joints" else check for check in MODEL_CHECKS]
    monkeypatch.setattr("linkwright.stages.validate.checks.MODEL_CHECKS", broken)
    monkeypatch.setattr("linkwright.pipeline.verbs.check.checked", checked)
    checks = {
        check["name"]: check for check in json.loads(output(3, "--json", folder / "robot.urdf"))["checks"]
    }
    assert [name for name, check in checks.items() if not check["passed"]] == ["robot.urdf: joints"]
    assert checks["robot.urdf: joints"]["code"] == "C-JOINT"
    assert "KeyError: 'leg'" in checks["robot.urdf: joints"]["detail"]
    assert {"robot.urdf: first", "robot.urdf: motion"} <= checks.keys()


@pytest.mark.usefixtures("guests_at_home")
def test_quick_looks_whether_files_compile(folder, output):
    heavier(folder / "robot.urdf")
    output(0, "--level", "quick", folder)
    changed(folder / "robot.xml", lambda text: text.replace("<worldbody>", "<worldbodies>", 1))
    assert "FAILED C-COMPILE robot.xml: compiles" in output(3, "--level=quick", folder)


@pytest.mark.usefixtures("guests_at_home")
def test_what_is_in_the_baseline_does_not_fail(folder, output):
    heavier(folder / "robot.urdf")
    before = json.loads(output(3, "--json", folder))
    Path("known.json").write_text(json.dumps(before))
    arguments = ["--baseline", "known.json", folder]
    out = output(0, *arguments)
    assert "FAILED" not in out
    assert re.search(r"^\d+ findings? known from the baseline$", out, re.MULTILINE)
    heavier(folder / "robot.urdf")
    output(0, *arguments)  # the same by another figure
    (folder / "scene.xml").unlink()
    after = json.loads(output(3, "--json", *arguments))
    fresh = [check["code"] for check in after["checks"] if not check["passed"] and not check["known"]]
    assert fresh == ["C-PRESENT"]
    assert after["counts"]["known"] >= before["counts"]["failed"] > 0


@pytest.mark.usefixtures("guests_at_home")
def test_a_file_without_a_robot_json_is_checked_by_itself(folder, output):
    (folder / "robot.json").unlink()
    for place in (folder / "robot.urdf", folder):
        tree = json.loads(output(0, "--json", place))
        assert tree["robot"] is None
        assert "there is no robot.json" in tree["notes"][0]
        assert tree["checks"]
    changed(folder / "robot.urdf", lambda text: text.replace('lower="-1"', 'lower="3"'))
    assert 'joint "arm_joint"' in output(3, folder / "robot.urdf")
    output(0, folder / "robot.xml")
    changed(folder / "robot.urdf", lambda text: text.replace("</robot>", ""))
    output(3, folder)


@pytest.mark.usefixtures("guests_at_home")
def test_wrong_usage_and_what_cannot_be_read(folder, capsys):
    Path("empty").mkdir()
    Path("notes.txt").write_text("x")
    Path("other.json").write_text('{"format": "linkwright-diff", "version": 1}')
    Path("broken.json").write_text('{"format": "linkwright-check", "version": 1, "checks": [{}]}')
    for arguments, status, message in (
        ([], 2, "expected one folder or file, got 0"),
        (["robot", "empty"], 2, "expected one folder or file, got 2"),
        (["--yaml", "robot"], 2, "there is no option --yaml"),
        (["robot", "--level"], 2, "--level needs a value"),
        (["--level", "hard", "robot"], 2, "there is no level hard"),
        (["--sarif=a", "--sarif=b", "robot"], 2, "--sarif is there twice"),
        (["nowhere"], 1, "there is no such file or folder"),
        (["empty"], 1, "the folder has no robot.json, and no URDF or MJCF"),
        (["notes.txt"], 1, "its name does not end in any of"),
        (["--baseline", "none.json", "robot"], 1, "the baseline cannot be read"),
        (["--baseline", "notes.txt", "robot"], 1, "the baseline is not JSON"),
        (["--baseline", "other.json", "robot"], 1, "the baseline is not a linkwright-check"),
        (["--baseline", "broken.json", "robot"], 1, "checks that cannot be read"),
        (["--level=quick", "--junit", "none/x.xml", "robot"], 1, "it cannot be written"),
    ):
        assert run(["check", *arguments]) == status, arguments
        err = capsys.readouterr().err
        assert message in err, arguments
        assert "Traceback" not in err


@pytest.mark.parametrize(("change", "words"), [
    (lambda t: t["links"][1].pop("mass"), "links[1].mass: expected a number, found nothing"),
    (lambda t: t["joints"][0].update(type="hinge"), "joints[0].type: expected one of fixed"),
    (lambda t: t["joints"][0].update(parent="leg"), "do not form a tree"),
    (lambda t: t["joints"][0]["dofs"][0].update(limits=[0]), "joints[0].dofs[0].limits: expected two"),
    (lambda t: t["shapes"].append({"link": "leg"}), "shapes[0].link: there is no link 'leg'"),
    (lambda t: t.update(name="../robot"), "'../robot' is not a path below its folder"),
    (lambda t: t.update(files=["/etc/passwd"]), "'/etc/passwd' is not a path below its folder"),
    (lambda t: t.update(version=2), "its version is 2"),
    (lambda t: t.update(format="x"), "it is not a robot.json of Linkwright"),
])  # fmt: skip
def test_a_robot_json_that_is_wrong_is_named_with_its_field(folder, change, words, capsys):
    file = folder / "robot.json"
    robot = json.loads(file.read_text())
    change(robot)
    file.write_text(json.dumps(robot))
    assert run(["check", str(folder)]) == 1
    text = capsys.readouterr().err
    assert words in text
    assert "→ build again" in text


def verdict(folder):
    """One check of each kind, of a real file."""
    findings = (
        Finding('joint "arm_joint"', "range", "(-1, 2), expected (-1, 1)"),
        Finding('body "hand"', "pos", "0 0 1, expected 0 0 0.2"),
    )
    checks = (
        Check("robot.xml: joints", False, "differ", 2.0, 0.0, "C-JOINT", "error", findings),
        Check("robot.xml: motion", False, "off \x1b[31m", float("inf"), 1e-9, "C-MOTION", "warning"),
        Check("robot.urdf: mass", True, "right", 0.0, 1e-9, "C-MASS"),
        Check("robot.urdf: relations", False, "differ: gear", None, None, "C-RELATION"),
    )
    return Verdict(str(folder), str(folder), "robot", "standard", checks)


def test_the_text_names_the_elements_with_figure_and_hint(folder):
    lines = as_text(verdict(folder)).splitlines()
    at_joints = lines.index("FAILED C-JOINT robot.xml: joints: differ (2, at most 0)")
    assert lines[at_joints + 1] == '    joint "arm_joint" range: (-1, 2), expected (-1, 1)'
    assert lines[at_joints + 2] == '    body "hand" pos: 0 0 1, expected 0 0 0.2'
    assert lines[at_joints + 3] == f"    → {remedy('C-JOINT')}"
    assert lines[0].startswith("WARNING C-MOTION robot.xml: motion: off \\u001b[31m (inf, at most 1e-09)")
    assert lines[-1] == "1 of 4 checks passed"
    strict = replace(verdict(folder), level="strict")
    assert "FAILED C-MOTION" in as_text(strict)
    only = replace(verdict(folder), checks=verdict(folder).checks[1:3])
    assert only.passed
    assert not replace(only, level="strict").passed


def test_the_json_is_valid_and_a_baseline_of_its_own(folder):
    text = text_of(as_document(verdict(folder)))
    parsed = json.loads(text, parse_constant=lambda word: pytest.fail(word))
    assert parsed["counts"] == {"checks": 4, "passed": 1, "warnings": 1, "failed": 2, "known": 0}
    first = parsed["checks"][0]["findings"][0]
    line = (folder / "robot.xml").read_text().splitlines()[first["line"] - 1]
    assert 'name="arm_joint"' in line
    Path("known.json").write_text(text)
    again = replace(verdict(folder), baseline=baseline("known.json"))
    assert again.passed
    assert again.known_count == 4
    with pytest.raises(OutputError, match="cannot be read"):
        baseline("nowhere.json")


def test_the_sarif_has_rules_results_and_lines(folder):
    """What section 3 of SARIF 2.1.0 requires of a log, its run, rules and results."""
    baseline = frozenset({("C-JOINT", "robot.xml: joints", 'body "hand"', "pos")})
    log = json.loads(as_sarif(replace(verdict(folder), baseline=baseline)))
    assert log["version"] == "2.1.0"
    assert log["$schema"].endswith("sarif-schema-2.1.0.json")
    (sarif_run,) = log["runs"]
    driver, results = sarif_run["tool"]["driver"], sarif_run["results"]
    assert driver["name"] == "linkwright"
    assert [rule["id"] for rule in driver["rules"]] == ["C-JOINT", "C-MOTION", "C-MASS", "C-RELATION"]
    assert all(rule["shortDescription"]["text"] and rule["help"]["text"] for rule in driver["rules"])
    assert [(result["ruleId"], result["level"], result["baselineState"]) for result in results] == [
        ("C-JOINT", "error", "new"), ("C-JOINT", "error", "unchanged"), ("C-MOTION", "warning", "new"),
        ("C-RELATION", "error", "new"),
    ]  # fmt: skip
    assert len({result["partialFingerprints"]["linkwright/v1"] for result in results}) == 4
    lines = (folder / "robot.xml").read_text().splitlines()
    for result, name in zip(results[:2], ("arm_joint", "hand"), strict=True):
        place = result["locations"][0]["physicalLocation"]
        assert place["artifactLocation"]["uri"] == "robot/robot.xml"
        assert f'name="{name}"' in lines[place["region"]["startLine"] - 1]
    assert "region" not in results[2]["locations"][0]["physicalLocation"]
    assert "baselineState" not in json.loads(as_sarif(verdict(folder)))["runs"][0]["results"][0]


def test_the_line_is_that_of_the_element_that_has_the_attribute(folder):
    lines = ElementLines(folder)
    prims = '#usda 1.0\ndef Xform "robot"\n{\n    def PhysicsRevoluteJoint "elbow"\n    {\n    }\n}\n'
    (folder / "robot.usda").write_text(prims)
    changed(folder / "robot.xml", lambda text: text.replace("</mujoco>", EXCLUDE + "</mujoco>"))
    for file, element, attribute, part in (
        ("robot.urdf", 'joint "arm_joint"', "limit lower", "<limit"),
        ("robot.urdf", 'joint "arm_joint"', "", '<joint name="arm_joint"'),
        ("robot.urdf", 'link "hand"', "inertial mass", "<inertial"),
        ("robot.xml", 'body "hand"', "pos", '<body name="hand"'),
        ("robot.xml", 'exclude "base" "hand"', "body1, body2", "<exclude"),
        ("robot.xml", "option", "timestep", "<option"),
        ("robot.sdf", 'link "hand"', "inertial mass", "<inertial"),
        ("robot.usda", 'def "elbow"', "physics:axis", "PhysicsRevoluteJoint"),
    ):
        line = lines.of(file, element, attribute)
        assert line is not None, (file, element)
        assert part in (folder / file).read_text().splitlines()[line - 1]
    for file, element in (("robot.xml", 'body "leg"'), ("none.xml", "option"), ("robot.json", "links")):
        assert lines.of(file, element) is None
    assert lines.of("robot.xml", "no element") is None
    (folder / "robot.urdf").write_text("<robot")
    assert ElementLines(folder).of("robot.urdf", 'link "hand"') is None


def test_the_junit_is_as_pytest_writes_it(folder):
    baseline = frozenset({("C-RELATION", "robot.urdf: relations", "", "")})
    root = ET.fromstring(as_junit(replace(verdict(folder), baseline=baseline)))
    assert root.tag == "testsuites"
    (suite,) = root
    counts = {key: suite.get(key) for key in ("tests", "failures", "errors", "skipped")}
    assert counts == {"tests": "4", "failures": "1", "errors": "0", "skipped": "1"}
    joints, motion, mass, relations = suite
    assert (joints.get("classname"), joints.get("name")) == ("robot.xml", "joints")
    (failure,) = joints
    assert failure.get("message") == "C-JOINT: differ"
    assert 'joint "arm_joint" range: (-1, 2)' in failure.text
    assert [element.tag for element in motion] == ["system-out"]
    assert len(mass) == 0
    assert relations[0].tag == "skipped"


@pytest.mark.usefixtures("guests_at_home")
def test_reports_are_written_beside_the_text(folder, capsys):
    heavier(folder / "robot.urdf")
    assert run(["check", "--sarif", "a.sarif", "--junit=a.xml", "robot"]) == 3
    assert "FAILED C-MASS robot.urdf: mass" in capsys.readouterr().out
    assert json.loads(Path("a.sarif").read_text())["runs"][0]["results"]
    first = Path("a.sarif").read_bytes(), Path("a.xml").read_bytes()
    assert run(["check", "--sarif", "a.sarif", "--junit=a.xml", "robot"]) == 3
    assert (Path("a.sarif").read_bytes(), Path("a.xml").read_bytes()) == first


def test_build_without_export_has_nothing_to_check(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert run(["robot=sample", "until=graph"]) == 0
    capsys.readouterr()
    assert run(["check", "outputs/sample.graph"]) == 1
    assert "that build ended before the export" in capsys.readouterr().err


MODEL = '<mujoco><worldbody><body name="b"><joint/><geom size=".1"/></body></worldbody></mujoco>'


@pytest.fixture
def model(tmp_path):
    (tmp_path / "m.xml").write_text(MODEL)
    return str(tmp_path / "m.xml")


def test_the_verdict_and_the_errors_are_those_of_this_process(model, tmp_path):
    assert ask.checked(model, "standard") == checked(model, "standard")
    (tmp_path / "robot.json").write_text("[null]")
    for place, message in ((tmp_path, "expected a table"), (tmp_path / "none", "no such file")):
        with pytest.raises(OutputError, match=message):
            ask.checked(str(place), "standard")


def test_a_verdict_is_whole_on_the_other_side():
    finding = Finding('joint "a"', "range", "is 1")
    failed = Check("m.xml: a", False, "off", 1.5, float("inf"), "C-A", "warning", (finding,))
    verdict = Verdict("r", "/r", "robot", "quick", (failed, Check("b", True, "right")), ("a note",))
    assert wire.load(wire.dump(verdict)) == verdict


@pytest.mark.parametrize(
    "reply", [b"", b"[]", b"{}", b"[" * 100_000, json.dumps({"checks": [None]}).encode()]
)
def test_invalid_reply_of_the_guest_is_an_error(model, reply):
    with patch.object(guest, "ask", return_value=reply), pytest.raises(OutputError, match="is not a verdict"):
        ask.checked(model, "standard")
    ended = guest.Ended("crashed (SIGSEGV)")
    with patch.object(guest, "ask", side_effect=ended), pytest.raises(OutputError, match="crashed"):
        ask.checked(model, "standard")
