"""MuJoCo: the only room that compiles a model.

compile: from text or a file to a model, or the reason why not; warnings: what MuJoCo says on the way
urdf: a URDF as MuJoCo reads URDFs
includes: the content of included files in the place of each <include>
state: the data of a model at a keyframe; trial: whether a model stays whole and finite while it is simulated
fields, elements, bodies, sensors: elements of an MJCF from a compiled model: what its XML must say

- bodies: Whole bodies of a compiled model, with all that is on them and below, and the data of their shapes.
- compile: From text or a file to a compiled model, or MuJoCo's reason why not.
- elements: Cameras, lights, sites, geoms, tendons, actuators, sensors, pairs and equalities of a compiled
  model.
- fields: Attributes of elements: which array of MuJoCo's model has each, and how it is written.
- includes: The content of included files in the place of each <include>, as MuJoCo has it.
- sensors: Sensors of a compiled model.
- state: The state of a model at one of its keyframes.
- trial: A trial run: whether a robot's MuJoCo model stays whole and finite while it is simulated.
- urdf: A URDF as MuJoCo reads URDFs: its meshes by paths, and no floating joint but below the world.
- warnings: MuJoCo's warnings, collected in place of a log file in the working folder, and its errors.
"""
