"""Names files that several stages know."""

VARIANTS = "variants.npz"
"""Beside the MJCF: robots that differ a little from the robot."""
