"""Converts a verdict to JSON and back: the reply of the guest process."""

import json
from dataclasses import asdict
from typing import Any

from linkwright.pipeline.checking.verdict import Verdict
from linkwright.stages.robot.check import Check, Finding


def dump(verdict: Verdict) -> bytes:
    """Returns a verdict as JSON, without its baseline, and without the tables of its checks: no output of
    `check` has them."""
    header = {
        "place": verdict.place,
        "folder": verdict.folder,
        "robot": verdict.robot,
        "level": verdict.level,
    }
    checks = [{**asdict(check), "table": None} for check in verdict.checks]
    return json.dumps({**header, "notes": verdict.notes, "checks": checks}, default=float).encode()


def load(data: bytes) -> Verdict:
    """Reads the verdict that `dump` wrote. Raises ValueError, KeyError or TypeError for other data."""
    record = json.loads(data)
    return Verdict(
        place=str(record["place"]),
        folder=str(record["folder"]),
        robot=str(record["robot"]),
        level=str(record["level"]),
        checks=tuple(map(_check, record["checks"])),
        notes=tuple(map(str, record["notes"])),
    )


def _check(record: dict[str, Any]) -> Check:
    if record["level"] not in ("error", "warning"):
        raise ValueError(record["level"])
    return Check(
        name=str(record["name"]),
        passed=bool(record["passed"]),
        detail=str(record["detail"]),
        value=_number(record["value"]),
        limit=_number(record["limit"]),
        code=str(record["code"]),
        level=record["level"],
        findings=tuple(
            Finding(*(str(finding[key]) for key in ("element", "attribute", "message")))
            for finding in record["findings"]
        ),
    )


def _number(value: Any) -> float | None:
    return None if value is None else float(value)
