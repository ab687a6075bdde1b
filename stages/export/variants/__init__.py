"""Variants of a robot: `variants.npz`, arrays over MuJoCo's fields of robots that differ a little from it.

- arrays: Computes the arrays of variants: random values for fields of a compiled model.
- build: Makes `variants.npz`: random variants of the finished MJCF within the configured ranges.
- draws: Draws random numbers that are the same on every machine and under any version of any library.
- inertials: Computes random mass properties near those of a body, such as a solid can have.
- names: Lists the names of all quantities that may vary, before the robot's MJCF is written.
- quantities: Finds the quantities of a compiled robot that may vary, with the origins of their values.
- shares: Chooses the share by which each quantity varies: from the configuration, or from the origin of its
  value.
- variant_files: Defines the files that variants add to a robot.
"""
