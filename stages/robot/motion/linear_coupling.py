"""A dof that closed loops make follow another one, as nearly as a straight line tells."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class LinearCoupling:
    """follower ≈ multiplier · driver + offset wherever the loops are closed, by the names of dofs.

    `error` [rad or m]: how far the follower is off at most; `exact`: whether that is at most 1e-9. `low`,
    `high`: the driver's values [rad or m] between which that was found.
    """

    follower: str
    driver: str
    multiplier: float
    offset: float
    error: float
    exact: bool
    low: float
    high: float
