"""Finds the keys whose values differ between the jobs of a sweep, and the figures that differ."""

import json
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from linkwright.pipeline.page.sweep.axis import Axis, categories, numbers

Job = Mapping[str, Any]
"""The outcome of a job as plain data (see `pipeline.sweep.outcome.Outcome`)."""

_QUANTITY = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*([A-Za-z°%]*)\s*")
"""The pattern of a number, perhaps with a unit."""

_RELATIVE_TOLERANCE = 1e-12
"""Figures whose difference is a smaller share of the largest count as equal."""


def keys(jobs: Sequence[Job]) -> list[str]:
    """Returns the overridden keys whose values differ between the jobs; all of them for a single job."""
    overridden = dict.fromkeys(key for job in jobs for key in job["overrides"])
    if len(jobs) < 2:
        return list(overridden)
    return [key for key in overridden if len({value_of(job, key) for job in jobs}) > 1]


def value_of(job: Job, key: str) -> str:
    """Returns a job's value of a key as text; "" if it has none."""
    if key not in job["overrides"]:
        return ""
    value = job["overrides"][key]
    return value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)


def values_of(job: Job, key_names: Sequence[str]) -> tuple[str, ...]:
    """Returns a job's values of several keys as texts."""
    return tuple(value_of(job, key) for key in key_names)


def places(key: str, jobs: Sequence[Job]) -> tuple[Axis, list[float]]:
    """Returns the axis of a key, and the position of each job on it: its value, if all values are numbers of
    the same unit, else the index of its category."""
    texts = [value_of(job, key) for job in jobs]
    matches = [_QUANTITY.fullmatch(words) for words in texts]
    units = {match[2] for match in matches if match}
    values = [float(match[1]) for match in matches if match]
    if len(values) == len(jobs) and len(units) == 1 and all(map(math.isfinite, values)):
        unit = units.pop()
        return numbers(f"{key}, {unit}" if unit else key, values, may_be_log=True), values
    names = list(dict.fromkeys(texts))
    return categories(key, [name or "–" for name in names]), [float(names.index(words)) for words in texts]


def figures_of(job: Job) -> dict[str, float]:
    """Returns the figures of a job, with the numbers of its checks that failed and that warn; {} unless the
    job was built."""
    if job["status"] not in (0, 3):
        return {}
    figures = {
        name: value
        for name, value in job["figures"].items()
        if isinstance(value, int | float) and math.isfinite(value)
    }
    if job["checks"]:
        figures |= {
            "checks_failed": len(job["checks"]["failed"]),
            "checks_warned": len(job["checks"]["warned"]),
        }
    return figures


def varying(jobs: Iterable[Job]) -> tuple[list[str], dict[str, float]]:
    """Returns the names of figures that differ between the jobs, and the figures that all jobs have in
    common, with their values."""
    rows = [row for job in jobs if (row := figures_of(job))]
    differing, common = [], {}
    for name in dict.fromkeys(name for row in rows for name in row):
        values = [row[name] for row in rows if name in row]
        if _differ(values) or len(values) < len(rows):
            differing.append(name)
        else:
            common[name] = values[0]
    return differing, common


def depends(jobs: Iterable[Job], figure: str, key: str, swept: Sequence[str]) -> bool:
    """Tells whether a figure differs anywhere between jobs whose other keys have the same values. Also true
    if no two jobs have the same values, since the figure may then depend on the key."""
    other_keys = [other for other in swept if other != key]
    groups: dict[tuple[str, ...], list[float]] = {}
    for job in jobs:
        figures = figures_of(job)
        if figure in figures:
            groups.setdefault(values_of(job, other_keys), []).append(figures[figure])
    return all(len(group) == 1 for group in groups.values()) or any(map(_differ, groups.values()))


def _differ(values: Sequence[float]) -> bool:
    return max(values) - min(values) > _RELATIVE_TOLERANCE * max(map(abs, values))
