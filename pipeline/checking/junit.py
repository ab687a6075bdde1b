"""The verdict of checks as JUnit XML, in the form that pytest writes."""

from linkwright.pipeline.checking.show import figures
from linkwright.pipeline.checking.verdict import Verdict, file_of
from linkwright.pipeline.reference.codes import remedy
from linkwright.stages.formats.xml import element, to_bytes
from linkwright.stages.robot.check import Check
from linkwright.stages.robot.text.printable import printable, printable_lines


def as_junit(verdict: Verdict) -> bytes:
    """A case for each check, under its file. What is known is skipped, as what pytest expects to fail; of a
    warning the text is the case's output."""
    failed = [check for check in verdict.checks if verdict.fails(check)]
    known = [check for check in verdict.checks if verdict.is_known(check)]
    suites = element(None, "testsuites", name="linkwright check")
    suite = element(
        suites,
        "testsuite",
        name=printable(verdict.place),
        errors="0",
        failures=str(len(failed)),
        skipped=str(len(known)),
        tests=str(len(verdict.checks)),
        time="0.000",
    )
    for check in verdict.checks:
        file, title = file_of(check)
        own = element(
            suite, "testcase", classname=printable(file or "robot"), name=printable(title), time="0.000"
        )
        message = printable(f"{check.code}: {check.detail}")
        if verdict.is_known(check):
            element(own, "skipped", type="pytest.xfail", message=f"known from the baseline: {message}")
        elif verdict.fails(check):
            element(own, "failure", message=message).text = _text(verdict.news(check))
        elif not check.passed:
            element(own, "system-out").text = f"WARNING {message}\n{_text(check)}"
    return to_bytes(suites)


def _text(check: Check) -> str:
    lines = [f"{one.element} {one.attribute}".strip() + f": {one.message}" for one in check.findings]
    measured = figures(check)
    lines += [measured] if measured else []
    lines += [f"→ {remedy(check.code)}"] if remedy(check.code) else []
    return printable_lines("\n".join(lines))
