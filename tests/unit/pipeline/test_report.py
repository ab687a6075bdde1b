"""The report: its JSON and the closing text."""

import io
import json
import re
from dataclasses import replace

import yaml

from linkwright.pipeline.report import Report, StageReport, failure_lines, versions
from linkwright.pipeline.terminal.closing import closing_text, print_closing_text, replace_unencodable
from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.robot.errors import Diagnostic
from tests.support.terminal import Screen

ESCAPES = re.compile(r"\x1b\[[0-9;]*m")

REPORT = Report(
    "invalid", "arm", "outputs/arm", "validate", 3,
    source={"kind": "onshape", "microversion": "m1"},
    calls={"made": 5, "saved": 2},
    stages=(StageReport("fetch", True, 0.004, "3 replies"), StageReport("graph", False, 12.5, "2 links")),
    figures={"links": 2, "mass": 1.5},
    diagnostics=(Diagnostic("W-LIMIT", "no limits", "Arm/Elbow [left]", "set joints.elbow.limits"),),
    checks=(Check("compiles", True, "ok"), Check("mass", False, "1 kg instead of 2 kg", 1.0, 2.0)),
    outputs={"arm.urdf": "ab" * 32},
    versions={"linkwright": "0.1.0", "python": "3.11.7"},
)  # fmt: skip


def on_screen(report):
    """What a terminal shows, without colours."""
    screen = Screen()
    print_closing_text(report, screen)
    return ESCAPES.sub("", screen.getvalue())


def test_the_json_holds_every_part_under_the_format_key():
    data = json.loads(REPORT.to_json())
    assert data.items() >= {
        "linkwright-report": 1, "status": "invalid", "calls": {"made": 5, "saved": 2},
        "outputs": {"arm.urdf": "ab" * 32}, "error": None,
    }.items()  # fmt: skip
    assert data["stages"][0] == {"name": "fetch", "cached": True, "seconds": 0.004, "outputs": "3 replies"}
    assert data["diagnostics"][0]["code"] == "W-LIMIT"
    assert data["checks"][1] == {
        "name": "mass", "passed": False, "detail": "1 kg instead of 2 kg", "value": 1.0, "limit": 2.0,
        "code": "", "level": "error", "findings": [], "table": None,
    }  # fmt: skip
    assert list(versions({"numpy": "2"}).items())[2:] == [("numpy", "2")]
    assert list(versions({"numpy": "2"}))[:2] == ["linkwright", "python"]


def test_plain_text_shows_findings_checks_calls_and_place():
    assert closing_text(REPORT).splitlines() == [
        "W-LIMIT Arm/Elbow [left]: no limits",
        "    → set joints.elbow.limits",
        "FAILED mass: 1 kg instead of 2 kg",
        "1 of 2 checks passed",
        "5 API calls made, 2 saved by the cache",
        "arm: outputs/arm",
    ]
    bare = replace(REPORT, diagnostics=(), checks=(), calls={"made": 0, "saved": 0}, title="Left arm")
    assert closing_text(bare).splitlines() == ["arm (Left arm): outputs/arm"]
    assert json.loads(bare.to_json())["title"] == "Left arm"
    lines = Diagnostic("I-LIVE", "Error: mass\n  Element 'geom', line 4\n", "report.html")
    assert "I-LIVE report.html: Error: mass Element 'geom', line 4\n" in closing_text(
        replace(bare, diagnostics=(lines,))
    )


def test_lines_after_an_error_name_calls_source_and_report(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert failure_lines(REPORT, tmp_path / "out" / "arm.failed") == [
        "5 API calls made, 2 saved by the cache",
        "report: out/arm.failed/report.html",
    ]
    url = replace(REPORT, source={"kind": "onshape", "url": "https://x"}, calls={"made": 1, "saved": 0})
    assert failure_lines(url, tmp_path)[:2] == ["1 API call made, 0 saved by the cache", "source: https://x"]
    old = {"kind": "onshape", "url": "https://cad.onshape.com/documents/a1/v/b2/e/c3"}
    assert failure_lines(replace(REPORT, source=old, calls={"made": 0, "saved": 3}), tmp_path)[0] == (
        "0 API calls made, 3 saved by the cache; source.url names a version, which no edit changes"
    )
    file = replace(REPORT, source={"kind": "urdf"}, calls={"made": 0, "saved": 0})
    assert failure_lines(file, tmp_path / "a.failed") == ["report: a.failed/report.html"]


def test_a_pipe_gets_plain_text_and_a_terminal_the_same_facts():
    pipe = io.StringIO()
    print_closing_text(REPORT, pipe)
    assert pipe.getvalue() == closing_text(REPORT)
    facts = ["Arm/Elbow [left]", "set joints.elbow.limits", "FAILED", "1 kg instead of 2 kg", "outputs/arm"]
    assert [fact for fact in facts if fact not in on_screen(REPORT)] == []
    assert "3 replies" not in on_screen(REPORT) + closing_text(REPORT), "the stages are not listed again"


def test_yaml_to_paste_is_the_same_yaml_on_a_narrow_terminal(monkeypatch):
    monkeypatch.delenv("COLUMNS", raising=False)
    joints = {f"joint_{number}": {"damping": number} for number in range(20)}
    hint = (
        "set them: joints: {" + ", ".join(f"{name}: {{damping: {n}}}" for n, name in enumerate(joints)) + "}"
    )
    shown = on_screen(
        replace(REPORT, diagnostics=(Diagnostic("W-LIMIT", "no limits", "x", hint),), checks=())
    )
    assert max(map(len, shown.splitlines())) <= 80
    pasted = shown[shown.index("joints: {") : shown.index("5 API calls")]
    assert yaml.safe_load(pasted) == {"joints": joints}


def test_no_line_is_wider_than_the_terminal(monkeypatch):
    monkeypatch.setenv("COLUMNS", "60")
    words = "a joint that turns freely and has no limits of its own " * 6
    codes = [(code, number) for number in range(9) for code in ("W-LIMIT", "I-RAW")]
    diagnostics = tuple(Diagnostic(code, words, f"Arm/Elbow {number}", words) for code, number in codes)
    findings = (Finding("joint", "range", words),) * 5
    checks = (Check("mass of all " * 9, False, words, 1.0, 2.0, findings=findings),)
    report = replace(REPORT, diagnostics=diagnostics, checks=checks, advice=words, folder="a/" * 20)
    assert max(map(len, on_screen(report).splitlines())) <= 60


def of_a_joint(number, hint="set limits"):
    return Diagnostic("W-LIMIT", f"joint {number} has no limits", f"joint_{number}", hint)


def test_findings_of_a_code_are_one_with_the_three_worst():
    """100 lines of findings become one line a code, and where the rest is."""
    of_limits = [of_a_joint(number) for number in range(20)]
    rest = [Diagnostic("W-FEATURE", f"{kind} mate", "Arm", "suppress it") for kind in ("a", "b", "c", "d")]
    report = replace(REPORT, diagnostics=(*of_limits, *rest), checks=(), calls={})
    assert closing_text(report).splitlines()[:-1] == [
        "W-LIMIT ×20 joint_0: joint 0 has no limits",
        "    also: joint_1, joint_2 and 17 more (report.html)",
        "    → set limits",
        # At one place, so that their messages tell them apart.
        "W-FEATURE ×4 Arm: a mate",
        "W-FEATURE Arm: b mate",
        "W-FEATURE Arm: c mate",
        "    → suppress it",
        "    and 1 more (report.html)",
    ]
    assert len(closing_text(report, "all").splitlines()) == 2 * 24 + 1


def test_v_shows_all_and_q_only_what_failed():
    diagnostics = tuple(
        Diagnostic(code, "x " * 400, f"place {n}") for n in range(5) for code in ("I-RAW", "W-LIMIT")
    )
    warned = Check("reach", False, "hit", level="warning", findings=(Finding("joint", "", "hit"),) * 9)
    report = replace(REPORT, diagnostics=diagnostics, checks=(*REPORT.checks, warned))
    usual, verbose, quiet = (closing_text(report, detail) for detail in ("usual", "all", "errors"))
    assert usual.count("place") < verbose.count("place") == 10
    assert "… (report.html)" in usual
    assert verbose.count("x ") >= 10 * 399
    assert (usual.count("joint: hit"), verbose.count("joint: hit")) == (3, 9)
    assert quiet == "FAILED mass: 1 kg instead of 2 kg\n"
    built = replace(report, status="built", checks=())
    assert closing_text(built, "errors") == ""
    stale = replace(built, status="stale", diagnostics=(Diagnostic("W-QUOTA", "used up"), *diagnostics[:1]))
    assert closing_text(stale, "errors") == "W-QUOTA used up\n"


def test_yaml_for_all_of_a_code_is_shown_where_it_is_short():
    block = "all at once:\njoints:\n  a: 1"
    short = [*(of_a_joint(number) for number in range(3)), of_a_joint(3, f"set limits\n{block}")]
    assert f"    → set limits\n{block}\n" in closing_text(replace(REPORT, diagnostics=tuple(short)))
    long = [*short[:3], of_a_joint(3, "set limits\n" + "\n".join(f"line {n}" for n in range(30)))]
    assert "    → 30 lines to paste, for all (report.html)\n" in closing_text(
        replace(REPORT, diagnostics=tuple(long))
    )


TREE = ("arm: 2 links", "└─ elbow  ≤ 90 deg  = -1 × drive …")


def test_tree_is_shown_where_the_build_ends_at_the_graph(monkeypatch):
    monkeypatch.delenv("COLUMNS", raising=False)
    graph = replace(REPORT, until="graph", outline=TREE)
    assert closing_text(graph).splitlines()[:3] == [*TREE, ""]
    assert TREE[1] not in closing_text(replace(graph, until="validate"))
    assert TREE[1] not in closing_text(replace(graph, until="fetch", outline=()))
    assert TREE[1] in on_screen(graph)
    wide = replace(graph, outline=("x" * 90,), narrow_outline=("x" * 45, "x" * 45))
    assert on_screen(wide).splitlines()[:2] == ["x" * 45, "x" * 45]
    assert closing_text(wide).splitlines()[0] == "x" * 90
    monkeypatch.setenv("COLUMNS", "100")
    assert on_screen(wide).splitlines()[0] == "x" * 90


def test_a_stream_that_knows_no_boxes_gets_plain_letters():
    raw = io.BytesIO()
    pipe = io.TextIOWrapper(raw, encoding="ascii")
    print_closing_text(replace(REPORT, until="graph", outline=TREE), pipe)
    pipe.flush()
    text = raw.getvalue().decode("ascii")
    assert "`- elbow  < 90 deg  = -1 * drive ~" in text
    assert "    > set joints.elbow.limits" in text
    assert replace_unencodable("Grübler │", "latin-1") == "Grübler |"
    assert replace_unencodable("中 │", "utf-8") == "中 │"
    assert replace_unencodable("中 │", "ascii") == "? |"
