"""Checks of a URDF or MJCF alone: of what is wrong with a file whatever robot it is of.

- bodies: The bodies of a bare file against their shapes and each other, by the codes that a build has for
  them.
- figures: What a body of a bare file weighs and how large it is, in whatever format it is written.
- findings: What the checks of a bare file give: findings, each with the code of its check.
- judged: Judgements of single numbers that are the same in every format.
- mesh_files: The points of a mesh file of any format that a build reads, but for PLY.
- mesh_units: Whether meshes have the size of the robot: a unit that was mixed up is off by a thousand.
- mjcf_defaults: The attributes of MJCF elements with what their classes give them.
- mjcf_figures: The bodies of an MJCF by mass and size, as MuJoCo compiled it.
- mjcf_keys: The keyframes of an MJCF: as many numbers as there are coordinates, within their limits.
- mjcf_values: The numbers of an MJCF's joints, bodies and actuators, as far as they can be judged each on its
  own.
- run: The run of the checks of a bare file.
- start: A bare file in MuJoCo: whether it compiles, how it starts, and whether a second of it stays finite.
- together: The URDF and the MJCF of one robot against each other: kinematics, masses and limits, by names.
- urdf_figures: The bodies of a URDF by mass and size, from its text and its meshes.
- urdf_tree: The tree of a URDF's links: one root, one parent for each other link, no cycle; and whom joints
  follow.
- urdf_values: The numbers of a URDF's joints and links, as far as they can be judged each on its own.
"""

ENDINGS = (".urdf", ".xml", ".mjcf")
"""How the names of model files end."""
