"""Keeps the live view of a build's page and the robot's picture, which `stages.show` makes, in the cache."""
