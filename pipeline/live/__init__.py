"""What the page shows of a robot that lives in it: the *pack*, made from the files of a build.

The pack is one compressed file: a JSON header (bodies, joints, loops, relations, geoms, links: see
`pack`), the triangles, and the physics engine's own copy of the model. `viewer/` shows it. Nothing here
is imported by a build whose pack is in the cache.
"""
