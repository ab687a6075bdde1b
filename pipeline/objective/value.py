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
from linkwright.pipeline.stages.stage import STAGES, libraries
from linkwright.stages.export.section import ExportSections
from linkwright.stages.validate.torque_value import torque_value

if TYPE_CHECKING:
    from linkwright.stages.robot.check import Check

VERSION = 1
"""Must be increased when a figure of the same robot changes."""

KEY = "objective"

CHECKS = "checks_failed"
"""The figure that needs the whole build."""


def require(plan: Plan) -> None:
    """Raises ConfigError if the build cannot compute the objective: it ends too early, or the user's own
    function cannot be found."""
    section = plan.objective
    if section is None:
        return
    if plan.until == "fetch":
        raise ConfigError("there is no robot before the graph stage", KEY, "until=graph, or a later stage")
    if CHECKS in section.names and plan.until != "validate":
        msg = f"checks_failed needs the validate stage, but the build ends with {plan.until}"
        raise ConfigError(msg, KEY, "until=validate, or another figure")
    if section.target and is_in_modules(section.target, plan.plugins):
        loader.cost(plan)


def objective(
    context: BuildContext, files: Mapping[str, bytes], checks: "Sequence[Check]"
) -> dict[str, float]:
    """Returns the numbers of the objective by their names, in the order of the configuration; {} without an
    objective. `files`: the robot's files; `checks`: the results of the checks. Raises ConfigError if a figure
    does not exist for this robot, or is not a finite number.
    """
    section_ = context.plan.objective
    if section_ is None:
        return {}
    from_checks = {CHECKS: float(sum(check.fails for check in checks))}
    torque = torque_value(checks)
    from_checks |= {} if torque is None else {"torque_margin": torque}
    values = (
        _user_numbers(context, section_)
        if section_.target
        else _figures(context, section_, files, from_checks)
    )
    for name, value in values.items():
        if not math.isfinite(value):
            raise ConfigError(f"{name} is {value}", KEY, "an objective must be a finite number")
    return values


def _figures(
    context: BuildContext,
    section_: ObjectiveSection,
    files: Mapping[str, bytes],
    from_checks: Mapping[str, float],
) -> dict[str, float]:
    plan, names = context.plan, [name for name in section_.names if name not in from_checks]
    key = {
        "figures": names,
        "robot": context.files["graph"].digests[ROBOT],
        "described": sha256(files["robot.json"]),
        "keys": section(plan, ExportSections),
        "payload": dict(plan.validate.payload),
    }
    export = next(stage for stage in STAGES if stage.name == "export")
    memo = context.cache.memo(KEY, VERSION, libraries(export))
    computed = json.loads(memo("figures", key, lambda: _computed(context, names, files["robot.json"])))
    return {name: from_checks[name] if name in from_checks else computed[name] for name in section_.names}


def _user_numbers(context: BuildContext, section_: ObjectiveSection) -> dict[str, float]:
    """Returns the numbers of the user's own function. They are cached if the text of its module is known."""
    text = loader.sources(context.plan.plugins)
    if text is None:
        return dict(json.loads(_computed(context)))
    key = {
        TARGET_KEY: section_.target,
        "args": section_.args,
        "robot": context.files["graph"].digests[ROBOT],
        "plugins": text,
    }
    return dict(json.loads(context.cache.memo(KEY, VERSION, {})("own", key, lambda: _computed(context))))


def _computed(context: BuildContext, names: Sequence[str] = (), described: bytes = b"") -> bytes:
    """Returns the figures of these `names` as JSON; with a user's own function, its result instead."""
    # Late: it imports the writers and the checks, which cached objectives do not need.
    from linkwright.pipeline.objective import figures

    plan, function = context.plan, loader.cost(context.plan)
    if function is not None and plan.objective is not None:
        return json.dumps(figures.figures_of_function(function, plan.objective, context.robot)).encode()
    return json.dumps(figures.figures(names, context.robot, plan, described)).encode()
