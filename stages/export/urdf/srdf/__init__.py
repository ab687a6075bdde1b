"""SRDF: what MoveIt has to know of a robot beside its URDF."""
