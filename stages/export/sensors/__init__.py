"""Makes the robot's sensors, with their poses, from the key `sensors`."""
