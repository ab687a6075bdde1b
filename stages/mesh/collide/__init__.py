"""Chooses the maker of each collider, makes and improves the colliders, and judges whether they are near
enough.

- acceptance: Decides whether a collider is near enough to its part.
- choices: Defines the choices of collider makers that `mesh.collider` and the globs in `mesh.colliders` make.
- collision: Defines the collider of a part or a link, with its figures, and encodes it as bytes.
- cut_pieces: Cuts a part by planes into convex pieces until little stands out of it, then joins pieces again.
- improvement: Runs the second, costly step of a collider maker in a guest process with limits on time and
  memory, since CoACD crashes on some meshes, and does not terminate on others.
- make: Makes the colliders of all links: each part's collider once; the worst ones are improved.
- merge_across_parts: Joins convex pieces of different parts of a link if the result is near enough to the
  parts.
- primitives: Converts primitives (boxes, spheres, cylinders, capsules) to shapes of a `Geometry`.
- reshaped: Reports how the limits of the engines in `target` change colliders and meshes.
- report: Reports the figures of colliders, and the colliders that are flat, raw, or miss their tolerance.
- side_by_side: Improves colliders in parallel, in guest processes that are reused from collider to collider.
- task_guest: Runs pickled tasks, such as improving a collider, in a guest process.
"""
