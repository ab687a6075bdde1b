"""Checks the parameters of CoACD, and combines them with the effort of the search."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields, replace
from typing import Any

from linkwright.stages.robot.errors import ConfigError
from linkwright.stages.robot.text.globs import did_you_mean

_TOLERANCES_IN_THRESHOLD = 2.0
"""CoACD's default threshold, in tolerances: CoACD measures the largest distance anywhere, while a collider is
judged by 95 % of its surface."""

_RANGES: Mapping[str, tuple[float, float]] = {
    "max_convex_hull": (-1, 1000),
    "preprocess_resolution": (5, 1000),
    "resolution": (100, 100_000),
    "mcts_nodes": (2, 100),
    "mcts_iterations": (1, 10_000),
    "mcts_max_depth": (1, 7),
    "max_ch_vertex": (4, 10_000),
    "extrude_margin": (0.0, 1.0),
    "seed": (0, 2**31 - 1),
}
"""Smallest and largest value: beyond them CoACD ends its process, or never returns."""

_CHOICES: Mapping[str, tuple[str, ...]] = {
    "preprocess_mode": ("auto", "on", "off"),
    "apx_mode": ("ch", "box"),
}
"""The values of the parameters that are words."""

_BOOLEANS = frozenset({"pca", "merge", "decimate", "extrude", "real_metric"})


@dataclass(frozen=True, slots=True)
class CoacdParameters:
    """CoACD's parameters, by its names (https://github.com/SarahWeiii/CoACD).

    `merge` is off because `PieceCutter` merges the pieces, by the volume that merging adds: with 8 pieces,
    the error is half that of CoACD's merging.
    """

    threshold: float | None = None
    """None: twice the tolerance, in metres (`real_metric`)."""
    max_convex_hull: int = -1
    preprocess_mode: str = "auto"
    preprocess_resolution: int = 50
    resolution: int = 1000
    mcts_nodes: int = 10
    mcts_iterations: int = 30
    mcts_max_depth: int = 2
    pca: bool = False
    merge: bool = False
    decimate: bool = False
    max_ch_vertex: int = 256
    extrude: bool = False
    extrude_margin: float = 0.01
    apx_mode: str = "ch"
    seed: int = 0
    real_metric: bool = False

    def arguments(self, tolerance: float) -> dict[str, Any]:
        """Returns the arguments of `coacd.run_coacd` for a tolerance [m] and a closed mesh."""
        arguments = asdict(self)
        if self.threshold is None:
            arguments.update(threshold=_TOLERANCES_IN_THRESHOLD * tolerance, real_metric=True)
        # `auto` is `off`, since the mesh is closed already.
        return arguments | {"preprocess_mode": "on" if self.preprocess_mode == "on" else "off"}


EFFORTS: Mapping[str, CoacdParameters] = {
    "low": CoacdParameters(mcts_iterations=15),
    "normal": CoacdParameters(),
    "high": CoacdParameters(mcts_nodes=20, mcts_iterations=100, mcts_max_depth=3, resolution=2000),
}
"""Parameters of each `mesh.effort`."""


def coacd_parameters(effort: str, parameters: Mapping[str, Any]) -> CoacdParameters:
    """Returns the parameters of an effort, overridden by the user's; raises ConfigError for an unknown or
    invalid parameter."""
    names = [parameter.name for parameter in fields(CoacdParameters)]
    for name, value in parameters.items():
        where = f"mesh.coacd.{name}"
        if name not in names:
            hint = did_you_mean(name, names) or f"there are {', '.join(names)}"
            raise ConfigError("CoACD has no such parameter", where, hint)
        problem = _problem(name, value)
        if problem:
            raise ConfigError(f"{value!r} is {problem}", where)
    result = replace(EFFORTS[effort], **parameters)
    if result.threshold is not None and not result.real_metric and not 0.01 <= result.threshold <= 1.0:
        msg = f"{result.threshold:g} is not between 0.01 and 1"
        raise ConfigError(msg, "mesh.coacd.threshold", "with real_metric: true it is a length in metres")
    if result.max_convex_hull > 0 and not result.merge:
        raise ConfigError("it needs merge: true", "mesh.coacd.max_convex_hull", "or leave it out")
    return result


def _problem(name: str, value: Any) -> str:
    """Returns in words what is wrong with a parameter's value; "" for a valid value."""
    if name == "threshold":
        good = isinstance(value, int | float) and not isinstance(value, bool) and 0 < value < math.inf
        return "" if good or value is None else "not a positive number"
    if name in _CHOICES:
        return "" if value in _CHOICES[name] else f"not one of {', '.join(_CHOICES[name])}"
    if name in _BOOLEANS:
        return "" if isinstance(value, bool) else "neither true nor false"
    if isinstance(value, bool) or not isinstance(value, int | float if name == "extrude_margin" else int):
        return "not a number" if name == "extrude_margin" else "not a whole number"
    low, high = _RANGES[name]
    return "" if low <= value <= high else f"not between {low:g} and {high:g}"
