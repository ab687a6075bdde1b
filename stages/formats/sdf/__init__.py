"""SDF text as values, and the names that a robot's things have in it."""
