"""The content of a compiled model: bodies, shapes, coordinates, equalities.

- body_shapes: Measures the shapes of a compiled model's bodies by points whose hull contains them.
- contact_attributes: Compares MuJoCo's contact properties of geoms with given properties, or with the
  defaults.
- coordinates: Finds a compiled model's joints and bodies by the robot's names, and sets the robot's values in
  its `qpos`.
- equalities: Finds the equalities of a compiled model, their errors, and the bodies that they connect.
- equality_solver: Closes the equalities of a compiled model (relations and loops) after a joint has moved.
- inertials: Judges whether a body's inertial fits its shapes, to find mixed-up units.
- mass_properties: Computes the mass properties that links must have from their CAD parts, and compares them
  with a file's.
- poses: Converts MuJoCo's quaternions and positions to rotations and poses.
- seen_surfaces: Measures the distances of the visual shapes of a compiled model's bodies, as triangles.
- shapes: Measures the shapes of a compiled model's bodies: their reach, and the distances of points outside
  them.
"""
