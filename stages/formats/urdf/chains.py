"""Derives from the robot the links and joints of its URDF as a tree, by their names in the URDF."""

from collections.abc import Iterator
from dataclasses import dataclass

from linkwright.stages.formats.urdf.names import urdf_names
from linkwright.stages.robot.model.robot import Dof, Limits, Robot


@dataclass(frozen=True, slots=True)
class UrdfStep:
    """A joint of a URDF."""

    name: str
    parent: str
    child: str
    dof: Dof | None
    """The robot's dof that the joint is, or is a turn of; None for a fixed joint."""

    @property
    def moves(self) -> bool:
        """Whether an SRDF's group has a value of the joint: none has a value of a free joint."""
        return self.dof is not None and self.dof.kind != "free"

    @property
    def limits(self) -> Limits:
        """The limits of the joint's value; a ball's turns have none."""
        return self.dof.limits if self.dof is not None and self.dof.kind in ("turn", "slide") else Limits()


@dataclass(frozen=True, slots=True)
class UrdfChains:
    """The tree of a URDF."""

    root: str
    """The link without a parent."""

    joints: dict[str, UrdfStep]
    """The joints by name, parents first."""

    above: dict[str, UrdfStep]
    """Link → the joint that holds it."""

    @property
    def links(self) -> Iterator[str]:
        """The names of all links."""
        yield self.root
        yield from self.above

    def has(self, link: str) -> bool:
        """Tells whether a link of this name exists."""
        return link == self.root or link in self.above

    def up(self, tip: str) -> Iterator[UrdfStep]:
        """Yields the joints from a link up to the root."""
        while tip in self.above:
            yield self.above[tip]
            tip = self.above[tip].parent

    def between(self, base: str, tip: str) -> list[UrdfStep] | None:
        """Returns the joints from a link down to another; None if `base` is not above `tip`."""
        steps: list[UrdfStep] = []
        while tip != base:
            if tip not in self.above:
                return None
            steps.append(self.above[tip])
            tip = steps[-1].parent
        return steps[::-1]

    def base_of(self, tip: str) -> str:
        """Returns the link where the chain to a link begins: the nearest link above that floats, or the root.
        A floating link is its own beginning."""
        for step in self.up(tip):
            if step.dof is not None and step.dof.kind == "free":
                return step.child
        return self.root


def chains_of(written: Robot) -> UrdfChains:
    """Returns the chains of a URDF that describes the robot `written`."""
    steps = {step.name: step for step in _steps(written)}
    return UrdfChains(written.root.name, steps, {step.child: step for step in steps.values()})


def _steps(written: Robot) -> Iterator[UrdfStep]:
    """Yields the joints: those of the robot's joints, parents first, then those that hold frames and ends of
    loops."""
    names = urdf_names(written)
    for joint in written.joints:
        named_dofs: list[tuple[str, Dof | None]] = [(joint.name, None)] if not joint.dofs else []
        named_dofs += [(name, dof) for dof in joint.dofs for name in names.turns.get(dof.name, (dof.name,))]
        links = [joint.parent, *names.links_between[joint.name], joint.child]
        for (name, dof), parent, child in zip(named_dofs, links, links[1:], strict=False):
            yield UrdfStep(name, parent, child, dof)
    fixed = [(frame.link, names.frames[frame.name]) for frame in written.frames]
    for loop in written.loops:
        fixed += zip((loop.link_a, loop.link_b), names.ends[loop.name], strict=True)
    for parent, link in fixed:
        yield UrdfStep(names.holders[link], parent, link, None)
