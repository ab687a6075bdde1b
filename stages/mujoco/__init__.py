"""MuJoCo: the only room that compiles models.

- bodies: Converts whole bodies of a compiled model back to MJCF, with everything on and below them, and with
  the data of their shapes.
- compile: Compiles an MJCF or URDF, as text or as a file, to a model of MuJoCo.
- elements: Converts elements of a compiled model back to MJCF: cameras, lights, sites, geoms, tendons,
  actuators, pairs, excluded pairs and equalities.
- fields: Reads attributes of elements from the arrays of MuJoCo's model.
- includes: Replaces each <include> by the content of its file, as MuJoCo does.
- mjcf_schema: Tells which elements and attributes of MJCF a version of MuJoCo accepts, by its own list.
- names: Looks up names and indices of the elements of a compiled model.
- parameters: Lists the parameters of a compiled model's joints and actuators, with their places in MuJoCo's
  arrays.
- probe: Run as `python -m`: compiles and moves a model, and prints the version of MuJoCo.
- sensors: Converts sensors of a compiled model back to MJCF.
- state: Returns the state of a model at one of its keyframes.
- trial: Simulates a robot's MuJoCo model in a trial run, which tells whether it stays stable and finite.
- urdf: Prepares a URDF for MuJoCo, which does not resolve `package://` and accepts floating joints only below
  the world.
- variants: Sets the fields of a variant in a compiled model, from which MuJoCo derives the other fields.
- viewer: Opens MuJoCo's own viewer, with a scene at its keyframe `home`.
- warnings: Collects MuJoCo's warnings, which otherwise go to a log file in the working folder.
"""
