"""Checks a URDF or MJCF by itself, for errors that do not depend on which robot the file describes.

- bodies: Compares the bodies of a bare file with their shapes and with each other, under the codes of a
  build.
- figures: Defines the masses and sizes of the bodies of a bare file, whatever its format.
- findings: Lists the checks of a bare file, a URDF or MJCF by itself, and parses the numbers in it.
- judged: Judges masses, inertias and angles, by rules that are the same in every format.
- mesh_files: Reads the points of a mesh file, in every format that a build reads except PLY.
- mesh_units: Finds meshes whose size does not fit the robot: a mixed-up unit is off by a thousand.
- mjcf_defaults: Completes the attributes of MJCF elements by the defaults of their classes.
- mjcf_figures: Reads the masses and sizes of the bodies of an MJCF, as MuJoCo compiled it.
- mjcf_keys: Checks the keyframes of an MJCF: the number of their values, and that these are within limits.
- mjcf_values: Checks the numbers of an MJCF: those of its joints, bodies and actuators.
- run: Runs the checks of a bare file.
- start: Compiles and simulates a bare file in MuJoCo: checks that it compiles, starts without overlaps and
  open loops, and stays finite for a second.
- urdf_against_mjcf: Compares the URDF and the MJCF of the same robot: kinematics, masses and limits, by
  names.
- urdf_figures: Reads the masses and sizes of the bodies of a URDF, from its text and its meshes.
- urdf_tree: Checks that the links of a URDF are a tree without cycles, from a single root, and checks its
  mimics.
- urdf_values: Checks the numbers of a URDF: the axes, limits and dynamics of joints, and the inertials of
  links.
"""

ENDINGS = (".urdf", ".xml", ".mjcf")
"""Endings of the names of model files."""
