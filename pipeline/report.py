"""Defines the report of a build, and writes its JSON."""

import json
import os
import platform
import re
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any, Literal

from linkwright.pipeline.output.manifest import REPORT_KEY
from linkwright.pipeline.secrets import Secrets
from linkwright.stages.robot.check import Check
from linkwright.stages.robot.errors import Diagnostic
from linkwright.stages.robot.system.install import installed
from linkwright.stages.robot.text.printable import printable_lines

Status = Literal["built", "stale", "invalid", "failed"]


@dataclass(frozen=True, slots=True)
class StageReport:
    """A stage of a build: whether its result came from the cache, its time [s], and its outputs in words."""

    name: str
    cached: bool
    seconds: float
    outputs: str


@dataclass(frozen=True, slots=True)
class Report:
    """Everything about a build."""

    status: Status
    """built (exit status 0); stale (3): built and valid, but from an older state, since the API quota is used
    up; invalid (3): built, but a check failed; failed (1 or 2)."""
    name: str
    folder: str
    """The output folder; "" for a build in memory."""
    until: str
    exit_status: int
    source: Mapping[str, Any] = field(default_factory=dict)
    """The kind of the source, and the pinned version."""
    calls: Mapping[str, Any] = field(default_factory=lambda: {"made": 0, "saved": 0})
    """API calls `made`, and `saved` by the cache. After a call also `counted_this_year` (by the ledger of
    this key), `remaining` (calls in the server's windows by kind of request, as it reported), `served` (its
    API versions and release) and `waited` (seconds, at the server's request)."""
    bundle: Mapping[str, str] = field(default_factory=dict)
    """The inputs: the SHA-256 of their `manifest`, by which `linkwright bundle` finds them."""
    stages: tuple[StageReport, ...] = ()
    figures: Mapping[str, float] = field(default_factory=dict)
    """Numbers of links, joints, dofs, loops, parts, meshes and triangles; the mass [kg]; with
    `validate=strict` MuJoCo's `steps_per_second` on one thread of the machine that built it; and the
    mobility: `coordinates`, `gruebler` and `dof` (see `stages.robot.model.robot.Mobility`)."""
    objective: Mapping[str, float] = field(default_factory=dict)
    """The numbers of the objective by name; {} without an objective."""
    details: Mapping[str, Any] = field(default_factory=dict)
    """Tables of the stages: `colliders`, `links`, `excludes` and `touching` (see
    `pipeline.mesh_details.details`), the `order` of joints, actuators and sensors (see
    `stages.export.order_tables`), what other `readers` drop (see `stages.targets.things`), and what varies in
    the `variants` (see `stages.export.variants`)."""
    diagnostics: tuple[Diagnostic, ...] = ()
    checks: tuple[Check, ...] = ()
    outline: tuple[str, ...] = ()
    """The lines of the kinematic tree as text."""
    narrow_outline: tuple[str, ...] = ()
    """The outline for a terminal, which is in no file."""
    outputs: Mapping[str, str] = field(default_factory=dict)
    """SHA-256 of each file of the robot, by its path in `folder`."""
    versions: Mapping[str, str] = field(default_factory=dict)
    error: Mapping[str, Any] | None = None
    """For a failed build: the class of the error, its message, place, hint and problems."""
    title: str = ""
    """The assembly's name, if a reply has it and the user gave the robot no name."""
    advice: str = ""
    """A suggestion what to try next, or ""."""
    preview: str = ""
    """The path of the robot's picture in `folder`, or ""."""

    @property
    def heading(self) -> str:
        """The robot's name, followed by the assembly's name if the user gave the robot no name."""
        return f"{self.name} ({self.title})" if self.title else self.name

    def tree(self) -> dict[str, Any]:
        """Returns the report as plain data. Mappings are not copied, since a big robot's details are
        large."""
        tree = _shallow(self)
        del tree["narrow_outline"]
        return tree | {
            "stages": [_shallow(stage) for stage in self.stages],
            "diagnostics": [_shallow(diagnostic) for diagnostic in self.diagnostics],
            "checks": [_check(check) for check in self.checks],
        }

    def to_json(self, secrets: Secrets | None = None) -> bytes:
        """Returns the content of `report.json`, with secrets blanked."""
        tree = {REPORT_KEY: 1, **self.tree()}
        blanked = secrets.within(tree) if secrets else tree
        return printable_lines(json.dumps(blanked, indent=2, ensure_ascii=False)).encode() + b"\n"

    @property
    def failed_checks(self) -> tuple[Check, ...]:
        """The checks that show an error of the robot."""
        return tuple(check for check in self.checks if check.fails)

    @property
    def warned_checks(self) -> tuple[Check, ...]:
        """The checks that end with a warning."""
        return tuple(check for check in self.checks if check.warns)


def _shallow(value: Any) -> dict[str, Any]:
    """Returns the fields of a dataclass as they are."""
    return {field.name: getattr(value, field.name) for field in fields(value)}


def _check(check: Check) -> dict[str, Any]:
    table = None if check.table is None else _shallow(check.table)
    return _shallow(check) | {"findings": [_shallow(finding) for finding in check.findings], "table": table}


_PINNED_URL = re.compile(r"/documents/\w+/[vm]/")
"""Matches the address of a version or of a microversion."""


def call_lines(report: Report) -> list[str]:
    """Returns a line about the API calls of a build; [] if there were none."""
    made, saved = report.calls.get("made", 0), report.calls.get("saved", 0)
    if not made and not saved:
        return []
    year = report.calls.get("counted_this_year")
    remarks = "" if year is None else f"; {year} counted for this key this year"
    if not made and _PINNED_URL.search(report.source.get("url") or ""):
        remarks += "; source.url names a version, which no edit changes"
    return [f"{made} API call{'' if made == 1 else 's'} made, {saved} saved by the cache{remarks}"]


def failure_lines(report: Report, folder: Path | None) -> list[str]:
    """Returns the lines after the error of a failed build: its API calls, its source, and its report in
    `folder`."""
    url = report.source.get("url")
    return [
        *call_lines(report),
        *([f"source: {url}"] if url else []),
        *([f"report: {Path(os.path.relpath(folder)) / 'report.html'}"] if folder else []),
    ]


def versions(libraries: Mapping[str, str]) -> dict[str, str]:
    """Returns the versions of linkwright, of Python and of the libraries that made the result."""
    return {"linkwright": installed("linkwright"), "python": platform.python_version(), **libraries}
