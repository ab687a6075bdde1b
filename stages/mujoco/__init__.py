"""MuJoCo: the only room that compiles a model.

- bodies: Whole bodies of a compiled model, with all that is on them and below, and the data of their shapes.
- compile: From text or a file to a compiled model, or MuJoCo's reason why not.
- elements: Cameras, lights, sites, geoms, tendons, actuators, sensors, pairs and equalities of a compiled
  model.
- fields: Attributes of elements: which array of MuJoCo's model has each, and how it is written.
- includes: The content of included files in the place of each <include>, as MuJoCo has it.
- mjcf_schema: The elements and attributes of MJCF that a MuJoCo knows, by its own account.
- names: Names and numbers of what is in a compiled model.
- sensors: Sensors of a compiled model.
- state: The state of a model at one of its keyframes.
- trial: A trial run: whether a robot's MuJoCo model stays whole and finite while it is simulated.
- urdf: A URDF as MuJoCo reads URDFs: its meshes by paths, and no floating joint but below the world.
- viewer: MuJoCo's own viewer, with a scene at its keyframe `home`.
- warnings: MuJoCo's warnings, collected in place of a log file in the working folder, and its errors.
"""
