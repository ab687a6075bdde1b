"""Compares an SDF that was read back with the robot."""
