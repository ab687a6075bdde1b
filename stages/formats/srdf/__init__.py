"""Reads an SRDF: what a text adds to a robot's URDF."""
