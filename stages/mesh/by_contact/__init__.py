"""Colliders by contact: each link has the fewest convex pieces that touch where the robot touches.

A link begins with one primitive or hull. Over seeded poses two links are *false* where their colliders
overlap by more than a margin while their meshes are apart by more than it. Where a pair is false too often,
a piece of one of the two is cut by a plane, each side taking the hull of its triangles; then pieces are
joined again where no pair gets worse. Links that meet the world are cut until they are within their
tolerance.

- build: Colliders by contact of the links that ask for them, kept by what they depend on, and what is
  reported of them.
- ends: Links that meet the world: their pieces are cut until the collider is within the link's tolerance.
- fitting: Ends fitted side by side: in this process, and in a second one where there is a second processor.
- links: The links as they start: a primitive or a hull for each of their colliders, or for each of their
  parts.
- meeting: Which links meet the world: with these the robot grasps, stands and touches.
- pair: Two links that may be false, and how deep their pieces are in each other.
- poses: Where links are near each other, over the poses that colliders are made for.
- request: What is asked of colliders by contact, and what is reported of those that are still false.
- robot: The colliders by contact of a whole robot, from surfaces to pieces.
- search: The search: pieces are cut where links are false, and merged where no pair gets worse.
"""
