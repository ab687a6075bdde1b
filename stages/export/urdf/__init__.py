"""URDF: the tree of links and joints, in one file.

- bodies: Writes the links of a URDF: inertials, visuals and colliders.
- build: Writes all files of the format URDF.
- form: Chooses the form of a robot's URDF from the configuration.
- joints: Writes the joints of a URDF: pose, axis, limits and damping.
- lowering: Converts joints of several degrees of freedom to chains of URDF joints and almost massless links.
- model: Writes a robot as URDF: its tree of links and joints.
- section: Defines the configuration of the URDF writer.
- writer: Declares the format URDF: the tree of links and joints in one file, with the SRDF for MoveIt beside
  it.
"""
