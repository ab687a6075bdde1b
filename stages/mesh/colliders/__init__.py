"""Makes the colliders of a link, with one module for each way to make them.

- coacd: Makes convex pieces of a part of any shape with CoACD.
- given: Makes a primitive of the kind and the lengths that the user chose.
- hull: Makes one convex hull of all parts.
- ladder: Makes the cheapest collider that is near enough to a part: a primitive, its hull, or convex pieces.
- primitives: Makes the collider of a part from the primitive that fits best.
- raw: Uses the mesh itself as the collider.
- spheres: Makes spheres that fill a part.
- visual: Makes no collider: the link is drawn, and touches nothing.
"""
