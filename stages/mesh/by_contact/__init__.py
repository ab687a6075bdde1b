"""Colliders by contact: each link has the fewest convex pieces that touch where the robot touches.

A link begins with one primitive or hull. Over seeded poses two links are *false* where their colliders
overlap by more than a margin while their meshes are apart by more than it. Where a pair is false too often,
a piece of one of the two is cut by a plane, each side taking the hull of its triangles; then pieces are
joined again where no pair gets worse. Links that meet the world are cut until they are within their
tolerance.
"""
