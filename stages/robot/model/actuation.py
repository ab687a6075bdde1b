"""What drives a robot's dofs: actuators, in no format's words but MuJoCo's own model of a force.

An actuator's force is gain · control + bias, along the dof's value times its gear; the bias of a servo is
affine in that length and its speed (MuJoCo's documentation, "Computation", on actuation).
"""

from dataclasses import dataclass
from typing import Literal

ActuatorType = Literal["motor", "position", "velocity", "intvelocity", "damper", "pid", "dcmotor", "general"]
"""motor: the control is the force; position, velocity, intvelocity, pid: servos; damper: the control is a
share of the damping; dcmotor: the control is a voltage; general: every parameter is given."""

SERVOS = ("position", "intvelocity", "pid")
"""The types that hold a value, with a stiffness `kp`."""


@dataclass(frozen=True, slots=True)
class Actuator:
    """An actuator of one dof.

    `gear`: length of the actuator per value of the dof. `kp` [N m/rad or N/m] and `kv` [N m s/rad or N s/m]
    of servos. `control` and `force`: (lowest, highest), None without limits; control in the unit of the type,
    force at the actuator. `terms`: MJCF's other attributes, those of `general` and of single types. `home`:
    the control at the keyframe `home`; `holds`: (keyframe, the force [N m or N] at the dof, with its sign,
    that holds the robot there), where one is needed. `motor`: of the library, "" for none; `sources`:
    (parameter, where its value comes from) of those that it gives.

    `load` [N m or N]: the largest force at the dof that holds the robot's weight, over its range, None where
    the weight is unknown. `estimated`: the values that Linkwright has chosen.
    """

    name: str
    dof: str
    type: ActuatorType
    gear: float = 1.0
    kp: float | None = None
    kv: float | None = None
    control: tuple[float, float] | None = None
    force: tuple[float, float] | None = None
    terms: tuple[tuple[str, str], ...] = ()
    home: float = 0.0
    load: float | None = None
    holds: tuple[tuple[str, float], ...] = ()
    estimated: tuple[str, ...] = ()
    motor: str = ""
    sources: tuple[tuple[str, str], ...] = ()

    def moves(self, dof: str) -> str:
        """What the actuator's own motion is before the gear, where it drives a dof of the kind `dof`: a motor
        of the library turns, also where the dof slides."""
        return "turn" if self.motor else dof

    def force_at(self, keyframe: str) -> float:
        """The force [N m or N] at the dof that holds the robot in this keyframe; 0 where none is known."""
        return dict(self.holds).get(keyframe, 0.0)

    @property
    def home_load(self) -> float | None:
        """The size [N m or N] of the force at `home`; None where it is unknown."""
        force = dict(self.holds).get("home")
        return None if force is None else abs(force)

    @property
    def sag(self) -> float | None:
        """How far [rad or m] a servo's dof is from its target at `home`, by the weight; None without kp."""
        if self.type not in SERVOS or not self.kp or self.home_load is None:
            return None
        if any(name == "ki" for name, _ in self.terms):
            return 0.0
        return self.home_load / (self.kp * self.gear**2)


@dataclass(frozen=True, slots=True)
class Armature:
    """An inertia [kg m² or kg] that Linkwright adds to a dof that has none. `reason`: why."""

    dof: str
    value: float
    reason: str


@dataclass(frozen=True, slots=True)
class Supplied:
    """What a motor of the library gives a dof: a `quantity` of its dynamics, at the dof. `source`: the motor,
    and where its value comes from."""

    dof: str
    quantity: str
    value: float
    source: str


@dataclass(frozen=True, slots=True)
class Actuation:
    """What drives a robot, in the order of its dofs.

    `supplied`: by motors; `overruled`: the dofs where a value of the motor loses to the configuration;
    `armatures`: of dofs that have none by then. `compensated`: (link, share of its
    weight) that actuators carry; `compensating`: the dofs whose actuators do so.
    """

    actuators: tuple[Actuator, ...] = ()
    armatures: tuple[Armature, ...] = ()
    compensated: tuple[tuple[str, float], ...] = ()
    compensating: tuple[str, ...] = ()
    supplied: tuple[Supplied, ...] = ()
    overruled: tuple[str, ...] = ()

    def of(self, dof: str) -> Actuator | None:
        """The first actuator of a dof."""
        return next((one for one in self.actuators if one.dof == dof), None)


NONE = Actuation()
"""Nothing drives the robot."""
