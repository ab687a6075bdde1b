"""The reader of URDF files: reads a file into a mechanism; reports or repairs its errors.

- dummy_links: Dummy links: frames that a file writes as links, and massless links between two joints.
- inertias: Inertias that no solid can have: refused, recomputed from the link's shapes, or projected.
- naming: Names from a URDF: links, joints and frames keep theirs.
- reader: Reads a URDF into a mechanism: links become bodies, joints become connections, all at zero.
- solid_inertia: The inertia of a link's shapes as solids.
- srdf: What an SRDF says of the robot in a URDF, by the names in the files, and what of it is left out.
- structure: Whether the links and joints of a file are a tree; every problem is reported at once.
"""
