"""MJCF: the robot, and a scene around it, for MuJoCo."""
