"""Makes colliders by contact: for each link the fewest convex pieces that touch only where the link touches.

A link begins with one primitive or hull. In a seeded pose, two links are *false* if their colliders overlap
by more than a margin while their meshes are further apart than the margin. If a pair is false too often, a
piece of one of the two is cut by a plane, and each side takes the hull of its triangles; then pieces are
joined again as long as no pair gets worse. Links that meet the world are cut until they are within their
tolerance.

- build: Makes colliders by contact, caches them by everything on which they depend, and reports pairs of
  links whose colliders still touch where the links do not.
- ends: Cuts the colliders of links that meet the world until they are within the link's tolerance.
- fitting: Fits the pieces of links that meet the world: in this process, and in parallel in a second process
  if there is a second processor.
- links: Makes the first pieces of links: a primitive or a hull for each of their colliders, or for each part.
- meeting: Finds the links that meet the world: those with which the robot grasps, stands and touches.
- pair: Measures how deep the colliders of two links overlap in poses in which the links' meshes are apart.
- poses: Finds the pairs of links that come near each other, and the poses in which they do.
- request: Defines the request for colliders by contact, and the pairs of links whose colliders touch falsely.
- robot: Makes the colliders by contact of a whole robot, from surfaces to pieces.
- search: Searches for the pieces of links: it cuts pieces of false pairs, and merges pieces if no pair gets
  worse.
"""
