"""The judgements of what was found in public models: they mean what they say, and no more."""

import pytest

from linkwright.stages.robot.check import Check, Finding
from tests.benchmarks.judged import FILE, judged, judgements

TEXT = """
C-INERTIAL error:
- {models: "*/arm.urdf", lines: "*finger*", true_since: a kilogram for a finger}
C-START warning:
- {models: [a.xml, "*/b.xml"], false_since: it is meant so}
"""

FINGER = Finding('link "finger"', "ixx", "too much")
PALM = Finding('link "palm"', "ixx", "too much")


def verdicts(tmp_path, model, code, level, *findings, text=TEXT):
    (tmp_path / "judged.yaml").write_text(text)
    check = Check(f"{model}: it", False, "some words", code=code, level=level, findings=findings)
    measures = judged(judgements(tmp_path / "judged.yaml"), model, check)
    return [(line, None if verdict is None else verdict.true) for line, verdict in measures]


@pytest.mark.parametrize(("model", "code", "level", "expected"), [
    ("robots/arm.urdf", "C-INERTIAL", "error", [True, None]),
    ("robots/leg.urdf", "C-INERTIAL", "error", [None, None]),
    ("robots/arm.urdf", "C-INERTIAL", "warning", [None, None]),
    ("robots/arm.urdf", "C-SOLID", "error", [None, None]),
    ("a.xml", "C-START", "warning", [False, False]),
    ("more/a.xml", "C-START", "warning", [None, None]),
    ("more/b.xml", "C-START", "warning", [False, False]),
])  # fmt: skip
def test_finding_is_judged_by_model_code_level_and_line(model, code, level, expected, tmp_path):
    by_number = verdicts(tmp_path, model, code, level, FINGER, PALM)
    assert [true for _, true in by_number] == expected
    assert by_number[0][0] == 'link "finger" ixx: too much'


def test_check_without_findings_is_judged_by_its_detail(tmp_path):
    assert verdicts(tmp_path, "a.xml", "C-START", "warning") == [("some words", False)]


@pytest.mark.parametrize("ending", ["", ", true_since: yes it is, false_since: no it is not"])
def test_judgement_says_one_thing(ending, tmp_path):
    text = "C-START error:\n- {models: '*'" + ending + "}\n"
    with pytest.raises(ValueError, match="either true or false"):
        verdicts(tmp_path, "a.xml", "C-START", "error", text=text)


def test_what_was_looked_at_is_all_true():
    rulings = judgements(FILE)
    assert rulings
    assert all(verdict.true and verdict.why for verdict in rulings)
    assert all(problem.code.startswith("C-") and problem.level in ("error", "warning") for problem in rulings)
