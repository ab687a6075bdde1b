"""Finds the smallest armature with which a robot stays whole and finite in a trial run.

Light links that whirl in closed loops turn so far in a time step that their speeds grow without end. An
armature slows them. It is added to the dofs of the group that fails first, which are all dofs that loops and
relations connect, in steps until the trial run passes. If that group can get no more, all other groups get
some. A dof that has an armature keeps it.
"""

from collections.abc import Callable, Iterable, Mapping
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
"""Number of trial runs after which all groups with an added armature get as much as the failing group."""

MAX_RUNS = 24
"""Largest number of trial runs."""

REASON = "stability"

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
        # Where the joint that fails can get no more, what it moves or hangs on may be what whirls.
        higher = _higher(levels, failing[:1]) or _higher(levels, groups.of.values())
        if not higher:
            return actuation, ()
        levels |= higher
        if run_index >= SEPARATE_RUNS:
            levels = {group: max(level, *higher.values()) for group, level in levels.items()}
        added = groups.armatures({group: INERTIA_SHARES[level] for group, level in levels.items()})
        steady = replace(actuation, armatures=_sorted(robot, (*actuation.armatures, *added)))
        outcome = run(with_actuation(robot, steady), steady, TRIAL_MARGIN)
        if outcome is None:
            return actuation, ()
        if not outcome.failed:
            return steady, (_armature_diagnostic(added),)
    return actuation, ()


def _higher(levels: Mapping[int, int], numbers: Iterable[int]) -> dict[int, int]:
    """Returns the next levels of these groups, without groups at the last level."""
    raised = {number: levels.get(number, -1) + 1 for number in numbers}
    return {number: level for number, level in raised.items() if level < len(INERTIA_SHARES)}


def _armature_diagnostic(added: Iterable[Armature]) -> Diagnostic:
    armatures = list(added)
    dofs = name_list(f"{armature.dof} ({armature.value:g})" for armature in armatures)
    text = f"unstable at this time step, so the smallest armature that stabilizes the robot was added: {dofs}"
    hint = (
        f"joints: {{{armatures[0].dof}: {{armature: ...}}}}, or damping, or a smaller scene.option.timestep"
    )
    return Diagnostic("W-ARMATURE", text, "joints", hint)


def _sorted(robot: Robot, armatures: Iterable[Armature]) -> tuple[Armature, ...]:
    order = {dof.name: number for number, dof in enumerate(_simulated_dofs(robot))}
    return tuple(sorted(armatures, key=lambda armature: order[armature.dof]))


def _simulated_dofs(robot: Robot) -> list[Dof]:
    """Returns the dofs that the simulation has: those of the tree, and those of loops that are not closed by
    points alone."""
    carried = [loop for loop in robot.loops if loop.type not in POINTWISE_TYPES]
    return [*robot.dofs, *(dof for loop in carried for dof in loop.dofs)]


class _DofGroups:
    """The dofs in groups: those that loops and relations connect are a group, any other dof is its own. `of`:
    dof → index of its group, for groups that can get an armature."""

    def __init__(self, robot: Robot) -> None:
        dofs = _simulated_dofs(robot)
        groups_by_dof = {dof.name: {dof.name} for dof in dofs}
        paths = TreePaths(robot)
        for loop in robot.loops:
            _merge(groups_by_dof, [dof.name for dof in paths.dofs_of(loop) if dof.name in groups_by_dof])
        for relation in robot.relations:
            _merge(groups_by_dof, [relation.follower, relation.driver])
        self._sets = list({id(group): sorted(group) for group in groups_by_dof.values()}.values())
        self._scale = _scales(robot)
        self._bare = {
            dof.name: dof.kind for dof in dofs if dof.dynamics.armature is None and dof.kind != "free"
        }
        self.of = {
            name: number
            for number, group in enumerate(self._sets)
            for name in group
            if any(dof in self._bare for dof in group)
        }

    def armatures(self, shares: Mapping[int, float]) -> tuple[Armature, ...]:
        """Returns the armatures of groups. `shares`: index of a group → share of the largest inertia of each
        kind of dof in it."""
        armatures = []
        for number, share in sorted(shares.items()):
            group = self._sets[number]
            for name in group:
                if name not in self._bare:
                    continue
                same_kind = [
                    member
                    for member in group
                    if (self._kind(member) == "slide") == (self._kind(name) == "slide")
                ]
                largest = max(self._scale.get(member, 0.0) for member in same_kind)
                armatures.append(Armature(name, float(f"{share * largest:.2g}"), REASON))
        return tuple(armature for armature in armatures if armature.value > 0)

    def _kind(self, name: str) -> str:
        return self._bare.get(name, "turn")


def _merge(groups: dict[str, set[str]], names: Iterable[str]) -> None:
    union: set[str] = set()
    for name in names:
        union |= groups[name]
    for name in union:
        groups[name] = union


def _scales(robot: Robot) -> dict[str, float]:
    """Returns the inertia that each dof moves at `home` [kg m² or kg]; for the dof of a loop, that of its
    first link."""
    matrix = mass_matrix(robot, home(robot))
    scales, row = {}, 0
    for dof in robot.dofs:
        width = SPEEDS[dof.kind]
        scales[dof.name] = max(float(matrix[i, i]) for i in range(row, row + width))
        row += width
    for loop in robot.loops:
        inertial = robot.link(loop.link_a).inertial
        for dof in loop.dofs:
            # The axis of a turn is not looked at: the mean of the moments stands for any axis.
            mass, turn = inertial.mass, float(inertial.inertia.trace()) / 3
            scales[dof.name] = mass if dof.kind == "slide" else turn
    return scales
