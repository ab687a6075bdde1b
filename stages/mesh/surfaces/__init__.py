"""Triangle surfaces and what is asked of them: closed, inside, rays, hulls.

- booleans: Closed surfaces as bodies of the boolean library, and back.
- clean: Cleaning: from any triangles to closed solids that face outwards, and what is left of them.
- convex_hull: The convex hull of points.
- inside: What is inside of a surface.
- neighbours: The neighbours of a surface's triangles.
- pieces: The pieces of a collider: closed convex surfaces and primitives, and what they have in common.
- rays: Where straight lines cross a surface.
- shells: The shells of a surface: faces connected by edges; which are closed, and which lies within which.
- snapping: Coordinates on a grid: what is hashed or written does not show how a processor rounds.
"""
