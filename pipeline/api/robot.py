"""Defines `linkwright.Robot`: a robot as a value, with its kinematics and its mass matrix."""

from collections.abc import Iterable, Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Protocol, TypeAlias, TypeVar

from linkwright.pipeline.config.messages import nearest
from linkwright.pipeline.errors import LinkwrightError
from linkwright.stages.robot.dynamics import mass_matrix as dynamics
from linkwright.stages.robot.model import robot as model
from linkwright.stages.robot.model.robot import Array, Value
from linkwright.stages.robot.motion import kinematics
from linkwright.stages.robot.text.plural import count

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

Q: TypeAlias = "Mapping[str, float | Sequence[float]] | Sequence[float] | npt.NDArray[np.floating[Any]]"
"""Joint values by name, or all of them in the order of `Robot.dofs`, one after the other."""

VALUE_LENGTHS = {"turn": 1, "slide": 1, "ball": 4, "free": 7}
"""The count of numbers in a dof's value, by the kind of dof."""


class Robot:
    """Links, joints and how they move. Units are SI; a transform `a_from_b` (4, 4) takes coordinates in frame
    b to frame a.

    `links`, `joints`, `dofs` and `frames` are by name, in the order of the tree. A joint with one dof gives
    the dof its name; a joint with several has a dof for each (`lift_slide`, `lift_turn`).

    Joint values `q` are by the names of `dofs`: a turn [rad], a slide [m]; a ball's unit quaternion (w, x, y,
    z); of free motion the position [m] and a quaternion (x, y, z, w, x, y, z). Their zero and their sign are
    the mate's own, as in the robot's files: a positive turn is right-handed about the dof's axis. A dof that
    `q` does not name is at 0, or where the relation that it follows (`mimic`) takes it. In place of a
    mapping, `q` can be a sequence of all numbers in the order of `dofs`.
    """

    def __init__(self, value: model.Robot) -> None:
        self.model = value
        """The robot as the stages of a build pass it on."""
        self.name: str = value.name
        self.links: Mapping[str, model.Link] = _by_name(value.links)
        self.joints: Mapping[str, model.Joint] = _by_name(value.joints)
        self.dofs: Mapping[str, model.Dof] = _by_name(value.dofs)
        self.frames: Mapping[str, model.Frame] = _by_name(value.frames)

    def __repr__(self) -> str:
        counts = f"{len(self.links)} links, {len(self.joints)} joints, {self.mass:.4g} kg"
        return f"<linkwright.Robot {self.name}: {counts}>"

    @property
    def mass(self) -> float:
        """The sum of the links' masses [kg]."""
        return sum(link.inertial.mass for link in self.links.values())

    @property
    def saved(self) -> dict[str, Value]:
        """The joint values of the pose in which CAD, or the robot's own file, was saved."""
        return dict(kinematics.saved_configuration(self.model))

    def poses(self, q: "Q | None" = None) -> dict[str, Array]:
        """Returns root_from_link (4, 4) of every link at `q`, by name."""
        return kinematics.link_poses(self.model, self.values(q))

    def frame_poses(self, q: "Q | None" = None) -> dict[str, Array]:
        """Returns root_from_frame (4, 4) of every frame at `q`, by name."""
        poses = self.poses(q)
        return {name: poses[frame.link] @ frame.link_from_frame for name, frame in self.frames.items()}

    def mass_matrix(self, q: "Q | None" = None) -> Array:
        """Returns M (n, n) of the kinetic energy ½ q̇ᵀ M q̇ at `q`, with the root link at rest.

        Its rows and columns are `speeds`. Every dof counts as if it moved on its own, also one that follows
        another; armature (`dof.dynamics.armature`) is not in it.
        """
        return dynamics.mass_matrix(self.model, self.values(q))

    @property
    def speeds(self) -> tuple[str, ...]:
        """The dof of each row of the mass matrix.

        A turn [rad/s] and a slide [m/s] have one row. A ball has three: the angular velocity of its child in
        the child's axes. Free motion has six: the velocity in the parent's axes, then the angular velocity
        as for a ball.
        """
        return tuple(name for name, dof in self.dofs.items() for _ in range(dynamics.SPEEDS[dof.kind]))

    def values(self, q: "Q | None" = None) -> dict[str, Value]:
        """Returns the value of every dof at `q`; a dof that `q` does not name follows its relation or is
        0."""
        q_values = self._read({} if q is None else q)
        values = {**kinematics.rest_configuration(self.model), **q_values}
        rules = {rule.follower: rule for rule in self.model.relations if rule.follower not in q_values}

        def value(name: str) -> Value:
            rule = rules.get(name)
            driver = value(rule.driver) if rule and rule.driver in values else None
            if rule is None or not isinstance(driver, float):
                return values[name]
            return rule.multiplier * driver + rule.offset

        return {name: value(name) for name in self.dofs}

    def _read(self, q: Q) -> dict[str, Value]:
        """Returns the values in `q`, by the name of the dof."""
        if not isinstance(q, Mapping):
            numbers = [float(number) for number in q]
            total = sum(VALUE_LENGTHS[dof.kind] for dof in self.dofs.values())
            if len(numbers) != total:
                message = f"expected {total} numbers, one after the other as in `dofs`, got {len(numbers)}"
                raise LinkwrightError(message, "q")
            remaining = iter(numbers)
            q = {
                name: [next(remaining) for _ in range(VALUE_LENGTHS[dof.kind])]
                for name, dof in self.dofs.items()
            }
        return {name: self._value(name, numbers) for name, numbers in q.items()}

    def _value(self, name: str, value: Any) -> Value:
        """Returns the value of a dof from a number or numbers. Raises LinkwrightError for an unknown dof or a
        wrong count."""
        dof = self.dofs.get(name)
        if dof is None:
            hint = nearest(name, self.dofs) or f"dofs: {', '.join(self.dofs)}"
            raise LinkwrightError("the robot has no dof of this name", f"q.{name}", hint)
        try:
            numbers = tuple(float(number) for number in value)
        except TypeError:  # a single number, of Python or numpy
            numbers = (float(value),)
        if len(numbers) != VALUE_LENGTHS[dof.kind]:
            message = f"expected {count(VALUE_LENGTHS[dof.kind], 'number')}, got {len(numbers)}"
            raise LinkwrightError(message, f"q.{name}")
        return numbers if len(numbers) > 1 else numbers[0]


class _Named(Protocol):
    @property
    def name(self) -> str: ...


T = TypeVar("T", bound=_Named)


def _by_name(items: Iterable[T]) -> Mapping[str, T]:
    return MappingProxyType({item.name: item for item in items})
