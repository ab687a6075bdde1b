"""SRDF: the data of a robot that MoveIt needs beside its URDF.

- convex: Computes lower bounds of the distance of convex bodies, at many poses at once.
- disabled: Finds the pairs of links that MoveIt does not check for collisions.
- distant_links: Finds links that never meet: they are apart in each of many seeded poses, with a margin for
  the poses between.
- groups: Finds the groups of joints that MoveIt plans for: chains to named frames and to ends of the robot,
  grippers, and all joints.
- model: Writes the SRDF of a robot: groups, poses, and pairs of links that are not checked for collisions.
- source_groups: Finds the groups and end effectors of the source's SRDF in the robot's URDF.
- states: Computes the values of a URDF's joints at a robot's poses.
"""
