"""Reads the mechanism of a source, and finds the problems that end its build."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from linkwright.pipeline.caching import actions
from linkwright.pipeline.config.plan import Plan
from linkwright.stages.fetch import survey as fetch_mechanism
from linkwright.stages.fetch.onshape.api.ledger import FOLDER as LEDGER
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
"""Masses for an assembly whose mass properties were not fetched, so that the graph stage can run."""


@dataclass(frozen=True, slots=True)
class FetchedMechanism:
    """A source as far as its mechanism needs it."""

    bundle: Bundle
    title: str
    """The name of the assembly's tab, if a reply has it."""
    calls: int
    """API calls that count against the quota."""
    saved: int
    """API calls that cached replies saved."""
    weighed: bool
    """Whether the bundle has the masses of all parts."""

    @property
    def studios(self) -> int:
        """The number of part studios; 0 for a robot's own file."""
        return len(self.bundle.studios) if isinstance(self.bundle, OnshapeBundle) else 0


@dataclass(frozen=True, slots=True)
class MechanismSurvey:
    """The robot of a source, and the problems that end its build."""

    robot: Robot | None
    """The robot, in spite of loose parts and missing masses; None if the graph stage cannot make any."""
    problems: tuple[Diagnostic, ...]
    """The problems with which the graph stage of a build ends, as far as they can be known."""


def fetched_mechanism(
    plan: Plan, environ: Mapping[str, str], progress: Callable[[str], None], *, masses: bool
) -> FetchedMechanism:
    """Fetches the mechanism of the plan's source; with `masses` also the mass properties of its parts. Raises
    the errors of `stages.fetch.survey`."""
    calls = Calls()
    with actions.opened(plan.cache.mode, plan.cache.dir, environ) as cache:
        context = FetchContext(
            cache.replies(),
            environ,
            progress=progress,
            ledger=actions.folder(plan.cache.dir, environ) / LEDGER,
            calls=calls,
        )
        fetched = fetch_mechanism(plan, context, masses=masses)
    weighed = masses or plan.source.kind != "onshape"
    return FetchedMechanism(fetched.bundle, fetched.title, calls.made, calls.saved, weighed)


def surveyed(mechanism: FetchedMechanism, plan: Plan) -> MechanismSurvey:
    """Runs the graph stage of the plan. If it ends with problems, it runs again without what loose parts and
    missing masses would end, so that the joints are known all the same."""
    strict = plan if mechanism.weighed else plan.model_copy(update={"mass": PLACEHOLDER_MASSES})
    robot, problems = _built(mechanism.bundle, strict)
    problems = tuple(problem for problem in problems if problem.message != NO_TRIANGLES)
    if robot is None:
        lenient: dict[str, Any] = {"root": plan.root.model_copy(update={"disconnected": "weld"})}
        if isinstance(mechanism.bundle, OnshapeBundle):
            lenient["mass"] = PLACEHOLDER_MASSES
        robot, _ = _built(mechanism.bundle, plan.model_copy(update=lenient))
    return MechanismSurvey(robot, problems)


def _built(bundle: Bundle, plan: Plan) -> tuple[Robot | None, tuple[Diagnostic, ...]]:
    """Returns the robot, or None and the problems that end the graph stage."""
    try:
        return build_robot(bundle, plan), ()
    except AssemblyError as error:
        # An error that ends the stage at once has no code (stages/DIAGNOSTICS.md).
        uncoded = Diagnostic("", error.message, error.where, error.hint)
        return None, error.problems or (uncoded,)
