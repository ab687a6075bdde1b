"""From the model that MuJoCo compiled to the value that later stages read.

- actuation: Converts actuators and sensors of a model that MuJoCo compiled.
- effort: The effort limit of each joint, from its own bound and those of its actuators.
- equalities: The equalities of a compiled model that our robot model has: loops, and joints that follow
  others.
- extras: What only an MJCF has of a compiled model: tendons and what is on them, options, and the scene
  around the robot.
- geoms: The geoms of a body of a compiled model: what is seen, what collides, and what is neither.
- joints: The joints of a body of a compiled model.
- keyframes: Keyframes of a model that MuJoCo compiled: the values of its joints, and what is left out of
  them.
- meshes: The triangles of a compiled model's meshes.
- model: Converts a model that MuJoCo compiled to values of our own.
- options: The options and flags of a compiled model that are not MuJoCo's defaults, as an MJCF has them.
- textures: The textures that a compiled model's materials give to its meshes.
- trees: Which bodies of a model are the robot; all others lie in the scene around it.
- unsupported: Reports by name every element or attribute of an MJCF that our robot model cannot represent.
- unsupported_fields: Attributes and options of an MJCF that our robot model cannot represent, found in
  MuJoCo's compiled model.
"""
