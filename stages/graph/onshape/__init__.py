"""The reader of Onshape's documents: turns an assembly into a mechanism.

- assembly: Describes an assembly as drawn: every occurrence at any depth, and every feature once for each
  occurrence of its owner.
- bodies: Finds the rigid bodies of an assembly: the parts that move together.
- definition: Reads Onshape's assembly definition into an `Assembly`; unknown keys are ignored.
- hidden: Leaves out instances that are hidden in CAD, as if they were suppressed (key `hidden`).
- naming: Names links, joints and frames after what the designer typed.
- onshape_to_robot: Translates the names of documents made for onshape-to-robot to features and keys of our
  own.
- onshape_to_robot_names: Reads the name of one mate as onshape-to-robot does: a joint, its direction, its
  limits.
- reader: Reads an Onshape assembly into a mechanism.
- reply_fields: Reads fields of the API's replies; a ProtocolError names the place of an invalid field.
- rigid_subassemblies: Finds the rigid sub-assemblies (keys `depth.max`, `depth.rigid` and `depth.flexible`).
"""
