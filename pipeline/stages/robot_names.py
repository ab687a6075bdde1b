"""Refuses names in the configuration that the robot does not have, before its meshes are made."""

from linkwright.pipeline.config.plan import Plan
from linkwright.pipeline.errors import as_problems
from linkwright.stages.export.unknown_names import unknown_names
from linkwright.stages.robot.errors import AssemblyError, ConfigError
from linkwright.stages.robot.model.robot import Robot
from linkwright.stages.validate.check_options import known_payload


def require_names(robot: Robot, plan: Plan) -> None:
    """Raises AssemblyError if the configuration names things that the robot does not have. The error lists
    all such names, including those that only the stages after the meshes would refuse."""
    problems = unknown_names(robot, plan) if plan.until in ("export", "validate") else []
    try:
        known_payload(robot, plan.validate.payload if plan.until == "validate" else {})
    except ConfigError as error:
        problems += as_problems(error)
    if problems:
        msg = "the configuration names things that the robot does not have"
        raise AssemblyError(
            msg, problems=sorted(problems, key=lambda problem: (problem.where, problem.message))
        )
