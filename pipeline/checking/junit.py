"""Writes the verdict of checks as JUnit XML, in the form of pytest."""

from linkwright.pipeline.checking.show import figures
from linkwright.pipeline.checking.verdict import Verdict, file_of
from linkwright.pipeline.reference.codes import remedy
from linkwright.stages.formats.xml import element, to_bytes
from linkwright.stages.robot.check import Check
from linkwright.stages.robot.text.printable import printable, printable_lines


def as_junit(verdict: Verdict) -> bytes:
    """Returns XML with a test case for each check, under its file. Known failures count as skipped, like
    pytest's expected failures; the text of a warning is the output of its case."""
    failed = [check for check in verdict.checks if verdict.fails(check)]
    known_failures = [check for check in verdict.checks if verdict.is_known(check)]
    suites = element(None, "testsuites", name="linkwright check")
    suite = element(
        suites,
        "testsuite",
        name=printable(verdict.place),
        errors="0",
        failures=str(len(failed)),
        skipped=str(len(known_failures)),
        tests=str(len(verdict.checks)),
        time="0.000",
    )
    for check in verdict.checks:
        file, title = file_of(check)
        case = element(
            suite, "testcase", classname=printable(file or "robot"), name=printable(title), time="0.000"
        )
        message = printable(f"{check.code}: {check.detail}")
        if verdict.is_known(check):
            element(case, "skipped", type="pytest.xfail", message=f"known from the baseline: {message}")
        elif verdict.fails(check):
            element(case, "failure", message=message).text = _text(verdict.with_new_findings(check))
        elif not check.passed:
            element(case, "system-out").text = f"WARNING {message}\n{_text(check)}"
    return to_bytes(suites)


def _text(check: Check) -> str:
    lines = [
        f"{finding.element} {finding.attribute}".strip() + f": {finding.message}"
        for finding in check.findings
    ]
    measured = figures(check)
    lines += [measured] if measured else []
    lines += [f"→ {remedy(check.code)}"] if remedy(check.code) else []
    return printable_lines("\n".join(lines))
