"""Makes the *pack* of a page's live view of a robot from the files of a build.

The pack is one compressed file: a JSON header (bodies, joints, loops, relations, geoms, links: see
`pack`), the triangles, and the physics engine's own copy of the model. `viewer/` shows it. A build
whose pack is in the cache imports no module of this room.

- actuators: Describes the actuators for the header, with an entry for each number of `ctrl`.
- beside_urdf: Adds the robot's named poses, relations and loops to the header of a URDF.
- compiled: Compiles the model of a build, to whose indices the page refers.
- decimate: Simplifies meshes, so that the page opens and turns quickly.
- geoms: Describes the geoms for the header: visual, colliding, and the ground.
- includes: Reads a scene as a single document without includes, in which every body and geom has a name.
- links: Describes the links for the header: their CAD parts, masses, and the fit of their colliders.
- mechanism: Describes the bodies, joints, relations, loops, keyframes and frames for the header.
- meshes: Stores the meshes of the header, each once, simplified to the number of triangles that a page can
  show.
- pack: Writes and reads a pack as bytes: a header in JSON, and buffers to which it refers by their offset.
- rounding: Rounds the numbers of the pack: short in JSON, and exact enough for kinematics to 1e-9.
- scene: Makes the pack of a robot from the folder with its files.
- triangles: Reads triangles of the compiled model, and stores them welded, with 16 bits a coordinate.
"""

from collections.abc import Iterable

VERSION = 10
"""Must be increased when the same robot gives another pack."""

NEVER_READ = (".json", ".srdf", ".sdf", ".usda", ".py", ".md")
"""Suffixes of files to which no MJCF and no URDF refers."""


def source_of(files: Iterable[str], robot: str) -> str | None:
    """Returns the file of a build that the page shows: the scene, else the URDF, which may be in a ROS
    package; None if there is neither."""
    paths = sorted(files, key=lambda path: (path.count("/"), path))
    usual_names = [name for name in ("scene.xml", f"{robot}.xml", f"{robot}.urdf") if name in paths]
    return next(iter([*usual_names, *(path for path in paths if path.endswith(".urdf"))]), None)
