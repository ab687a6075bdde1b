"""The reader of MJCF files, as MuJoCo compiled them: bodies, joints and equalities become a mechanism.

- actuation: Actuators and sensors of an MJCF, by the names that its joints, sites and bodies have now.
- base: Finds the fixed bodies, the floating bodies and the root of an MJCF.
- equalities: Equalities that connect two bodies: they close loops, and a pair of connects can form a hinge.
- extras: What only an MJCF has, by the names that its bodies, joints and sites have now.
- joints: Combines a body's joints to one chain of dofs, and finds its joint type.
- keyframes: Keyframes of an MJCF, by the names that its joints have now.
- naming: Names from an MJCF: bodies, joints, sites and equalities keep their names; unnamed ones get one.
- reader: Reads an MJCF into a mechanism: bodies and joints at qpos0, followers at the values of their
  drivers.
"""
