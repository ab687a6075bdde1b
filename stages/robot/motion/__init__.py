"""Where a robot's links can be: kinematics, loops, relations, poses.

- adjacency: Which links are next to each other, so that their contact means nothing: joints hold them
  together.
- closing: Configurations whose loops are closed, within limits and by the relations.
- couplings: Which dofs move together, by relations and closed loops, and which of them can be driven at once.
- dof_ranges: The values that dofs may have: their own limits, and by the relations those of others.
- kinematics: The robot's own kinematics: poses of its links at any configuration.
- linear_coupling: A dof that closed loops make follow another one, as nearly as a straight line tells.
- loop_groups: Loops that move together, each group as a mechanism of its own.
- loop_lines: Which dofs the closed loops make follow another one, and how nearly that is linear.
- loops: Loops at given poses of the links: how far each is from closed, and the values of its own dofs.
- pose_batch: The robot's kinematics at many configurations at once: the first axis of every array counts
  them.
- pose_samples: Seeded poses of a robot that satisfy its limits, relations and loops.
- start_pose: Named poses of a robot: `saved`, `home`, the user's, and the one where a fresh simulation
  starts.
- tree_paths: Ways along the tree of a robot: from links up to the root, or to where they meet.
"""
