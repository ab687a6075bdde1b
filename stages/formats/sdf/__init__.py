"""Reads SDF text as values, and chooses the names that a robot's things have in it."""
