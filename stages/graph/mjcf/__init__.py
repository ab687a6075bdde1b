"""The reader of MJCF files, as MuJoCo compiled them: bodies, joints and equalities become a mechanism.

- actuation: Reads the actuators and sensors of an MJCF, and renames the joints, sites and bodies that they
  refer to.
- base: Finds the fixed bodies, the floating bodies and the root of an MJCF.
- equalities: Turns equalities that connect two bodies into connections that close loops; a pair can form a
  hinge.
- extras: Reads the extras of an MJCF, and renames the bodies, joints and sites that they refer to.
- joints: Combines a body's joints to one chain of dofs, and finds its joint type.
- keyframes: Reads the keyframes of an MJCF, and renames the joints that they refer to.
- naming: Names the bodies, joints, sites and equalities of an MJCF: they keep their names, or get new names.
- reader: Reads an MJCF into a mechanism: bodies and joints at qpos0, followers at the values of their
  drivers.
"""
