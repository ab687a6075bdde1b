"""URDF: the tree of links and joints, in one file.

- bodies: Links of a URDF: their inertia, what is seen of them, and what they collide with.
- build: Writes all files of the format, from what the other modules of this room make of the robot.
- form: The form of a robot's URDF, as the configuration wants it.
- joints: Joints of a URDF: their place, axis, limits and damping.
- lowering: Lowering: joints of several degrees of freedom as URDF joints of one each, with links of next to
  no mass between them.
- model: URDF: the tree of links and joints.
- section: Configuration of the URDF writer.
- unsupported: Reports what URDF cannot express: one diagnostic for each kind of loss.
- writer: URDF: the tree of links and joints, in one file, and beside it the SRDF for MoveIt.
"""
