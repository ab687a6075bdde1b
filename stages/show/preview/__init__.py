"""Draws the robot's picture, `preview.png`, for every build that exports, and on request the turning robot,
`preview.webp`.

The processor draws it without a graphics card, from the look of the exported files in MuJoCo's model, in a
process of its own beside the build. So it is the same on every machine, and never makes a build fail. After a
change that does not affect the look nothing is drawn.

- ask: Runs the guest process that draws, within limits of time and memory.
- bones: Makes shapes for a robot without shapes: a ball at each body, and a bone to its parent.
- camera: Places the camera so that the whole robot is in the picture, and projects points.
- compiled: Takes the look of a robot from the model that MuJoCo compiled, at its keyframe `home`.
- from_model: Takes the look of a robot from its geometry, with its links at given poses, without any engine.
- guest: Draws a picture of the robot, in a guest process, since many triangles take memory and time.
- look: Describes the look of a robot as plain data: shapes, their poses at `home`, colours, and the camera.
- model_text: Writes the text that MuJoCo compiles: an MJCF or URDF that refers to no other files than meshes.
- solids: Makes the surfaces of MuJoCo's primitive shapes, as triangles (m, 3, 3) [m].
- surface: Makes the triangles of a look.
- thinning: Reduces the triangles of a robot with more details than the picture has pixels.
- thumbnail: Draws a thumbnail of the robot, a small square picture, in a guest process.
- turning: Draws the robot, and the robot as it turns, in a guest process.
- vectors: Converts vectors of numpy to the form that a look has: rounded, and plain data.
- webp: Writes an animated WebP; the only module that uses pillow.
"""

from collections.abc import Mapping
from typing import Literal

Kind = Literal["png", "turn", "none"]

PICTURE = "preview.png"
TURN = "preview.webp"
SMALL = "small.png"
"""The picture as a thumbnail; the file is only in the cache."""

THUMBNAIL = "thumbnail"
"""A small square picture that belongs to another file."""

REFUSED = "refused.json"
ENDED = "ended.json"
"""Files with the reason for a missing picture: refused, by a fault of the robot's files; or ended, by an
accident, which is not kept in the cache."""

VERSION = 6
"""Must be increased when the same robot gives another picture."""

SCENE = "scene.xml"


def names(kind: Kind) -> tuple[str, ...]:
    """Returns the names of the files of a kind of preview."""
    return {"png": (PICTURE,), "turn": (PICTURE, TURN), "none": ()}[kind]


def model_of(files: Mapping[str, bytes]) -> str | None:
    """Returns the file to draw: a scene, else a URDF, in the topmost folder with such a file; None without
    one."""
    paths = sorted(files, key=lambda path: (path.count("/"), path))
    scenes = [path for path in paths if path.rpartition("/")[2] == SCENE]
    return next(iter([*scenes, *(path for path in paths if path.endswith(".urdf"))]), None)


def needed_by(model: str, files: Mapping[str, bytes]) -> list[str]:
    """Returns the files that a model may read. A URDF needs robot.json too, which has its pose at home."""
    folder = model.rpartition("/")[0]
    # The URDF of a ROS package is in a folder beside that of its meshes.
    folder = folder.removesuffix("urdf").rstrip("/") if folder.endswith("/urdf") else folder
    prefix = f"{folder}/" if folder else ""
    in_folder = [path for path in files if path.startswith(prefix)]
    if model.endswith(".urdf"):
        needed = [path for path in in_folder if path == model or _is_asset(path)]
        return sorted({*needed, "robot.json"})
    return sorted(path for path in in_folder if path.endswith(".xml") or _is_asset(path))


def _is_asset(path: str) -> bool:
    return path.lower().endswith((".stl", ".obj", ".msh", ".glb", ".png", ".mtl"))
