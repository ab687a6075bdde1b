"""Defines the document of a build."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import PurePath
from typing import ClassVar, Literal

from linkwright.pipeline.json_documents.document import AnyValue, CommandDocument
from linkwright.pipeline.json_documents.findings import DiagnosticDocument, counts, worst
from linkwright.pipeline.reference.codes import remedy
from linkwright.pipeline.report import Report
from linkwright.stages.robot.check import Check

ROLES = {"report": "report.json", "page": "report.html", "config": "config.yaml", "log": "build.log"}
"""Role of a document about a build → its name, as in `pipeline.output.manifest.DOCUMENTS`."""

_ROBOT = "robot.json"
_ASSET_FOLDER = "assets"


@dataclass(frozen=True)
class CheckSummary:
    """A check that did not pass.

    code: its row of CHECKS.md; `linkwright explain CODE` explains it.
    name: its name, with the file in front if it is about a single file.
    level: `error`: the build is invalid; `warning`: something could be better.
    detail: what was measured, in words.
    findings: the number of its findings, which the report lists.
    hint: what to do; may be empty.
    """

    code: str
    name: str
    level: str
    detail: str
    findings: int
    hint: str


@dataclass(frozen=True)
class BuildDocument(CommandDocument):
    """A build that wrote its output folder.

    exit_status: 0: built and valid; 3: built, but a check failed or the state is not the newest.
    status: `built`; `stale`: valid, but from an older state, since the API quota is used up; `invalid`: a
        check failed.
    name: the robot's name.
    until: the last stage that ran.
    folder: the output folder, relative to the working folder unless it is absolute.
    paths: the files about the build: `report` (report.json: everything), `page`, `config`, `log`, and if
        they exist `robot` (robot.json) and `picture`.
    files: the robot's files in `folder`, without meshes and textures.
    source: the kind of the source and its pinned state, as in report.json.
    calls: API calls `made` and `saved`, as in report.json.
    figures: figures such as links, dofs and mass [kg], as in report.json.
    objective: the numbers of the objective by name.
    checks: the number of checks that `passed`, `warned` and `failed`.
    problems: the checks that failed, then those that warned.
    counts: the number of diagnostics of each level.
    diagnostics: the worst diagnostics: warnings, at most three of a code and all with YAML to paste; with
        `-v` all.
    advice: what to try next; may be empty.
    """

    FORMAT: ClassVar[str] = "linkwright-build"

    exit_status: int
    status: Literal["built", "stale", "invalid"]
    name: str
    until: str
    folder: str
    paths: Mapping[str, str]
    files: tuple[str, ...]
    source: AnyValue
    calls: AnyValue
    figures: AnyValue
    objective: AnyValue
    checks: Mapping[str, int]
    problems: tuple[CheckSummary, ...]
    counts: Mapping[str, int]
    diagnostics: tuple[DiagnosticDocument, ...]
    advice: str


def build_document(report: Report, *, whole: bool) -> BuildDocument:
    """Returns the document of a build with this report; if `whole`, with all its diagnostics."""
    assert report.status != "failed"  # an error ended it, which has a document of its own
    failed, warned = report.failed_checks, report.warned_checks
    passed = len(report.checks) - len(failed) - len(warned)
    return BuildDocument(
        exit_status=report.exit_status,
        status=report.status,
        name=report.name,
        until=report.until,
        folder=report.folder,
        paths=_paths(report),
        files=tuple(_files(report.outputs)),
        source=report.source,
        calls=report.calls,
        figures=report.figures,
        objective=report.objective,
        checks={"passed": passed, "warned": len(warned), "failed": len(failed)},
        problems=tuple(map(_summary, (*failed, *warned))),
        counts=counts(report.diagnostics),
        diagnostics=worst(report.diagnostics, whole=whole),
        advice=report.advice,
    )


def _paths(report: Report) -> dict[str, str]:
    roles = dict(ROLES)
    if _ROBOT in report.outputs:
        roles["robot"] = _ROBOT
    if report.preview:
        roles["picture"] = report.preview
    return {role: str(PurePath(report.folder, name)) for role, name in roles.items()}


def _files(outputs: Iterable[str]) -> list[str]:
    return [path for path in outputs if _ASSET_FOLDER not in PurePath(path).parts[:-1]]


def _summary(check: Check) -> CheckSummary:
    texts = check.code, check.name, check.level, check.detail
    return CheckSummary(*texts, len(check.findings), remedy(check.code))
