"""Defines the robot that a format's reader reads from a file, for the comparisons in this package.

Names, units (SI) and zero positions are those of the robot, not of the file.
"""

from collections.abc import Iterable, Mapping, Set
from dataclasses import dataclass, field
from typing import Literal, Protocol

from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.robot.model.robot import Array, Configuration, Dof, Inertial, Joint, Loop, Robot
from linkwright.stages.validate.findings import few, named
from linkwright.stages.validate.model.mass_properties import MassProperties

ElementKind = Literal["link", "joint", "frame", "relation"]

Numbers = Mapping[str, float | tuple[float, ...]]
"""Numbers by quantity. A missing limit is infinite."""


Names = Mapping[ElementKind, Set[str]]
"""Names of links, joints and frames in the file."""


class UnreadableFile(Exception):
    """The file cannot be read as a robot. The message says why."""


@dataclass(frozen=True, slots=True)
class AttributeNames:
    """The names that a format gives to attributes, for findings."""

    mass: str
    """The mass of a link."""

    com: str
    """The centre of mass of a link."""

    inertia: str
    """The prefix of the names of the six entries of a link's inertia."""

    axis: str
    """The axis of a joint."""

    place: tuple[str, str]
    """The position and the orientation of an element."""

    mimic: tuple[str, str]
    """The multiplier and the offset of a mimic."""

    numbers: Mapping[str, str]
    """Quantity of a joint → attribute. Other quantities are called the same in the format."""

    moments: tuple[str, str] | None = None
    """The principal moments and their axes, for formats that write these."""

    zero: str = ""
    """The value of a joint at the start; "" if the format has no such attribute."""

    tags: Mapping[str, str] = field(default_factory=dict)
    """Kind of element → tag. Other kinds are called the same in the format."""


@dataclass(frozen=True, slots=True)
class Precision:
    """The tolerances for a format's rounding."""

    mass: float = 1e-9
    """Relative tolerance of mass properties."""

    pose: float = 1e-9
    """Tolerance of poses [m, rad]."""

    number: float = 1e-9
    """Relative tolerance of other numbers."""

    scales_with_size: bool = False
    """Whether `pose` scales with the size of a robot that is larger than 1 m."""

    massless_inertial: Inertial | None = None
    """The inertial that the format writes for a link without mass, if it has one."""


@dataclass(frozen=True, slots=True, eq=False)
class Poses:
    """root_from_link and root_from_frame (4, 4), by name; NaN for missing elements."""

    links: Mapping[str, Array]
    frames: Mapping[str, Array]


@dataclass(frozen=True, slots=True, eq=False)
class FoundJoint:
    """A joint of the file."""

    name: str
    """The joint's name in results."""

    element: str
    """The joint's title in findings."""

    type: str
    types: tuple[str, ...]
    """The accepted values of `type`."""

    dof: Dof | None = None
    """The robot's dof; None for a fixed joint."""

    numbers: Numbers = field(default_factory=dict)
    """The numbers in the file."""

    expected: Numbers = field(default_factory=dict)
    """The required numbers, as far as they do not follow from the dof."""


@dataclass(frozen=True, slots=True)
class FoundMimic:
    """A relation of two joints, if it is `active`: follower = multiplier · driver + offset."""

    follower: str
    driver: str
    multiplier: float
    offset: float
    active: bool = True


@dataclass(frozen=True, slots=True, eq=False)
class FoundPose:
    """The pose of an element of the file, and the pose that it must have."""

    element: str
    attributes: tuple[str, str]
    """The attributes of position and orientation."""

    pose: Array | None
    """The pose (4, 4) in the file; None if the element is missing."""

    expected: Array
    """The required pose (4, 4)."""


class ReadRobot(Protocol):
    """The robot of a file, and the robot that it must equal. A reader implements the attributes and the
    methods that have no body here, and overrides the others if its format differs."""

    file: str
    robot: Robot
    attribute_names: AttributeNames
    precision: Precision = Precision()
    file_configuration: Configuration
    """The dof values of the first comparison: those at which the file places the links, or zero."""

    fixed_dofs: Configuration
    """The dofs for which the file has no joint, with their values in the file's placement."""

    required_numbers: frozenset[str] = frozenset()
    """Quantities for which the format requires a number, even if the robot has no limit."""

    def mass_properties(self, link: str) -> MassProperties:
        """Returns the mass properties of a link, in its frame."""
        ...

    def poses(self, q: Configuration) -> Poses:
        """Returns the poses of links and frames at the values `q`."""
        ...

    def joints(self) -> Iterable[FoundJoint]:
        """Returns the joint of each dof, and the joints without dofs, as far as the format has them; those of
        loops too."""
        ...

    def loop_poses(self, loop: Loop, q: Configuration) -> Iterable[FoundPose]:
        """Yields the poses of the elements that close a loop, for closures that are not joints."""
        ...

    def parent(self, link: str) -> str:
        """Returns the robot's link that carries `link`; "" without such a link."""
        ...

    def names_found(self) -> Names:
        """Returns the names in the file; nothing if another check looks for each name."""
        return {}

    def names_expected(self) -> Names:
        """Returns the names that the file must have."""
        return {}

    def element(self, kind: ElementKind, name: str) -> str:
        """Returns the title, in findings, of a link, of the joint of a dof, of a frame or of a relation."""
        return named("joint" if kind == "relation" else kind, name)

    def placing_element(self, joint: Joint) -> str:
        """Returns the title of the element that places the child of a joint."""
        return self.element("joint", joint.dofs[0].name if joint.dofs else joint.name)

    def mimics(self) -> Iterable[FoundMimic] | None:
        """Returns the mimics of the file; None if only the checks of the format compare them."""
        return None

    def axis(self, dof: Dof) -> Array | None:
        """Returns the axis (3,) of a turn or slide in the child's frame; None if the file has its axes in
        other frames."""
        return None

    def zero(self, dof: Dof) -> tuple[float, float] | None:
        """Returns the value of a joint at the start of the file, and the expected value; None if the format
        has no such attribute."""
        return None

    def unexpected_masses(self) -> Iterable[tuple[str, float, Finding]]:
        """Yields (name, mass [kg], finding) of links with a mass that they must not have."""
        return ()

    def axes_error(self, size: float) -> float:
        """Returns the relative error that an engine adds to a tensor whose largest entry is `size` [kg
        m²]."""
        return 0.0

    def first_checks(self) -> Iterable[Check]:
        """Returns the checks of the format that run before the comparison of names."""
        return ()

    def own_checks(self) -> Iterable[Check]:
        """Returns the checks of the format that run if no name is missing."""
        return ()

    def result_of(self, name: str, detail: str, findings: Iterable[Finding]) -> Check:
        """Returns the result of a check that passes without findings."""
        listed = list(findings)
        return self.within(name, float(len(listed)), 0.0, detail, listed)

    def within(
        self, name: str, value: float, limit: float, detail: str, findings: Iterable[Finding] = ()
    ) -> Check:
        """Returns the result of a check that passes if `value` is at most `limit`."""
        passed = value <= limit
        shown = () if passed else few(findings)
        return Check(f"{self.file}: {name}", passed, detail, value, limit, findings=shown)
