"""Computes the value of an objective: its numbers by name."""

import json
import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from linkwright.pipeline.config.files.trust import TARGET_KEY, is_in_modules
from linkwright.pipeline.config.objective_section import ObjectiveSection
from linkwright.pipeline.config.plan import Plan, section
from linkwright.pipeline.digest import sha256
from linkwright.pipeline.errors import ConfigError
from linkwright.pipeline.plugins import loader
from linkwright.pipeline.stages.context import ROBOT, BuildContext
from linkwright.pipeline.stages.stage import EXPORT, libraries
from linkwright.stages.export.section import ExportSections
from linkwright.stages.validate.torque_value import torque_value

if TYPE_CHECKING:
    from linkwright.stages.robot.check import Check

VERSION = 1
"""Version of the figures, a part of their cache keys: raise it when a figure of the same robot changes."""

KEY = "objective"

CHECKS_FIGURE = "checks_failed"
"""The figure that needs the whole build."""


def require(plan: Plan) -> None:
    """Raises ConfigError if the build cannot compute the objective: it ends too early, or the user's own
    function cannot be found."""
    objective_section = plan.objective
    if objective_section is None:
        return
    if plan.until == "fetch":
        raise ConfigError("there is no robot before the graph stage", KEY, "until=graph, or a later stage")
    if CHECKS_FIGURE in objective_section.names and plan.until != "validate":
        msg = f"checks_failed needs the validate stage, but the build ends with {plan.until}"
        raise ConfigError(msg, KEY, "until=validate, or another figure")
    if objective_section.target and is_in_modules(objective_section.target, plan.plugins):
        loader.objective_function(plan)


def objective(
    context: BuildContext, files: Mapping[str, bytes], checks: "Sequence[Check]"
) -> dict[str, float]:
    """Returns the numbers of the objective by their names, in the order of the configuration; {} without an
    objective. `files`: the robot's files; `checks`: the results of the checks. Raises ConfigError if a figure
    does not exist for this robot, or is not a finite number.
    """
    objective_section = context.plan.objective
    if objective_section is None:
        return {}
    check_figures = {CHECKS_FIGURE: float(sum(check.fails for check in checks))}
    torque = torque_value(checks)
    check_figures |= {} if torque is None else {"torque_margin": torque}
    values = (
        _user_numbers(context, objective_section)
        if objective_section.target
        else _figures(context, objective_section, files, check_figures)
    )
    for name, value in values.items():
        if not math.isfinite(value):
            raise ConfigError(f"{name} is {value}", KEY, "an objective must be a finite number")
    return values


def _figures(
    context: BuildContext,
    objective_section: ObjectiveSection,
    files: Mapping[str, bytes],
    check_figures: Mapping[str, float],
) -> dict[str, float]:
    plan, names = context.plan, [name for name in objective_section.names if name not in check_figures]
    key = {
        "figures": names,
        "robot": context.files["graph"].digests[ROBOT],
        "described": sha256(files["robot.json"]),
        "keys": section(plan, ExportSections),
        # torque_margin is measured on exported files.
        "export": EXPORT.version,
        "payload": dict(plan.validate.payload),
    }
    memo = context.cache.memo(KEY, VERSION, libraries(EXPORT))
    computed = json.loads(memo("figures", key, lambda: _compute(context, names, files["robot.json"])))
    return {
        name: check_figures[name] if name in check_figures else computed[name]
        for name in objective_section.names
    }


def _user_numbers(context: BuildContext, objective_section: ObjectiveSection) -> dict[str, float]:
    """Returns the numbers of the user's own function. They are cached if the text of its module is known."""
    sources = loader.sources_digest(context.plan.plugins)
    if sources is None:
        return dict(json.loads(_compute(context)))
    key = {
        TARGET_KEY: objective_section.target,
        "args": objective_section.args,
        "robot": context.files["graph"].digests[ROBOT],
        "plugins": sources,
    }
    # The function gets the robot of this version of Linkwright.
    memo = context.cache.memo(KEY, VERSION, libraries(EXPORT))
    return dict(json.loads(memo("own", key, lambda: _compute(context))))


def _compute(context: BuildContext, names: Sequence[str] = (), robot_json: bytes = b"") -> bytes:
    """Returns the figures of these `names` as JSON; with a user's own function, its result instead."""
    # Late: it imports the writers and the checks, which cached objectives do not need.
    from linkwright.pipeline.objective import figures

    plan, function = context.plan, loader.objective_function(context.plan)
    if function is not None and plan.objective is not None:
        return json.dumps(figures.figures_of_function(function, plan.objective, context.robot)).encode()
    return json.dumps(figures.figures(names, context.robot, plan, robot_json)).encode()
