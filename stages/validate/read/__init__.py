"""Readers: each says in one way what a file of its format has, which `stages.validate.same` compares.

- compiled: The reader of a compiled model, and comparers as its checks.
- mjcf: The robot of a compiled MJCF.
- mujoco: The robot of a file that MuJoCo compiled.
- run: The checks of a file that no engine reads, by the reader of its format.
- sdf: The robot of an SDF, whose kinematics is worked out from the file alone.
- urdf: The robot of a URDF that MuJoCo compiled.
- usd: The robot of a USD, read by usd-core: its joints say where their frames are.
"""
