"""Describes how a dof follows another dof because of closed loops, as a straight line."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class LinearCoupling:
    """The rule follower ≈ multiplier · driver + offset [rad or m], which holds while the loops are closed;
    both are names of dofs."""

    follower: str
    driver: str
    multiplier: float
    offset: float
    error: float
    """Largest error of the follower [rad or m]."""
    exact: bool
    """Whether the error is at most `loop_lines.EXACT_TOLERANCE`."""
    low: float
    """Smallest value of the driver in the fit [rad or m]."""
    high: float
    """Largest value of the driver in the fit [rad or m]."""
