"""The reader of URDF files: reads a file into a mechanism; reports or repairs its errors.

- dummy_links: Converts links that only represent frames into frames, and gives mass to massless links between
  two joints.
- inertias: Handles inertias that no solid can have: keeps, recomputes or projects them.
- naming: Names the links, joints and frames of a URDF: they keep their names.
- reader: Reads a URDF into a mechanism: links become bodies, joints become connections, all at zero.
- solid_inertia: Computes the inertia of a link's shapes as solids.
- srdf: Reads an SRDF for the robot in a URDF, by the names in the files, and lists the parts left out.
- structure: Checks that the links and joints of a file are a tree, and reports all problems at once.
"""
