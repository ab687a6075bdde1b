"""SRDF: what MoveIt has to know of a robot beside its URDF.

- convex: How far apart convex bodies are at least, at many poses at once.
- disabled: The pairs of links that MoveIt does not check for collisions.
- distant_links: Which links never meet: apart in every one of many seeded poses, and by so much that what the
  poses cannot have seen is apart too.
- groups: The groups of joints that MoveIt plans for: chains to named frames and to ends of the robot,
  grippers, and all joints.
- model: SRDF: groups, poses, and pairs of links that are not checked for collisions.
- source_groups: The groups and end effectors that the robot has from its source's SRDF, as its URDF has them.
- states: The values of a URDF's joints at a robot's poses.
"""
