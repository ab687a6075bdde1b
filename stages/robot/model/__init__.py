"""The robot as values: its links and joints, its shapes, its actuators and its sensors.

- actuation: Describes the actuators of a robot's dofs by MuJoCo's model of a force, apart from any format.
- amendments: Describes the changes of exported files by the configuration's own XML.
- arrays: Makes the arrays of the model: float64 and read-only.
- dofs: Describes a joint's coordinates: their kinds, values, limits and dynamics.
- geom_form: Describes the properties of a geom in an MJCF beside its shape and pose: its name and its contact
  properties.
- geometry: Describes the result of the mesh stage: the shapes of every link and their mesh files.
- mjcf_extras: Describes the content of an MJCF source that only an MJCF can carry.
- poses: Computes rigid transforms and rotations: (4, 4) and (3, 3) arrays, quaternions as (w, x, y, z).
- robot: Describes the robot as a value: links, joints, loops, relations, frames.
- scene: Describes the scene of the exported files around a robot, as far as a simulation depends on it.
- semantics: Describes the content of a robot's SRDF (Semantic Robot Description Format), by the robot's
  names.
- sensing: Describes the sensors of a robot, in MJCF's terms, and the sites and cameras that they need.
- sensor_kinds: Tells the number of values of each kind of MuJoCo sensor, and their units.
- transmission: Describes the transmissions by which a source's actuators move its joints.
"""
