"""Finds the smallest armature with which a robot stays whole and finite in a trial run.

Light links that whirl in closed loops turn so far in a time step that their speeds grow without end. An
armature slows them. It is added to the dofs of the group that fails first, which are all dofs that loops and
relations connect, in steps until the trial run passes. If that group can get no more, all other groups get
some. A dof that has an armature keeps it.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace

from linkwright.stages.mujoco.trial import Trial
from linkwright.stages.robot.dynamics.driven import with_actuation
from linkwright.stages.robot.dynamics.mass_matrix import SPEEDS, mass_matrix
from linkwright.stages.robot.errors import Diagnostic
from linkwright.stages.robot.model.actuation import Actuation, Armature
from linkwright.stages.robot.model.robot import Dof, Robot
from linkwright.stages.robot.motion.loops import POINTWISE_TYPES
from linkwright.stages.robot.motion.start_pose import home
from linkwright.stages.robot.motion.tree_paths import TreePaths
from linkwright.stages.robot.text.globs import name_list

INERTIA_SHARES = (1 / 64, 1 / 16, 1 / 4, 1.0, 4.0)
"""Armatures to try, as shares of the largest inertia that a dof of the group moves."""

SEPARATE_RUNS = 12
"""Number of trial runs in which groups get armatures one by one. In later runs all groups with an added
armature get at least as much as the failing group."""

MAX_RUNS = 24
"""Largest number of trial runs."""

REASON = "stability"
"""Reason of the added armatures in robot.json."""

TRIAL_MARGIN = 2.0
"""Added armatures must hold for this many times the duration, and keep loops this much better closed: such
motions are chaotic."""

Run = Callable[[Robot, Actuation, float], Trial | None]
"""A function that returns the trial run of a robot with its actuation and a margin, or None."""


def with_armatures(robot: Robot, actuation: Actuation, run: Run) -> tuple[Actuation, tuple[Diagnostic, ...]]:
    """Returns the actuation with the armatures that the robot needs, and their diagnostic. The actuation is
    unchanged if the robot needs no armature, or if no armature helps."""
    outcome = run(with_actuation(robot, actuation), actuation, 1.0)
    if outcome is None or not outcome.failed:
        return actuation, ()
    groups = _DofGroups(with_actuation(robot, actuation))
    levels: dict[int, int] = {}
    for run_index in range(MAX_RUNS):
        failing = [groups.of[name] for name in outcome.joints if name in groups.of]
        # If the group that fails can get no more, the links that whirl may be those of another group.
        higher = _higher_levels(levels, failing[:1]) or _higher_levels(levels, groups.of.values())
        if not higher:
            return actuation, ()
        levels |= higher
        if run_index >= SEPARATE_RUNS:
            levels = {group: max(level, *higher.values()) for group, level in levels.items()}
        added = groups.armatures({group: INERTIA_SHARES[level] for group, level in levels.items()})
        candidate = replace(actuation, armatures=_sorted(robot, (*actuation.armatures, *added)))
        outcome = run(with_actuation(robot, candidate), candidate, TRIAL_MARGIN)
        if outcome is None:
            return actuation, ()
        if not outcome.failed:
            return candidate, (_armature_diagnostic(added),)
    return actuation, ()


def _higher_levels(levels: Mapping[int, int], groups: Iterable[int]) -> dict[int, int]:
    """Returns the next level of each of these groups, without groups at the last level. `levels`: group →
    index of its share in `INERTIA_SHARES`."""
    next_levels = {group: levels.get(group, -1) + 1 for group in groups}
    return {group: level for group, level in next_levels.items() if level < len(INERTIA_SHARES)}


def _armature_diagnostic(armatures: Sequence[Armature]) -> Diagnostic:
    """Returns the diagnostic of the armatures that were added (W-ARMATURE)."""
    dofs = name_list(f"{armature.dof} ({armature.value:g})" for armature in armatures)
    text = f"unstable at this time step, so the smallest armature that stabilizes the robot was added: {dofs}"
    hint = (
        f"joints: {{{armatures[0].dof}: {{armature: ...}}}}, or damping, or a smaller scene.option.timestep"
    )
    return Diagnostic("W-ARMATURE", text, "joints", hint)


def _sorted(robot: Robot, armatures: Iterable[Armature]) -> tuple[Armature, ...]:
    """Returns armatures in the order of the dofs."""
    order = {dof.name: index for index, dof in enumerate(_simulated_dofs(robot))}
    return tuple(sorted(armatures, key=lambda armature: order[armature.dof]))


def _simulated_dofs(robot: Robot) -> list[Dof]:
    """Returns the dofs that the simulation has: those of the tree, and those of loops that are not closed by
    points alone."""
    carried = [loop for loop in robot.loops if loop.type not in POINTWISE_TYPES]
    return [*robot.dofs, *(dof for loop in carried for dof in loop.dofs)]


class _DofGroups:
    """The dofs in groups: dofs that loops and relations connect form a group, and any other dof is alone in
    its group. `of`: dof → index of its group, for groups with a dof that can get an armature."""

    def __init__(self, robot: Robot) -> None:
        dofs = _simulated_dofs(robot)
        groups_by_dof = {dof.name: {dof.name} for dof in dofs}
        paths = TreePaths(robot)
        for loop in robot.loops:
            _merge(groups_by_dof, [dof.name for dof in paths.dofs_of(loop) if dof.name in groups_by_dof])
        for relation in robot.relations:
            _merge(groups_by_dof, [relation.follower, relation.driver])
        # Connected dofs share one set object, so each set is listed once.
        self._groups = list({id(group): sorted(group) for group in groups_by_dof.values()}.values())
        self._inertias = _moved_inertias(robot)
        self._kinds = {dof.name: dof.kind for dof in dofs}
        self._without_armature = {
            dof.name for dof in dofs if dof.dynamics.armature is None and dof.kind != "free"
        }
        self.of = {
            name: index
            for index, group in enumerate(self._groups)
            for name in group
            if not self._without_armature.isdisjoint(group)
        }

    def armatures(self, shares: Mapping[int, float]) -> tuple[Armature, ...]:
        """Returns the armatures of groups. `shares`: index of a group → share of the largest inertia that a
        dof of the group moves. Turns and slides have separate largest inertias, in kg m² and in kg."""
        armatures = [
            Armature(name, float(f"{share * self._largest_inertia(group, name):.2g}"), REASON)
            for group, share in ((self._groups[index], share) for index, share in sorted(shares.items()))
            for name in group
            if name in self._without_armature
        ]
        return tuple(armature for armature in armatures if armature.value > 0)

    def _largest_inertia(self, group: Iterable[str], name: str) -> float:
        """Returns the largest inertia that the dofs of a group with the unit of the dof `name` move."""
        kinds, is_slide = self._kinds, self._kinds[name] == "slide"
        return max(
            self._inertias[member]
            for member in group
            if kinds[member] != "free" and (kinds[member] == "slide") == is_slide
        )


def _merge(groups: dict[str, set[str]], names: Iterable[str]) -> None:
    """Makes one group of the groups of these dofs. `groups`: dof → its group."""
    union: set[str] = set()
    for name in names:
        union |= groups[name]
    for name in union:
        groups[name] = union


def _moved_inertias(robot: Robot) -> dict[str, float]:
    """Returns the inertia that each dof moves at `home` [kg m² or kg]; for the dof of a loop, that of its
    first link."""
    matrix = mass_matrix(robot, home(robot))
    inertias, row = {}, 0
    for dof in robot.dofs:
        width = SPEEDS[dof.kind]
        inertias[dof.name] = max(float(matrix[i, i]) for i in range(row, row + width))
        row += width
    for loop in robot.loops:
        inertial = robot.link(loop.link_a).inertial
        # The axis of a turn is not considered: the mean of the moments stands for any axis.
        mean_moment = float(inertial.inertia.trace()) / 3
        for dof in loop.dofs:
            inertias[dof.name] = inertial.mass if dof.kind == "slide" else mean_moment
    return inertias
