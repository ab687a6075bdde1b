"""Checks the mechanism: links, joints, masses, motion, relations and loops.

- closed_at_start: Checks that a simulation starts with its loops closed: every equality of an MJCF holds at
  qpos0.
- hinge_axes: Checks that the axis of each hinge passes near the links that it joins.
- inertial: Checks that the mass, centre of mass and inertia of each body are plausible for its shapes.
- joints: Checks the type, limits, effort and dynamics of each joint, and that nothing else acts on it.
- links_and_joints: Checks that every link and joint exists by name, and that there are no further degrees of
  freedom.
- loops: Checks that an MJCF closes the robot's loops by the right equalities, between the right bodies and
  frames.
- mass_ratio: Checks the mass ratio of neighbouring bodies, and finds bodies that are nearly massless by
  accident.
- masses: Checks that the mass, centre of mass and inertia of each link are those of its parts in CAD.
- motion: Checks that the model moves as the robot does, by its links and frames at spread values of the dofs.
- parity: Checks that every format moves as the robot does: that engines compute the robot's own kinematics
  and dynamics from each file.
- placement: Checks that the robot is where the build put it: its root, and the free base in each keyframe.
- poses: Checks that every part is where CAD's occurrence has it, at the saved configuration.
- relations: Checks that a file has the robot's relations, with the same numbers, and enforces them stiffly.
- urdf_shapes: Checks that each link of a URDF has the robot's shapes: their number, files, sizes and poses.
"""
