"""Defines the names of files that several stages use."""

VARIANTS = "variants.npz"
"""The file beside the MJCF with the variants of the robot (see `formats.variants`)."""
