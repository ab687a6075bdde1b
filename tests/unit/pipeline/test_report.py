"""The report: its JSON and the closing table."""

import io
import json
from dataclasses import replace

from pipeline.report import Report, StageReport, failure_lines, fitting, render, show, versions
from stages.robot.check import Check
from stages.robot.errors import Diagnostic

REPORT = Report(
    status="invalid",
    name="arm",
    folder="outputs/arm",
    until="validate",
    exit_status=3,
    source={"kind": "onshape", "microversion": "m1"},
    calls={"made": 5, "saved": 2},
    stages=(StageReport("fetch", True, 0.004, "3 replies"), StageReport("graph", False, 12.5, "2 links")),
    figures={"links": 2, "mass": 1.5},
    diagnostics=(Diagnostic("W-LIMIT", "no limits", "Arm/Elbow [left]", "set joints.elbow.limits"),),
    checks=(Check("compiles", True, "ok"), Check("mass", False, "1 kg instead of 2 kg", 1.0, 2.0)),
    outputs={"arm.urdf": "ab" * 32},
    versions={"linkwright": "0.1.0", "python": "3.11.7"},
)


class Screen(io.StringIO):
    def isatty(self):
        return True


def test_the_json_holds_every_part_under_the_format_key():
    data = json.loads(REPORT.to_json())
    assert data["linkwright-report"] == 1
    assert data["status"] == "invalid"
    assert data["calls"] == {"made": 5, "saved": 2}
    assert data["stages"][0] == {"name": "fetch", "cached": True, "seconds": 0.004, "outputs": "3 replies"}
    assert data["diagnostics"][0]["code"] == "W-LIMIT"
    assert data["checks"][1] == {
        "name": "mass",
        "passed": False,
        "detail": "1 kg instead of 2 kg",
        "value": 1.0,
        "limit": 2.0,
        "code": "",
        "level": "error",
        "findings": [],
        "table": None,
    }
    assert data["outputs"] == {"arm.urdf": "ab" * 32}
    assert data["error"] is None


def test_plain_text_is_aligned_and_shows_findings_and_place():
    assert render(REPORT).splitlines() == [
        "stage          seconds  outputs",
        "fetch  cached     0.00  3 replies",
        "graph  built     12.50  2 links",
        "W-LIMIT Arm/Elbow [left]: no limits",
        "    → set joints.elbow.limits",
        "FAILED mass: 1 kg instead of 2 kg",
        "1 of 2 checks passed",
        "5 API calls made, 2 saved by the cache",
        "arm: outputs/arm",
    ]


def test_without_findings_calls_or_checks_nothing_is_printed_about_them():
    bare = replace(REPORT, diagnostics=(), checks=(), calls={"made": 0, "saved": 0})
    assert render(bare).splitlines()[3:] == ["arm: outputs/arm"]


def test_a_robot_that_nobody_named_is_called_as_its_assembly_is():
    titled = replace(REPORT, name="onshape_e1c65b19", title="Left arm")
    assert render(titled).splitlines()[-1] == "onshape_e1c65b19 (Left arm): outputs/arm"
    assert titled.heading == "onshape_e1c65b19 (Left arm)"
    assert json.loads(titled.to_json())["title"] == "Left arm"


def test_what_comes_after_an_error_counts_calls_and_names_source_and_report(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert failure_lines(REPORT, tmp_path / "out" / "arm.failed") == [
        "5 API calls made, 2 saved by the cache",
        "report: out/arm.failed/report.html",
    ]
    url = replace(REPORT, source={"kind": "onshape", "url": "https://x"}, calls={"made": 1, "saved": 0})
    assert failure_lines(url, tmp_path)[:2] == ["1 API call made, 0 saved by the cache", "source: https://x"]
    file = replace(REPORT, source={"kind": "urdf"}, calls={"made": 0, "saved": 0})
    assert failure_lines(file, tmp_path / "a.failed") == ["report: a.failed/report.html"]


def test_a_pipe_gets_plain_text_and_a_terminal_the_same_facts():
    pipe, screen = io.StringIO(), Screen()
    show(REPORT, pipe)
    show(REPORT, screen)
    assert pipe.getvalue() == render(REPORT)
    for fact in ("3 replies", "cached", "12.50", "Arm/Elbow [left]", "FAILED mass", "outputs/arm"):
        assert fact in screen.getvalue()


def test_what_is_to_be_pasted_keeps_its_lines_on_a_narrow_terminal():
    hint = "set them: joints: {" + ", ".join(f"joint_{number}: {{}}" for number in range(20)) + "}"
    screen = Screen()
    show(replace(REPORT, diagnostics=(Diagnostic("W-LIMIT", "no limits", "x", hint),)), screen)
    assert f"    → {hint}\n" in screen.getvalue()


TREE = ("arm: 2 links", "└─ elbow  ≤ 90 deg  = -1 × drive …")


def test_the_tree_is_shown_where_the_build_ends_at_the_graph_only():
    graph = replace(REPORT, until="graph", outline=TREE)
    assert render(graph).splitlines()[:4] == [*TREE, "", "stage          seconds  outputs"]
    assert TREE[1] not in render(replace(graph, until="validate"))
    assert TREE[1] not in render(replace(graph, until="fetch", outline=()))
    screen = Screen()
    show(graph, screen)
    assert TREE[1] in screen.getvalue()


def test_a_stream_that_knows_no_boxes_gets_plain_letters():
    raw = io.BytesIO()
    pipe = io.TextIOWrapper(raw, encoding="ascii")
    show(replace(REPORT, until="graph", outline=TREE), pipe)
    pipe.flush()
    text = raw.getvalue().decode("ascii")
    assert "`- elbow  < 90 deg  = -1 * drive ~" in text
    assert "    > set joints.elbow.limits" in text
    assert fitting("Grübler │", "latin-1") == "Grübler |"
    assert fitting("中 │", "utf-8") == "中 │"
    assert fitting("中 │", "ascii") == "? |"


def test_versions_name_linkwright_and_python_first():
    assert list(versions({"numpy": "2"}))[:2] == ["linkwright", "python"]
    assert versions({"numpy": "2"})["numpy"] == "2"
