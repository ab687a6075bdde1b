"""Motions of a robot: kinematics, loops, relations, poses.

- adjacency: Finds adjacent links, whose contact means nothing, since joints hold them together.
- closing: Finds configurations whose loops are closed, within limits and by the relations.
- couplings: Finds the dofs that move together, by relations and closed loops, and can be driven at once.
- dof_ranges: Computes the ranges of dofs: their own limits, and by the relations those of other dofs.
- kinematics: Computes the poses of a robot's links at any configuration.
- linear_coupling: Describes a dof that closed loops make follow another dof, approximated by a straight line.
- loop_groups: Groups loops that move together, each group as a mechanism of its own.
- loop_lines: Finds the dofs that closed loops make follow another dof, and fits straight lines.
- loops: Measures loops at given poses of the links: the gap of each, and the values of its own dofs.
- pose_batch: Computes the robot's kinematics at many configurations at once: the first axis of every array
  counts them.
- pose_samples: Draws seeded poses of a robot that satisfy its limits, relations and loops.
- reach: Measures the reach of a robot's frames from its base.
- start_pose: Computes the named poses of a robot: `saved`, `home`, the user's, and the start of a fresh
  simulation.
- tree_paths: Finds paths along the tree of a robot: from links up to the root, or to where they meet.
"""
