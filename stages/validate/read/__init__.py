"""Reads files of all formats into the same form, which `stages.validate.same` compares with the robot.

- compiled: Reads the robot of a compiled model, and turns comparisons of robots into checks of compiled
  models.
- mjcf: Reads the robot of a compiled MJCF, for the comparisons in `stages.validate.same`.
- mujoco: Reads the robot of a file that MuJoCo compiled, whatever its format.
- run: Checks a file that no physics engine reads: its format's reader parses it, the comparisons judge it.
- sdf: Reads the robot of an SDF, whose kinematics is computed from the file alone.
- urdf: Reads the robot of a URDF that MuJoCo compiled.
- usd: Reads the robot of a USD with usd-core.
"""
