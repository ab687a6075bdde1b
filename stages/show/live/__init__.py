"""What the page shows of a robot that lives in it: the *pack*, made from the files of a build.

The pack is one compressed file: a JSON header (bodies, joints, loops, relations, geoms, links: see
`pack`), the triangles, and the physics engine's own copy of the model. `viewer/` shows it. No module of
this room is imported by a build whose pack is in the cache.

- actuators: The actuators of the header, one entry for each number of `ctrl`.
- beside_urdf: What a URDF does not say of a robot, or not to all readers: its named poses, relations and
  loops.
- compiled: The compiled model of a build, of which the page shows everything by index.
- decimate: Meshes with fewer triangles, for a page that opens and turns quickly.
- geoms: The geoms of the header: what is seen, what collides, and the ground.
- includes: A scene as one document: its includes resolved, and a name for every body and geom.
- links: The links of the header: the CAD parts of each, their masses, and how well their colliders fit.
- mechanism: The bodies, joints, relations and loops of the header, and its keyframes, actuators and frames.
- meshes: The meshes of the header: each once, thinned to what a page can show.
- pack: The pack as bytes: a header in JSON, and the buffers that it names by their place.
- rounding: Numbers of the pack: short in JSON, and exact enough for kinematics to 1e-9.
- scene: The whole pack of a robot, from the folder with its files.
- triangles: Triangles of the compiled model, and how the page has them: 16 bits a coordinate, welded.
"""

from collections.abc import Iterable

VERSION = 9
"""Raised when the same robot gives another pack."""

NEVER_READ = (".json", ".srdf", ".sdf", ".usda", ".py", ".md")
"""Files of a build that no MJCF and no URDF refers to."""


def source_of(files: Iterable[str], robot: str) -> str | None:
    """The file of a build that the page shows: the scene, else the URDF, which may be that of a ROS package;
    None without both."""
    there = sorted(files, key=lambda path: (path.count("/"), path))
    usual = [name for name in ("scene.xml", f"{robot}.xml", f"{robot}.urdf") if name in there]
    return next(iter([*usual, *(path for path in there if path.endswith(".urdf"))]), None)
