"""Compares an SRDF with the robot and its URDF's names.

- base: Checks the robot's base in an SRDF, and its passive joints.
- groups: Compares the groups and end effectors of an SRDF with the robot.
- pairs: Compares the pairs of links that an SRDF keeps from colliding with the robot's.
- read_back: Runs the checks of an SRDF.
- read_srdf: Reads an SRDF, and finds its groups and joints in the robot that it describes.
- references: Checks that every link, joint and group that an SRDF names exists.
- states: Compares the poses of an SRDF's groups with the robot's keyframes.
"""
