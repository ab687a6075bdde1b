"""An SRDF held against the robot and its URDF's names.

- base: What an SRDF says of the robot's base, and of joints that nothing drives.
- groups: The groups of an SRDF and its end effectors, against the robot.
- known: An SRDF that was read, and the robot that it must be of.
- pairs: The pairs of links that an SRDF keeps from colliding, against the robot.
- read_back: The run of the checks of an SRDF.
- references: Every link, joint and group that an SRDF names is there.
- states: The poses of an SRDF's groups, against the robot's keyframes.
"""
