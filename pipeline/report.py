"""The report of a build: `Report`, and its JSON."""

import json
import os
import platform
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any, Literal

from linkwright.pipeline.output.manifest import REPORT
from linkwright.pipeline.secrets import Secrets
from linkwright.stages.robot.check import Check
from linkwright.stages.robot.errors import Diagnostic
from linkwright.stages.robot.system.install import installed
from linkwright.stages.robot.text.printable import printable_lines

Status = Literal["built", "stale", "invalid", "failed"]


@dataclass(frozen=True, slots=True)
class StageReport:
    """One stage of a build: whether its result came from the cache, its time [s], its outputs."""

    name: str
    cached: bool
    seconds: float
    outputs: str


@dataclass(frozen=True, slots=True)
class Report:
    """Everything about one build.

    `status`: built (exit status 0), stale (built and valid, but from an older state, since the API quota is
    used up: 3), invalid (built, but a check failed: 3) or failed (1 or 2).
    `source`: its kind and the pinned version. `calls`: API calls `made`, and `saved` by the cache;
    after a call also `counted_this_year` (by the ledger of this key), `remaining` (calls in the server's
    windows by kind of request, as it reported), `served` (its API versions and release) and `waited`
    (seconds, at the server's request).
    `bundle`: the inputs, by the SHA-256 of their `manifest`, by which `linkwright bundle` finds them.
    `figures`: counts of links, joints, dofs, loops, parts, meshes and triangles, the mass [kg], with
    `validate=strict` MuJoCo's `steps_per_second` on one thread of the machine that built it, and how
    the mechanism moves: `coordinates`, `gruebler` and `dof` (see `stages.robot.model.robot.Mobility`).
    `details`: tables of the stages, each a list of rows: `colliders`, `links`, `excludes` and
    `touching` (see `pipeline.mesh_details.details`), and the `order` of joints, actuators and sensors
    (see `stages.export.order_tables`), and what other `readers` drop (see `stages.export.readers`).
    `outline`: the lines of the kinematic tree as text; `narrow_outline`: the same for a terminal, which no
    file has. `outputs`: SHA-256 of each file of the robot, by
    path below `folder` ("" for a build in memory). `error`: of a failed build, its class, message, place,
    hint and problems.
    `title`: the assembly's name, where a reply has it and the user gave the robot no name.
    `advice`: what to try next; "" for nothing. `preview`: the robot's picture, below `folder`; "" for none.
    """

    status: Status
    name: str
    folder: str
    until: str
    exit_status: int
    source: Mapping[str, Any] = field(default_factory=dict)
    calls: Mapping[str, Any] = field(default_factory=lambda: {"made": 0, "saved": 0})
    bundle: Mapping[str, str] = field(default_factory=dict)
    stages: tuple[StageReport, ...] = ()
    figures: Mapping[str, float] = field(default_factory=dict)
    details: Mapping[str, Any] = field(default_factory=dict)
    diagnostics: tuple[Diagnostic, ...] = ()
    checks: tuple[Check, ...] = ()
    outline: tuple[str, ...] = ()
    narrow_outline: tuple[str, ...] = ()
    outputs: Mapping[str, str] = field(default_factory=dict)
    versions: Mapping[str, str] = field(default_factory=dict)
    error: Mapping[str, Any] | None = None
    title: str = ""
    advice: str = ""
    preview: str = ""

    @property
    def heading(self) -> str:
        """The robot's name, with the assembly's name where the user gave none."""
        return f"{self.name} ({self.title})" if self.title else self.name

    def tree(self) -> dict[str, Any]:
        """The report as plain data. Its own mappings are not copied: a big robot's details are large."""
        tree = _shallow(self)
        del tree["narrow_outline"]
        return tree | {
            "stages": [_shallow(stage) for stage in self.stages],
            "diagnostics": [_shallow(one) for one in self.diagnostics],
            "checks": [_check(check) for check in self.checks],
        }

    def to_json(self, secrets: Secrets | None = None) -> bytes:
        """The content of `report.json`, with secrets blanked."""
        tree = {REPORT: 1, **self.tree()}
        blanked = secrets.within(tree) if secrets else tree
        return printable_lines(json.dumps(blanked, indent=2, ensure_ascii=False)).encode() + b"\n"

    @property
    def failed_checks(self) -> tuple[Check, ...]:
        """The checks that prove the robot wrong."""
        return tuple(check for check in self.checks if check.fails)

    @property
    def warned_checks(self) -> tuple[Check, ...]:
        """The checks that say that something could be better."""
        return tuple(check for check in self.checks if check.warns)


def _shallow(value: Any) -> dict[str, Any]:
    """The fields of a dataclass as they are."""
    return {one.name: getattr(value, one.name) for one in fields(value)}


def _check(check: Check) -> dict[str, Any]:
    table = None if check.table is None else _shallow(check.table)
    return _shallow(check) | {"findings": [_shallow(one) for one in check.findings], "table": table}


def spent(report: Report) -> list[str]:
    """A line about the API calls of a build; no line without any."""
    made, saved = report.calls.get("made", 0), report.calls.get("saved", 0)
    if not made and not saved:
        return []
    year = report.calls.get("counted_this_year")
    so_far = "" if year is None else f"; {year} of this key counted this year"
    return [f"{made} API call{'' if made == 1 else 's'} made, {saved} saved by the cache{so_far}"]


def failure_lines(report: Report, folder: Path | None) -> list[str]:
    """The lines after the error of a failed build: its calls, its source, and its report below `folder`."""
    url = report.source.get("url")
    return [
        *spent(report),
        *([f"source: {url}"] if url else []),
        *([f"report: {Path(os.path.relpath(folder)) / 'report.html'}"] if folder else []),
    ]


def versions(libraries: Mapping[str, str]) -> dict[str, str]:
    """Versions of linkwright, of Python and of the libraries that made the result."""
    return {"linkwright": installed("linkwright"), "python": platform.python_version(), **libraries}
