"""A Python package with a robot's files."""
