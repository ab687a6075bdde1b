"""What a sweep swept: the keys whose values differ between its jobs, and the figures that differ too."""

import json
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from linkwright.pipeline.page.sweep.axis import Axis, categories, numbers

Job = Mapping[str, Any]
"""The outcome of a job as plain data (see `pipeline.sweep.outcome.Outcome`)."""

_QUANTITY = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*([A-Za-z°%]*)\s*")

_LEAST_DIFFERENCE = 1e-12
"""Figures whose values lie nearer together, as a share of the largest, are the same."""


def keys(jobs: Sequence[Job]) -> list[str]:
    """The overridden keys whose values differ between the jobs; of one job all."""
    every = dict.fromkeys(key for job in jobs for key in job["overrides"])
    if len(jobs) < 2:
        return list(every)
    return [key for key in every if len({value_of(job, key) for job in jobs}) > 1]


def value_of(job: Job, key: str) -> str:
    """The value that a job has for a key, as text; "" for none."""
    if key not in job["overrides"]:
        return ""
    value = job["overrides"][key]
    return value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)


def values_of(job: Job, some: Sequence[str]) -> tuple[str, ...]:
    """The values that a job has for some keys."""
    return tuple(value_of(job, key) for key in some)


def places(key: str, jobs: Sequence[Job]) -> tuple[Axis, list[float]]:
    """The axis of a key, and where each of the jobs stands on it: by its number, if all are numbers of one
    unit, else by its category."""
    texts = [value_of(job, key) for job in jobs]
    found = [_QUANTITY.fullmatch(words) for words in texts]
    units = {match[2] for match in found if match}
    values = [float(match[1]) for match in found if match]
    if len(values) == len(jobs) and len(units) == 1 and all(map(math.isfinite, values)):
        unit = units.pop()
        return numbers(f"{key}, {unit}" if unit else key, values, may_be_log=True), values
    names = list(dict.fromkeys(texts))
    return categories(key, [name or "–" for name in names]), [float(names.index(words)) for words in texts]


def figures_of(job: Job) -> dict[str, float]:
    """The figures of a job that was built, with how many of its checks failed and warn; none of another."""
    if job["status"] not in (0, 3):
        return {}
    found = {
        name: value
        for name, value in job["figures"].items()
        if isinstance(value, int | float) and math.isfinite(value)
    }
    if job["checks"]:
        found |= {
            "checks_failed": len(job["checks"]["failed"]),
            "checks_warned": len(job["checks"]["warned"]),
        }
    return found


def varying(jobs: Iterable[Job]) -> tuple[list[str], dict[str, float]]:
    """The figures that differ between the jobs, and those that all have in common with their values."""
    rows = [row for job in jobs if (row := figures_of(job))]
    differing, same = [], {}
    for name in dict.fromkeys(name for row in rows for name in row):
        values = [row[name] for row in rows if name in row]
        if _differ(values) or len(values) < len(rows):
            differing.append(name)
        else:
            same[name] = values[0]
    return differing, same


def depends(jobs: Iterable[Job], figure: str, key: str, swept: Sequence[str]) -> bool:
    """Whether a figure differs anywhere between jobs whose other keys have the same values; where no two jobs
    have these, nobody knows, and it may."""
    others = [one for one in swept if one != key]
    groups: dict[tuple[str, ...], list[float]] = {}
    for job in jobs:
        found = figures_of(job)
        if figure in found:
            groups.setdefault(values_of(job, others), []).append(found[figure])
    return all(len(group) == 1 for group in groups.values()) or any(map(_differ, groups.values()))


def _differ(values: Sequence[float]) -> bool:
    return max(values) - min(values) > _LEAST_DIFFERENCE * max(map(abs, values))
