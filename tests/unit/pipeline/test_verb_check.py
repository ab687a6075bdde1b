"""`linkwright check`: files are compared with robot.json alone, and what is wrong is told in every form."""

import json
import re
import shutil
import xml.etree.ElementTree as ET
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from linkwright.pipeline.checking.as_json import as_json, baseline
from linkwright.pipeline.checking.junit import as_junit
from linkwright.pipeline.checking.lines import ElementLines
from linkwright.pipeline.checking.run import checked
from linkwright.pipeline.checking.sarif import as_sarif
from linkwright.pipeline.checking.show import as_text
from linkwright.pipeline.checking.verdict import Verdict
from linkwright.pipeline.cli import run
from linkwright.pipeline.errors import OutputError
from linkwright.pipeline.reference.codes import remedy
from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.robot.model.robot import Dynamics, Limits
from linkwright.stages.validate.checks import MODEL_CHECKS
from tests.support.building import plan_of, write
from tests.support.robots import at, joint, robot_with

EXCLUDE = '<contact><exclude body1="base" body2="hand"/></contact>'
LIMITS = {"arm_joint": Limits(-1.0, 1.0)}


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The files of a robot of two joints, and nothing else of a build."""
    rows = [
        joint("revolute", "base", "arm", [0.1], limits=LIMITS, dynamics=Dynamics(0.1, 0.1, 0.01, 5, 2)),
        joint("prismatic", "arm", "hand", place=at(0, 0, 0.2), limits={"hand_joint": Limits(0.0, 0.1)}),
    ]
    folder = tmp_path_factory.mktemp("check") / "robot"
    write(robot_with(rows), folder, plan_of(export={"urdf": {}, "mjcf": {}, "sdf": {}}))
    return folder


@pytest.fixture
def folder(built: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    shutil.copytree(built, tmp_path / "robot")
    return Path("robot")


def changed(file: Path, change: Callable[[str], str]) -> None:
    before = file.read_text()
    file.write_text(change(before))
    assert file.read_text() != before


def heavier(file: Path) -> None:
    """The last mass of a file, 1 % off."""
    found = list(re.finditer(r'mass(?: value)?="([0-9.]+)"', file.read_text()))[-1]
    mass = float(found[1])
    changed(file, lambda text: text[: found.start(1)] + repr(mass * 1.01) + text[found.end(1) :])


def table(arguments: list[str], capsys: pytest.CaptureFixture[str], status: int) -> dict[str, Any]:
    assert run(["check", "--json", *arguments]) == status
    found: dict[str, Any] = json.loads(capsys.readouterr().out)
    return found


def test_files_as_they_were_written_pass(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert not (folder / "report.json").exists()
    assert run(["check", str(folder)]) == 0
    out = capsys.readouterr().out
    assert re.fullmatch(r"(\d+) of \1 checks passed", out.strip().splitlines()[-1])
    assert "FAILED" not in out
    for place in (folder / "robot.json", folder / "robot.urdf", folder / "scene.xml", folder / "robot.sdf"):
        assert run(["check", str(place)]) == 0
        assert "checks passed" in capsys.readouterr().out


@pytest.mark.usefixtures("guests_at_home")
@pytest.mark.parametrize("name", ["robot.urdf", "robot.xml"])
def test_a_wrong_mass_is_found_in_the_file_that_has_it(
    folder: Path, name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    heavier(folder / name)
    found = table([str(folder)], capsys, 3)
    wrong = [one for one in found["checks"] if not one["passed"] and one["level"] == "error"]
    assert found["passed"] is False
    assert {"C-MASS"} <= {one["code"] for one in wrong}
    assert {one["file"] for one in wrong} == {name}
    (mass,) = [one for one in wrong if one["name"] == f"{name}: mass"]
    assert mass["value"] == pytest.approx(0.01, rel=1e-6)
    assert mass["hint"] == remedy("C-MASS")
    others = [one for one in ("robot.urdf", "robot.xml", "robot.sdf") if one != name]
    assert run(["check", str(folder / name)]) == 3
    assert [run(["check", str(folder / one)]) for one in others] == [0, 0]


def test_a_usd_is_read_within_the_limits(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Of addresses usd-core reserves more than all memory that a check may take."""
    pytest.importorskip("pxr")
    robot = robot_with([joint("revolute", "base", "arm", [0.1])])
    write(robot, tmp_path / "robot", plan_of(export={"usd": {}}))
    assert run(["check", str(tmp_path / "robot")]) == 0
    assert "checks passed" in capsys.readouterr().out


@pytest.mark.usefixtures("guests_at_home")
def test_a_file_that_is_gone_is_missed(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "robot.sdf").unlink()
    (folder / "scene.xml").unlink()
    assert run(["check", str(folder)]) == 3
    out = capsys.readouterr().out
    assert "FAILED C-PRESENT robot.json: files: missing: robot.sdf, scene.xml (2, at most 0)" in out
    assert '    file "scene.xml": robot.json lists this file, and it is not there' in out
    assert f"    → {remedy('C-PRESENT')}" in out


def test_what_a_check_breaks_over_is_one_check_that_fails(
    folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def breaks(compiled: Any) -> Any:
        yield compiled.result("first", True, "well")
        raise KeyError("leg")

    broken = [replace(check, function=breaks) if check.title == "joints" else check for check in MODEL_CHECKS]
    monkeypatch.setattr("linkwright.stages.validate.checks.MODEL_CHECKS", broken)
    monkeypatch.setattr("linkwright.pipeline.verbs.check.checked", checked)
    found = table([str(folder / "robot.urdf")], capsys, 3)
    assert [one["name"] for one in found["checks"] if not one["passed"]] == ["robot.urdf: joints"]
    (broken,) = [one for one in found["checks"] if not one["passed"]]
    assert (broken["code"], "KeyError: 'leg'" in broken["detail"]) == ("C-JOINT", True)
    assert {"robot.urdf: first", "robot.urdf: motion"} <= {one["name"] for one in found["checks"]}


@pytest.mark.usefixtures("guests_at_home")
def test_quick_looks_whether_files_compile(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    heavier(folder / "robot.urdf")
    assert run(["check", "--level", "quick", str(folder)]) == 0
    changed(folder / "robot.xml", lambda text: text.replace("<worldbody>", "<worldbodies>", 1))
    capsys.readouterr()
    assert run(["check", "--level=quick", str(folder)]) == 3
    assert "FAILED C-COMPILE robot.xml: compiles" in capsys.readouterr().out


@pytest.mark.usefixtures("guests_at_home")
def test_what_is_in_the_baseline_does_not_fail(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    heavier(folder / "robot.urdf")
    before = table([str(folder)], capsys, 3)
    Path("known.json").write_text(json.dumps(before))
    known = ["--baseline", "known.json", str(folder)]
    assert run(["check", *known]) == 0
    out = capsys.readouterr().out
    assert "FAILED" not in out
    assert re.search(r"^\d+ findings? known from the baseline$", out, re.MULTILINE)
    heavier(folder / "robot.urdf")
    assert run(["check", *known]) == 0  # the same by another figure
    (folder / "scene.xml").unlink()
    capsys.readouterr()
    after = table(known, capsys, 3)
    fresh = [one["code"] for one in after["checks"] if not one["passed"] and not one["known"]]
    assert fresh == ["C-PRESENT"]
    assert after["counts"]["known"] >= before["counts"]["failed"] > 0


@pytest.mark.usefixtures("guests_at_home")
def test_a_file_without_a_robot_json_is_checked_by_itself(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "robot.json").unlink()
    for place in (folder / "robot.urdf", folder / "robot.xml", folder):
        found = table([str(place)], capsys, 0)
        assert found["robot"] is None
        assert "there is no robot.json" in found["notes"][0]
        assert found["checks"]
    changed(folder / "robot.urdf", lambda text: text.replace('lower="-1"', 'lower="3"'))
    assert run(["check", str(folder / "robot.urdf")]) == 3
    assert 'joint "arm_joint"' in capsys.readouterr().out
    assert run(["check", str(folder / "robot.xml")]) == 0
    changed(folder / "robot.urdf", lambda text: text.replace("</robot>", ""))
    assert run(["check", str(folder)]) == 3


@pytest.mark.usefixtures("guests_at_home")
def test_wrong_usage_and_what_cannot_be_read(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    Path("empty").mkdir()
    Path("notes.txt").write_text("x")
    Path("other.json").write_text('{"format": "linkwright-diff", "version": 1}')
    Path("broken.json").write_text('{"format": "linkwright-check", "version": 1, "checks": [{}]}')
    (folder / "sub").mkdir()
    for arguments, status, told in (
        ([], 2, "expected one folder or file, got 0"),
        (["robot", "empty"], 2, "expected one folder or file, got 2"),
        (["--yaml", "robot"], 2, "there is no option --yaml"),
        (["robot", "--level"], 2, "--level needs a value"),
        (["--level", "hard", "robot"], 2, "there is no level hard"),
        (["--sarif=a", "--sarif=b", "robot"], 2, "--sarif is there twice"),
        (["nowhere"], 1, "there is no such file or folder"),
        (["empty"], 1, "the folder has no robot.json, and no URDF or MJCF"),
        (["notes.txt"], 1, "its name ends in none of"),
        (["--baseline", "none.json", "robot"], 1, "the baseline cannot be read"),
        (["--baseline", "notes.txt", "robot"], 1, "the baseline is no JSON"),
        (["--baseline", "other.json", "robot"], 1, "the baseline is no linkwright-check"),
        (["--baseline", "broken.json", "robot"], 1, "checks that cannot be read"),
        (["--level=quick", "--junit", "none/x.xml", "robot"], 1, "it cannot be written"),
    ):
        assert run(["check", *arguments]) == status, arguments
        found = capsys.readouterr()
        assert told in found.err, arguments
        assert "Traceback" not in found.err


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda t: t["links"][1].pop("mass"), "links[1].mass: expected a number, found nothing"),
        (lambda t: t["joints"][0].update(type="hinge"), "joints[0].type: expected one of fixed"),
        (lambda t: t["joints"][0].update(parent="leg"), "which is no tree"),
        (lambda t: t["joints"][0]["dofs"][0].update(limits=[0]), "joints[0].dofs[0].limits: expected two"),
        (lambda t: t["shapes"].append({"link": "leg"}), "shapes[0].link: there is no link 'leg'"),
        (lambda t: t.update(name="../robot"), "'../robot' is no path below its folder"),
        (lambda t: t.update(files=["/etc/passwd"]), "'/etc/passwd' is no path below its folder"),
        (lambda t: t.update(version=2), "its version is 2"),
        (lambda t: t.update(format="x"), "it is no robot.json of Linkwright"),
    ],
)
def test_a_robot_json_that_is_wrong_is_named_with_its_field(
    folder: Path, change: Callable[[Any], object], told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    file = folder / "robot.json"
    robot = json.loads(file.read_text())
    change(robot)
    file.write_text(json.dumps(robot))
    assert run(["check", str(folder)]) == 1
    found = capsys.readouterr().err
    assert told in found
    assert "→ build again" in found


def verdict(folder: Path) -> Verdict:
    """One check of each kind, of a real file."""
    two = (
        Finding('joint "arm_joint"', "range", "(-1, 2), expected (-1, 1)"),
        Finding('body "hand"', "pos", "0 0 1, expected 0 0 0.2"),
    )
    checks = (
        Check("robot.xml: joints", False, "differ", 2.0, 0.0, "C-JOINT", "error", two),
        Check("robot.xml: motion", False, "off \x1b[31m", float("inf"), 1e-9, "C-MOTION", "warning"),
        Check("robot.urdf: mass", True, "right", 0.0, 1e-9, "C-MASS"),
        Check("robot.urdf: relations", False, "differ: gear", None, None, "C-RELATION"),
    )
    return Verdict(str(folder), str(folder), "robot", "standard", checks)


def test_the_text_names_the_elements_with_figure_and_hint(folder: Path) -> None:
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


def test_the_json_is_valid_and_a_baseline_of_its_own(folder: Path) -> None:
    found = verdict(folder)
    text = as_json(found)
    parsed = json.loads(text, parse_constant=lambda word: pytest.fail(word))
    assert parsed["counts"] == {"checks": 4, "passed": 1, "warnings": 1, "failed": 2, "known": 0}
    first = parsed["checks"][0]["findings"][0]
    line = (folder / "robot.xml").read_text().splitlines()[first["line"] - 1]
    assert 'name="arm_joint"' in line
    Path("known.json").write_text(text)
    again = replace(found, known=baseline("known.json"))
    assert again.passed
    assert again.seen_before == 4
    with pytest.raises(OutputError, match="cannot be read"):
        baseline("nowhere.json")


def test_the_sarif_has_rules_results_and_lines(folder: Path) -> None:
    """What section 3 of SARIF 2.1.0 requires of a log, its run, rules and results."""
    known = frozenset({("C-JOINT", "robot.xml: joints", 'body "hand"', "pos")})
    log = json.loads(as_sarif(replace(verdict(folder), known=known)))
    assert log["version"] == "2.1.0"
    assert log["$schema"].endswith("sarif-schema-2.1.0.json")
    (one,) = log["runs"]
    driver = one["tool"]["driver"]
    assert driver["name"] == "linkwright"
    rules = [rule["id"] for rule in driver["rules"]]
    assert rules == ["C-JOINT", "C-MOTION", "C-MASS", "C-RELATION"]
    assert all(rule["shortDescription"]["text"] and rule["help"]["text"] for rule in driver["rules"])
    results = one["results"]
    assert [result["ruleId"] for result in results] == ["C-JOINT", "C-JOINT", "C-MOTION", "C-RELATION"]
    assert [result["level"] for result in results] == ["error", "error", "warning", "error"]
    assert [result["baselineState"] for result in results] == ["new", "unchanged", "new", "new"]
    prints = {result["partialFingerprints"]["linkwright/v1"] for result in results}
    assert len(prints) == 4
    text = (folder / "robot.xml").read_text().splitlines()
    for result, name in zip(results[:2], ("arm_joint", "hand"), strict=True):
        place = result["locations"][0]["physicalLocation"]
        assert place["artifactLocation"]["uri"] == "robot/robot.xml"
        assert f'name="{name}"' in text[place["region"]["startLine"] - 1]
    assert "region" not in results[2]["locations"][0]["physicalLocation"]
    assert "baselineState" not in json.loads(as_sarif(verdict(folder)))["runs"][0]["results"][0]


def test_the_line_is_that_of_the_element_that_has_the_attribute(folder: Path) -> None:
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


def test_the_junit_is_as_pytest_writes_it(folder: Path) -> None:
    known = frozenset({("C-RELATION", "robot.urdf: relations", "", "")})
    root = ET.fromstring(as_junit(replace(verdict(folder), known=known)))
    assert root.tag == "testsuites"
    (suite,) = root
    counts = {key: suite.get(key) for key in ("tests", "failures", "errors", "skipped")}
    assert counts == {"tests": "4", "failures": "1", "errors": "0", "skipped": "1"}
    joints, motion, mass, relations = suite
    assert (joints.get("classname"), joints.get("name")) == ("robot.xml", "joints")
    (failure,) = joints
    assert failure.get("message") == "C-JOINT: differ"
    assert 'joint "arm_joint" range: (-1, 2)' in failure.text
    assert [one.tag for one in motion] == ["system-out"]
    assert len(mass) == 0
    assert relations[0].tag == "skipped"


@pytest.mark.usefixtures("guests_at_home")
def test_reports_are_written_beside_the_text(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    heavier(folder / "robot.urdf")
    assert run(["check", "--sarif", "a.sarif", "--junit=a.xml", "robot"]) == 3
    assert "FAILED C-MASS robot.urdf: mass" in capsys.readouterr().out
    assert json.loads(Path("a.sarif").read_text())["runs"][0]["results"]
    first = Path("a.sarif").read_bytes(), Path("a.xml").read_bytes()
    assert run(["check", "--sarif", "a.sarif", "--junit=a.xml", "robot"]) == 3
    assert (Path("a.sarif").read_bytes(), Path("a.xml").read_bytes()) == first


def test_a_build_that_ended_before_the_export_has_nothing_to_check(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert run(["robot=sample", "until=graph"]) == 0
    capsys.readouterr()
    assert run(["check", "outputs/sample.graph"]) == 1
    assert "that build ended before the export" in capsys.readouterr().err
