"""MJCF: the robot, and the scene around it."""
