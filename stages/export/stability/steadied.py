"""The least armature with which a robot stays whole and finite in a trial run.

Light links that whirl in closed loops turn so far in a time step that their speeds grow without end. An
armature slows them. It is added to the dofs of the group that fails first, all dofs that loops and relations
connect, in steps until the trial run passes; where that group can get none, to all others. A dof that has an
armature keeps it.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace

from linkwright.stages.mujoco.trial import Trial
from linkwright.stages.robot.dynamics.driven import as_driven
from linkwright.stages.robot.dynamics.mass_matrix import SPEEDS, mass_matrix
from linkwright.stages.robot.errors import Diagnostic
from linkwright.stages.robot.model.actuation import Actuation, Armature
from linkwright.stages.robot.model.robot import Dof, Robot
from linkwright.stages.robot.motion.loops import POINTWISE
from linkwright.stages.robot.motion.start_pose import home
from linkwright.stages.robot.motion.tree_paths import Ways
from linkwright.stages.robot.text.globs import listed

SHARES = (1 / 64, 1 / 16, 1 / 4, 1.0, 4.0)
"""The armatures that are tried, as shares of the largest inertia that a dof of the group moves."""

ONE_BY_ONE = 12
"""Trial runs after which all groups that got an armature get as much as the one that fails."""

MOST_RUNS = 24
"""Trial runs after which none is tried any more."""

REASON = "stability"

MARGIN = 2.0
"""What is added must hold so much longer, and better, than is asked: such motions are chaotic."""

Run = Callable[[Robot, Actuation, float], Trial | None]
"""The trial run of a robot with what drives it, with a margin; None where there is none."""


def steadied(robot: Robot, actuation: Actuation, run: Run) -> tuple[Actuation, tuple[Diagnostic, ...]]:
    """The actuation with the armatures that the robot needs, and their diagnostic; unchanged where it needs
    none, or where none helps."""
    outcome = run(as_driven(robot, actuation), actuation, 1.0)
    if outcome is None or not outcome.failed:
        return actuation, ()
    groups = _Coupled(as_driven(robot, actuation))
    levels: dict[int, int] = {}
    for count in range(MOST_RUNS):
        failing = [groups.of[name] for name in outcome.joints if name in groups.of]
        # Where the joint that fails can get no more, what it moves or hangs on may be what whirls.
        higher = _higher(levels, failing[:1]) or _higher(levels, groups.of.values())
        if not higher:
            return actuation, ()
        levels |= higher
        if count >= ONE_BY_ONE:
            levels = {one: max(level, *higher.values()) for one, level in levels.items()}
        added = groups.armatures({one: SHARES[level] for one, level in levels.items()})
        steady = replace(actuation, armatures=_sorted(robot, (*actuation.armatures, *added)))
        outcome = run(as_driven(robot, steady), steady, MARGIN)
        if outcome is None:
            return actuation, ()
        if not outcome.failed:
            return steady, (_remark(added),)
    return actuation, ()


def _higher(levels: Mapping[int, int], numbers: Iterable[int]) -> dict[int, int]:
    """The next levels of these groups, of those that have one."""
    found = {number: levels.get(number, -1) + 1 for number in numbers}
    return {number: level for number, level in found.items() if level < len(SHARES)}


def _remark(added: Iterable[Armature]) -> Diagnostic:
    every = list(added)
    what = listed(f"{one.dof} ({one.value:g})" for one in every)
    text = f"unstable without an armature at this time step, so the least that holds was added: {what}"
    hint = f"joints: {{{every[0].dof}: {{armature: ...}}}}, or damping, or a smaller scene.option.timestep"
    return Diagnostic("W-ARMATURE", text, "joints", hint)


def _sorted(robot: Robot, armatures: Iterable[Armature]) -> tuple[Armature, ...]:
    order = {dof.name: number for number, dof in enumerate(_every(robot))}
    return tuple(sorted(armatures, key=lambda one: order[one.dof]))


def _every(robot: Robot) -> list[Dof]:
    """The dofs that the simulation has: those of the tree, and of loops that points alone do not close."""
    carried = [loop for loop in robot.loops if loop.type not in POINTWISE]
    return [*robot.dofs, *(dof for loop in carried for dof in loop.dofs)]


class _Coupled:
    """The dofs that loops and relations connect, by groups; any other dof is a group of its own. `of`: the
    number of a dof's group, for dofs of groups that can get an armature."""

    def __init__(self, robot: Robot) -> None:
        every = _every(robot)
        together = {dof.name: {dof.name} for dof in every}
        ways = Ways(robot)
        for loop in robot.loops:
            _merge(together, [dof.name for dof in ways.dofs_of(loop) if dof.name in together])
        for relation in robot.relations:
            _merge(together, [relation.follower, relation.driver])
        self._sets = list({id(group): sorted(group) for group in together.values()}.values())
        self._scale = _scales(robot)
        self._bare = {
            dof.name: dof.kind for dof in every if dof.dynamics.armature is None and dof.kind != "free"
        }
        self.of = {
            name: number
            for number, group in enumerate(self._sets)
            for name in group
            if any(one in self._bare for one in group)
        }

    def armatures(self, shares: Mapping[int, float]) -> tuple[Armature, ...]:
        """The armatures of groups, by number, as shares of the largest inertia of each kind of dof there."""
        found = []
        for number, share in sorted(shares.items()):
            group = self._sets[number]
            for name in group:
                if name not in self._bare:
                    continue
                alike = [
                    one for one in group if (self._kind(one) == "slide") == (self._kind(name) == "slide")
                ]
                most = max(self._scale.get(one, 0.0) for one in alike)
                found.append(Armature(name, float(f"{share * most:.2g}"), REASON))
        return tuple(one for one in found if one.value > 0)

    def _kind(self, name: str) -> str:
        return self._bare.get(name, "turn")


def _merge(together: dict[str, set[str]], names: Iterable[str]) -> None:
    every: set[str] = set()
    for name in names:
        every |= together[name]
    for name in every:
        together[name] = every


def _scales(robot: Robot) -> dict[str, float]:
    """By dof: the inertia that it moves at `home` [kg m² or kg]; of a loop's, that of the link it carries."""
    matrix = mass_matrix(robot, home(robot))
    found, at = {}, 0
    for dof in robot.dofs:
        width = SPEEDS[dof.kind]
        found[dof.name] = max(float(matrix[i, i]) for i in range(at, at + width))
        at += width
    for loop in robot.loops:
        inertial = robot.link(loop.link_a).inertial
        for dof in loop.dofs:
            mass, turn = inertial.mass, float(inertial.inertia.trace()) / 3
            found[dof.name] = mass if dof.kind == "slide" else turn
    return found
