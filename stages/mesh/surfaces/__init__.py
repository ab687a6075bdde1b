"""Works on triangle surfaces: shells, cleaning, points inside, crossings of lines, hulls and pieces.

- booleans: Converts closed surfaces to bodies of the boolean library, and back.
- clean: Cleans a mesh: splits any triangles into closed solids that face outwards, and an open remainder.
- convex_hull: Computes the convex hull of points.
- inside: Finds which points are inside a surface.
- neighbours: Finds the neighbours of a surface's triangles.
- pieces: Defines the pieces of a collider, closed convex surfaces and primitives, and their common functions.
- rays: Finds where straight lines cross a surface.
- shells: Finds the shells of a surface (faces connected by edges): which of them are closed, and which
  contain others.
- snapping: Moves coordinates to a grid, so that hashes and files do not depend on how a processor rounds.
"""
