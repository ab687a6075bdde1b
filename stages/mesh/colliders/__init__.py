"""The colliders of a link: one module for each way to make them.

- coacd: Convex pieces of a part, whatever its shape, as CoACD decomposes it.
- given: A primitive of the kind, and of the lengths, that the user names.
- hull: One convex hull of all.
- ladder: The cheapest collider that is near enough to the part: a primitive, the convex hull, or convex
  pieces.
- primitives: The primitive that fits best.
- raw: The mesh itself.
- spheres: Spheres that fill a part.
- visual: No collider: the link is seen, and touches nothing.
"""
