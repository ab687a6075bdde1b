"""The reader of Onshape's documents: turns an assembly into a mechanism.

- assembly: The assembly as drawn: every occurrence at any depth, and every feature once for each place where
  it acts.
- bodies: Rigid bodies: which parts move as one.
- definition: Reads Onshape's assembly definition into an `Assembly`, tolerant of keys that it does not know.
- hidden: The key `hidden`: instances that are hidden in CAD are left out as if they were suppressed.
- naming: Names of links, joints and frames, from what the designer typed.
- onshape_to_robot: Documents made for onshape-to-robot: translates the conventions of its names into our own
  terms.
- onshape_to_robot_names: Reads the name of one mate as onshape-to-robot does: a joint, its direction, its
  limits.
- reader: The reader of Onshape's documents: reads an assembly into a mechanism.
- reply_fields: Reads fields of the API's replies; ProtocolError names the place of an invalid field.
- rigid_subassemblies: Finds the rigid sub-assemblies: the keys `depth.max`, `depth.rigid` and
  `depth.flexible`.
"""
