"""A Python package that holds a robot's files."""
