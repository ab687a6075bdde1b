"""The robot: the value that every stage hands on, with its inertia, poses, names and kinematics."""
