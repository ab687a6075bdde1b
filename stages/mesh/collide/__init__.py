"""The colliders of links: who makes each, of which pieces, and whether it is near enough.

- acceptance: Whether a collider is near enough to its part.
- choices: Who makes the collider of each part: the maker of `mesh.collider`, or what a glob says.
- collision: What a part or a link collides with, how it came about, and how near it is to the part; as bytes
  too.
- cut_pieces: Convex pieces of a part: it is cut by planes until little stands out of it, then pieces are
  joined again.
- improvement: The second, costly step of a maker of colliders, in a guest process with limits of time and
  memory: CoACD crashes on some meshes, and never ends on others.
- make: The colliders of all links: each part's is made once, and the worst ones are improved.
- merge_across_parts: Fewer convex pieces for several parts of a link: pieces of different parts become one
  where they may.
- primitives: Primitives (boxes, spheres, cylinders, capsules) as shapes of a `Geometry`.
- report: What is reported of colliders: their figures, and those that are not what they should be.
- side_by_side: Colliders improved side by side, in as many guest processes, which stay for all of them.
- task_guest: Guest process that does tasks for this project's own process: a request is a task as a pickle.
"""
