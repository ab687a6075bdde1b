"""SRDF: what a text says of a robot beside its URDF."""
