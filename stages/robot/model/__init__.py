"""The robot as values: its links and joints, its shapes, what drives and what measures it.

- actuation: What drives a robot's dofs: actuators, in no format's words but MuJoCo's own model of a force.
- amendments: What the configuration's own XML changed in the exported files, for who checks and describes
  them.
- arrays: Arrays of the model: float64 and read-only.
- dofs: A joint's coordinates: their kinds, values, limits and dynamics.
- geom_form: How a geom is in an MJCF, beside its shape and place: its name, and its properties in contact.
- geometry: The result of the mesh stage: the shapes of every link and their mesh files.
- mjcf_extras: What an MJCF source says of a robot that no other format has, and that only an MJCF can carry.
- poses: Rigid transforms and rotations: (4, 4) and (3, 3) arrays, quaternions as (w, x, y, z).
- robot: The robot as a value: links, joints, loops, relations, frames.
- scene: The scene that the files put a robot into, as far as a simulation of it depends on that.
- semantics: What a robot's SRDF says beside its URDF (Semantic Robot Description Format), by the robot's
  names.
- sensing: What measures a robot: sensors, in the words of MJCF, and the places and cameras that they need.
- sensor_kinds: How many numbers MuJoCo's sensors give, and their units.
- transmission: The transmissions by which a source's actuators move its joints.
"""
