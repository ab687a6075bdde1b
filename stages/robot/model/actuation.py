"""Describes the actuators of a robot's dofs by MuJoCo's model of a force, apart from any format.

An actuator has a length, its gear times the value of the dof, and a force along it: gain · control + bias.
The bias of a servo is affine in the length and its speed (MuJoCo's documentation, "Computation", on
actuation).
"""

from dataclasses import dataclass
from typing import Literal

ActuatorType = Literal["motor", "position", "velocity", "intvelocity", "damper", "pid", "dcmotor", "general"]
"""The type of an actuator, as in MJCF. motor: the control is the force; position, velocity, intvelocity, pid:
servos; damper: the control is a share of the damping; dcmotor: the control is a voltage; general: every
parameter is written."""

SERVOS = ("position", "intvelocity", "pid")
"""The types that hold a value of the dof, with a stiffness `kp`."""


@dataclass(frozen=True, slots=True)
class Actuator:
    """An actuator of a dof."""

    name: str
    dof: str
    type: ActuatorType
    gear: float = 1.0
    """Length of the actuator per value of the dof."""
    kp: float | None = None
    """Stiffness of a servo [N m/rad or N/m]."""
    kv: float | None = None
    """Damping of a servo [N m s/rad or N s/m]."""
    control: tuple[float, float] | None = None
    """(lowest, highest) control, in the unit of the type; None without limits."""
    force: tuple[float, float] | None = None
    """(lowest, highest) force at the actuator; None without limits."""
    terms: tuple[tuple[str, str], ...] = ()
    """MJCF's other attributes, such as those of `general`: (name, text)."""
    home: float = 0.0
    """The control at the keyframe `home`."""
    load: float | None = None
    """Largest force [N m or N] at the dof that holds the robot's weight, over its range; None if the weight
    is unknown."""
    holds: tuple[tuple[str, float], ...] = ()
    """(keyframe, force [N m or N] at the dof, with its sign, that holds the robot there), for keyframes in
    which this actuator holds the robot and the force is known."""
    estimated: tuple[str, ...] = ()
    """Names of the values that Linkwright estimates."""
    motor: str = ""
    """The motor of the library; "" for none."""
    sources: tuple[tuple[str, str], ...] = ()
    """(parameter, origin of its value) for the parameters that the motor gives."""

    def moves(self, dof_kind: str) -> str:
        """Returns the kind of the actuator's own motion, before the gear, if it drives a dof of this kind. A
        motor of the library turns even if the dof slides."""
        return "turn" if self.motor else dof_kind

    def force_at(self, keyframe: str) -> float:
        """Returns the force [N m or N] at the dof that holds the robot in this keyframe; 0 if `holds` lacks
        the keyframe."""
        return dict(self.holds).get(keyframe, 0.0)

    @property
    def home_load(self) -> float | None:
        """The size [N m or N] of the holding force at `home`; None if `holds` lacks `home`."""
        force = dict(self.holds).get("home")
        return None if force is None else abs(force)

    @property
    def sag(self) -> float | None:
        """The distance [rad or m] by which the weight moves a servo's dof from its target at `home`; None
        without `kp` or `home_load`, and for other types."""
        if self.type not in SERVOS or not self.kp or self.home_load is None:
            return None
        # An integral term removes the error.
        if any(name == "ki" for name, _ in self.terms):
            return 0.0
        return self.home_load / (self.kp * self.gear**2)


@dataclass(frozen=True, slots=True)
class Armature:
    """An inertia that Linkwright adds to a dof without an armature."""

    dof: str
    value: float
    """Inertia [kg m² or kg]."""
    reason: str
    """The reason in words."""


@dataclass(frozen=True, slots=True)
class Supplied:
    """A quantity of a dof's dynamics that a motor of the library gives."""

    dof: str
    quantity: str
    """Name of the quantity, as in `Dynamics`."""
    value: float
    """Value at the dof."""
    source: str
    """The motor and the origin of the value, in words."""


@dataclass(frozen=True, slots=True)
class Actuation:
    """The actuators of a robot, and what they add to its dofs and links."""

    actuators: tuple[Actuator, ...] = ()
    """In the order of the dofs."""
    armatures: tuple[Armature, ...] = ()
    """The inertias that are added to dofs without an armature."""
    compensated: tuple[tuple[str, float], ...] = ()
    """(link, share of its weight that actuators carry)."""
    compensating: tuple[str, ...] = ()
    """The dofs whose actuators carry that weight."""
    supplied: tuple[Supplied, ...] = ()
    """The dynamics that motors of the library give."""
    overridden: tuple[str, ...] = ()
    """The dofs for which a value of the configuration replaces a value of their motor."""

    def actuator_of(self, dof: str) -> Actuator | None:
        """Returns the first actuator of a dof; None without an actuator."""
        return next((actuator for actuator in self.actuators if actuator.dof == dof), None)


NONE = Actuation()
"""The actuation of a robot without actuators."""
