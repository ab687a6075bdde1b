"""A robot as a file has it: what a reader of a format gives to the checks of `stages.validate.same`.

Everything goes by the robot's own names, in SI, and counts as the robot counts it.
"""

from collections.abc import Iterable, Mapping, Set
from dataclasses import dataclass, field
from typing import Literal, Protocol

from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.robot.model.robot import Array, Configuration, Dof, Inertial, Joint, Loop, Robot
from linkwright.stages.validate.findings import few, named
from linkwright.stages.validate.model.lumps import Lump

Tag = Literal["link", "joint", "frame", "relation"]

Numbers = Mapping[str, float | tuple[float, ...]]
"""By quantity. What has no limit is infinite."""


Names = Mapping[Tag, Set[str]]
"""Of links, joints and frames, as the file calls them."""


class UnreadableFile(Exception):
    """The file cannot be read as a robot. The message says why."""


@dataclass(frozen=True, slots=True)
class FormatWords:
    """What a format calls things. `mass`, `com`, `inertia`: of a link, the last the beginning of an entry's
    name; `moments`: of a format that has principal moments instead, and their axes. `axis`: of a joint;
    `place`: position and turn of what stands on something. `zero`: the value of a joint where the file
    starts, "" where no attribute has it. `mimic`: multiplier and offset. `numbers`: of a joint, by quantity;
    one that is missing is called as it is. `tags`: of elements, likewise."""

    mass: str
    com: str
    inertia: str
    axis: str
    place: tuple[str, str]
    mimic: tuple[str, str]
    numbers: Mapping[str, str]
    moments: tuple[str, str] | None = None
    zero: str = ""
    tags: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Precision:
    """How exact a format's files are: `mass` and `number`, relative; `pose` [m, rad], where `sized` relative
    to a robot that is larger than 1 m. `least`: the inertial of a link without mass, None for none."""

    mass: float = 1e-9
    pose: float = 1e-9
    number: float = 1e-9
    sized: bool = False
    least: Inertial | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Poses:
    """root_from_link and root_from_frame (4, 4), by name; NaN of what is missing."""

    links: Mapping[str, Array]
    frames: Mapping[str, Array]


@dataclass(frozen=True, slots=True, eq=False)
class FoundJoint:
    """A joint of the file. `name`: in a result; `element`: in a finding; `type`: its type, and `types` those
    that it may have. `dof`: the robot's, None of a joint that holds fast. `numbers`: what the file says;
    `wanted`: what it must say where that does not follow from the dof."""

    name: str
    element: str
    type: str
    types: tuple[str, ...]
    dof: Dof | None = None
    numbers: Numbers = field(default_factory=dict)
    wanted: Numbers = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class FoundMimic:
    """The value of the `follower` is multiplier · that of the `driver` + offset, where it is `active`."""

    follower: str
    driver: str
    multiplier: float
    offset: float
    active: bool = True


@dataclass(frozen=True, slots=True, eq=False)
class FoundPlace:
    """A pose (4, 4) that an element of the file has, and the one expected; None where there is no such
    element. `attributes`: position and turn."""

    element: str
    attributes: tuple[str, str]
    found: Array | None
    expected: Array


class ReadRobot(Protocol):
    """The robot that a file has, beside the robot that it must have. A reader has the attributes and the
    methods without a body; it has the others where its format differs."""

    file: str
    robot: Robot
    words: FormatWords
    precision: Precision = Precision()
    standing: Configuration
    """The values of the dofs at which the file is looked at first: where its links stand, or zero."""

    still: Configuration
    """Of dofs for which the file has no joint: the values at which it stands."""

    demands: frozenset[str] = frozenset()
    """Quantities for which the format has to have a number, also where the robot has none."""

    def lump(self, link: str) -> Lump:
        """The mass properties of a link, in its frame."""
        ...

    def poses(self, q: Configuration) -> Poses:
        """Where the links and frames are at these values."""
        ...

    def joints(self) -> Iterable[FoundJoint]:
        """The joint of each dof, and of each joint without any, of loops too where the format has these."""
        ...

    def places(self, loop: Loop, q: Configuration) -> Iterable[FoundPlace]:
        """What the file has of a loop at these values, as far as its joints are not the robot's."""
        ...

    def parent(self, link: str) -> str:
        """The link that carries another; "" where none of the robot's does."""
        ...

    def found(self) -> Names:
        """What the file has; nothing where another check looks for each name."""
        return {}

    def expected(self) -> Names:
        """What it must have."""
        return {}

    def element(self, tag: Tag, name: str) -> str:
        """What a finding calls a link, the joint of a dof, a frame or a relation."""
        return named("joint" if tag == "relation" else tag, name)

    def placed(self, joint: Joint) -> str:
        """The element that says where the child of a joint stands."""
        return self.element("joint", joint.dofs[0].name if joint.dofs else joint.name)

    def mimics(self) -> Iterable[FoundMimic] | None:
        """What follows what; None where checks of the format alone compare that."""
        return None

    def axis(self, dof: Dof) -> Array | None:
        """The axis (3,) of a turn or slide in the axes of its child; None where the file has others."""
        return None

    def zero(self, dof: Dof) -> tuple[float, float] | None:
        """Of a format that has such an attribute: the value of a joint where the file starts, and the one
        expected."""
        return None

    def odd_masses(self) -> Iterable[tuple[str, float, Finding]]:
        """(name, mass [kg], finding) of what has a mass that it must not have."""
        return ()

    def axes_error(self, size: float) -> float:
        """The error that an engine adds to a tensor whose largest entry is this [kg m²], relative."""
        return 0.0

    def first_checks(self) -> Iterable[Check]:
        """Checks of its format alone, whatever names the file has."""
        return ()

    def own_checks(self) -> Iterable[Check]:
        """Checks of its format alone, where nothing is missing."""
        return ()

    def found_none(self, name: str, detail: str, findings: Iterable[Finding]) -> Check:
        """The result of a check that passes where nothing is found."""
        found = list(findings)
        return self.within(name, float(len(found)), 0.0, detail, found)

    def within(
        self, name: str, value: float, limit: float, detail: str, findings: Iterable[Finding] = ()
    ) -> Check:
        """The result of a check that passes where `value` is at most `limit`."""
        passed = value <= limit
        found = () if passed else few(findings)
        return Check(f"{self.file}: {name}", passed, detail, value, limit, findings=found)
