"""What a compiled model holds: bodies, shapes, coordinates, equalities.

- body_shapes: The shapes of a compiled model's bodies: points whose hull contains them, and what that hull
  measures.
- contact_attributes: MuJoCo's properties of geoms in contact: those of a compiled model against what is
  given, and MuJoCo's defaults of what is not.
- coordinates: A compiled model's joints and bodies, and the robot's values in its `qpos`.
- equalities: The equalities of a compiled model: their errors, and the bodies that they connect.
- following: The joints of a compiled model that follow another's motion, by relations and closed loops.
- inertials: Whether the inertial of a body can be that of its shapes: what has other units is found.
- lumps: Mass properties of links as the parts of CAD have them, and how far those of a file are from them.
- poses: Poses from MuJoCo's numbers.
- seen_surfaces: What is seen of the bodies of a compiled model, as triangles: how near they are to each
  other.
- shapes: The shapes of a compiled model's bodies, measured: how far they reach, and how far points are
  outside them.
"""
