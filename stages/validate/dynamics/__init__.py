"""Computes the robot's dynamics, and has engines compute the dynamics of its files."""
