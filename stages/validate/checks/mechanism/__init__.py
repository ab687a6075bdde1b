"""Checks of the mechanism: links, joints, masses, motion, relations, loops.

- closed_at_start: A fresh simulation starts with its loops closed: at qpos0 every equality of an MJCF holds.
- hinge_axes: The axis of each hinge passes near what it joins: one that misses both links by far was drawn,
  or edited, at another place.
- inertial: The inertial of each body can be that of its shapes.
- joints: Type, limits, effort and dynamics of each joint; nothing else acts on it.
- links_and_joints: Every link and joint is there by name, and no other degree of freedom.
- loops: An MJCF closes the robot's loops: the right equalities, between the right bodies, at the right
  frames.
- mass_ratio: No body is thousands of times heavier than its neighbour, and none weighs next to nothing by
  accident.
- masses: Mass, centre of mass and inertia of each link are those of its parts in CAD.
- motion: The model moves as the robot does: links and frames at configurations spread over the dofs' values.
- parity: Every format is the robot in motion: at seeded random poses within limits each engine finds in a
  file the poses, the mass matrix and the forces that the robot's own kinematics and dynamics have.
- placement: The robot stands where the build put it: its root, and the free base in each keyframe.
- poses: At the saved configuration every part is where CAD's occurrence has it.
- relations: Each relation of two joints is there, with its numbers, and no other.
- urdf_shapes: Each link of a URDF has the shapes of the robot: as many, of their files and sizes, where they
  must be.
"""
