"""Reads the mechanism of a source, and finds the problems that end its build."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from linkwright.pipeline.caching import actions
from linkwright.pipeline.config.plan import Plan
from linkwright.stages import fetch
from linkwright.stages.fetch.onshape.api.ledger import FOLDER as LEDGER_FOLDER
from linkwright.stages.fetch.source import Calls, FetchContext
from linkwright.stages.graph import build_robot
from linkwright.stages.graph.mass_section import LinkMassSection, MassSection
from linkwright.stages.graph.onshape.mass.part_mass import NO_TRIANGLES
from linkwright.stages.robot.bundle import Bundle, OnshapeBundle
from linkwright.stages.robot.errors import AssemblyError, Diagnostic
from linkwright.stages.robot.model.robot import Robot

PLACEHOLDER_MASSES = MassSection(
    missing="ignore",
    links={"*": LinkMassSection(mass=1.0, com=(0.0, 0.0, 0.0), inertia=(1.0, 1.0, 1.0))},
)
"""Masses of links whose mass properties are unknown, so that the graph stage can run."""


@dataclass(frozen=True, slots=True)
class FetchedMechanism:
    """The content of a source that describes its mechanism."""

    bundle: Bundle
    title: str
    """The name of the assembly's tab, if a reply has it."""
    call_count: int
    """Number of API calls that count against the quota."""
    saved_call_count: int
    """Number of API calls that cached replies saved."""
    has_masses: bool
    """Whether the bundle has the mass properties of its parts."""

    @property
    def studio_count(self) -> int:
        """The number of part studios; 0 for a source that is not Onshape's."""
        return len(self.bundle.studios) if isinstance(self.bundle, OnshapeBundle) else 0


@dataclass(frozen=True, slots=True)
class MechanismSurvey:
    """The robot of a source, and the problems that end its build."""

    robot: Robot | None
    """The robot, if necessary with welded loose parts and placeholder masses; None if the graph stage fails
    even with these."""
    problems: tuple[Diagnostic, ...]
    """The problems that will end the graph stage of a build, as far as they are known without the
    triangles."""


def fetch_mechanism(
    plan: Plan, environ: Mapping[str, str], progress: Callable[[str], None], *, with_masses: bool
) -> FetchedMechanism:
    """Fetches the mechanism of the plan's source. `with_masses`: whether the mass properties of its parts are
    fetched too. Raises the errors of `stages.fetch.survey`."""
    call_counts = Calls()
    with actions.opened(plan.cache.mode, plan.cache.dir, environ) as cache:
        context = FetchContext(
            cache.replies(),
            environ,
            progress=progress,
            ledger=actions.folder(plan.cache.dir, environ) / LEDGER_FOLDER,
            calls=call_counts,
        )
        fetched = fetch.survey(plan, context, masses=with_masses)
    # Sources other than Onshape are fetched whole.
    has_masses = with_masses or plan.source.kind != "onshape"
    return FetchedMechanism(fetched.bundle, fetched.title, call_counts.made, call_counts.saved, has_masses)


def survey_mechanism(mechanism: FetchedMechanism, plan: Plan) -> MechanismSurvey:
    """Runs the graph stage of the plan. If it ends with problems, it runs again with welded loose parts and
    placeholder masses, so that the joints of the robot are known even then."""
    mass_changes = {} if mechanism.has_masses else {"mass": PLACEHOLDER_MASSES}
    robot, problems = _robot_or_problems(mechanism.bundle, plan.model_copy(update=mass_changes))
    # The build itself fetches the triangles that are missing here.
    problems = tuple(problem for problem in problems if problem.message != NO_TRIANGLES)
    if robot is None:
        substitutes: dict[str, Any] = {"root": plan.root.model_copy(update={"disconnected": "weld"})}
        if isinstance(mechanism.bundle, OnshapeBundle):
            substitutes["mass"] = PLACEHOLDER_MASSES
        robot, _ = _robot_or_problems(mechanism.bundle, plan.model_copy(update=substitutes))
    return MechanismSurvey(robot, problems)


def _robot_or_problems(bundle: Bundle, plan: Plan) -> tuple[Robot | None, tuple[Diagnostic, ...]]:
    """Returns the robot and no problems; or None and the problems that end the graph stage."""
    try:
        return build_robot(bundle, plan), ()
    except AssemblyError as error:
        # An error that ends the stage at once has no code (stages/DIAGNOSTICS.md).
        uncoded = Diagnostic("", error.message, error.where, error.hint)
        return None, error.problems or (uncoded,)
