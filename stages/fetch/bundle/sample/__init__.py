"""Provides the robot that is shipped with the package."""
