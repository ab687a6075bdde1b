"""Describes a dof that closed loops make follow another dof, approximated by a straight line."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class LinearCoupling:
    """follower ≈ multiplier · driver + offset wherever the loops are closed, by the names of dofs."""

    follower: str
    driver: str
    multiplier: float
    offset: float
    error: float
    """Largest error of the follower [rad or m]."""
    exact: bool
    """Whether the error is at most 1e-9."""
    low: float
    """Lower end of the driver's range in the fit [rad or m]."""
    high: float
    """Upper end of the driver's range in the fit [rad or m]."""
