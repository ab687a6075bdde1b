"""Converts the model that MuJoCo compiled to the value that later stages read.

- actuation: Converts actuators and sensors of a model that MuJoCo compiled.
- effort: Computes the effort limit of each joint, from its own bound and the bounds of its actuators.
- equalities: Reads the equalities of a compiled model that our robot model has: loops, and joints that follow
  another joint.
- extras: Reads the parts of a compiled model that only an MJCF has: tendons, their actuators and sensors,
  options, and the scene around the robot.
- geoms: Sorts the geoms of a body of a compiled model into visual geoms, colliders, and geoms that are
  neither.
- joints: Reads the joints of a body of a compiled model.
- keyframes: Reads the keyframes of a model that MuJoCo compiled: the values of its joints, and the values
  left out.
- meshes: Reads the triangles of a compiled model's meshes.
- model: Converts a model that MuJoCo compiled to values of our own.
- options: Reads the options and flags of a compiled model that are not MuJoCo's defaults, in the words of an
  MJCF.
- textures: Reads the textures that a compiled model's materials give to its meshes.
- trees: Finds the bodies of a model that belong to the robot; all other bodies are in the scene around it.
- unsupported: Reports by name every element or attribute of an MJCF that our robot model cannot represent.
- unsupported_fields: Finds, in MuJoCo's compiled model, attributes and options of an MJCF that our robot
  model cannot represent.
"""
