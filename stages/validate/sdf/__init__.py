"""An SDF read back: the checks that it is the robot."""
