"""The links and joints of a URDF as a tree, by their names there, as far as the robot says what they are."""

from collections.abc import Iterator
from dataclasses import dataclass

from linkwright.stages.formats.urdf.names import urdf_names
from linkwright.stages.robot.model.robot import Dof, Limits, Robot


@dataclass(frozen=True, slots=True)
class UrdfStep:
    """A joint of a URDF. `dof`: which of the robot's it is, or is a turn of; None where it is fixed."""

    name: str
    parent: str
    child: str
    dof: Dof | None

    @property
    def moves(self) -> bool:
        """Whether it has a value: of a free joint no group has one."""
        return self.dof is not None and self.dof.kind != "free"

    @property
    def limits(self) -> Limits:
        """Those of its value; a ball's turns have none."""
        own = self.dof is not None and self.dof.kind in ("turn", "slide")
        return self.dof.limits if own and self.dof is not None else Limits()


@dataclass(frozen=True, slots=True)
class UrdfChains:
    """`root`: the link that hangs on none; `joints`: by name, parents first; `above`: by link, the joint that
    holds it."""

    root: str
    joints: dict[str, UrdfStep]
    above: dict[str, UrdfStep]

    @property
    def links(self) -> Iterator[str]:
        yield self.root
        yield from self.above

    def has(self, link: str) -> bool:
        """Whether there is such a link."""
        return link == self.root or link in self.above

    def up(self, tip: str) -> Iterator[UrdfStep]:
        """The joints from a link up to the root."""
        while tip in self.above:
            yield self.above[tip]
            tip = self.above[tip].parent

    def between(self, base: str, tip: str) -> list[UrdfStep] | None:
        """The joints from one link down to another; None where the one is not above the other."""
        found: list[UrdfStep] = []
        while tip != base:
            if tip not in self.above:
                return None
            found.append(self.above[tip])
            tip = found[-1].parent
        return found[::-1]

    def base_of(self, tip: str) -> str:
        """Where the chain to a link begins: the root, or the link above it that flies on its own."""
        for step in self.up(tip):
            if step.dof is not None and step.dof.kind == "free":
                return step.child
        return self.root


def chains_of(written: Robot) -> UrdfChains:
    """Those of a URDF that describes the robot `written`."""
    steps = {step.name: step for step in _steps(written)}
    return UrdfChains(written.root.name, steps, {step.child: step for step in steps.values()})


def _steps(written: Robot) -> Iterator[UrdfStep]:
    names = urdf_names(written)
    for joint in written.joints:
        every: list[tuple[str, Dof | None]] = [(joint.name, None)] if not joint.dofs else []
        every += [(name, dof) for dof in joint.dofs for name in names.turns.get(dof.name, (dof.name,))]
        links = [joint.parent, *names.between[joint.name], joint.child]
        for (name, dof), parent, child in zip(every, links, links[1:], strict=False):
            yield UrdfStep(name, parent, child, dof)
    fixed = [(frame.link, names.frames[frame.name]) for frame in written.frames]
    for loop in written.loops:
        fixed += zip((loop.link_a, loop.link_b), names.ends[loop.name], strict=True)
    for parent, link in fixed:
        yield UrdfStep(names.holders[link], parent, link, None)
