"""What the page shows of a robot that lives in it: the *pack*, made from the files of a build.

The pack is one compressed file: a JSON header (bodies, joints, loops, relations, geoms, links: see
`pack`), the triangles, and the physics engine's own copy of the model. `viewer/` shows it. Nothing here
is imported by a build whose pack is in the cache.

- actuators: The actuators of the header, one entry for each number of `ctrl`.
- beside_urdf: What a URDF does not say of a robot, or not to all readers: its named poses, relations and
  loops.
- compiled: The compiled model of a build, of which the page shows everything by index.
- flat: A scene as one document: its includes resolved, and a name for every body and geom.
- geoms: The geoms of the header: what is seen, what collides, and the ground.
- links: The links of the header: the CAD parts of each, their masses, and how well their colliders fit.
- made: The view of a robot for its page: made once, and kept in the cache by its content.
- mechanism: The bodies, joints, relations and loops of the header, and its keyframes, actuators and frames.
- meshes: The meshes of the header: each once, thinned to what a page can show.
- pack: The pack as bytes: a header in JSON, and the buffers that it names by their place.
- rounding: Numbers of the pack: short in JSON, and exact enough for kinematics to 1e-9.
- scene: The whole pack of a robot, from the folder with its files.
- thin: Meshes with fewer triangles, for a page that opens and turns quickly.
- triangles: Triangles of the compiled model, and how the page has them: 16 bits a coordinate, welded.
"""
