"""The robot's picture: `preview.png` of every build that exports, and where it is wished a turn,
`preview.webp`.

It is drawn by the processor alone, from the look that the robot has in MuJoCo's model of the exported files,
in a process of its own beside the build: the same picture on every machine, without a graphics driver, and
never a failed build. A change that the robot's look does not show draws nothing.

- ask: Asks the guest that draws, within limits of time and memory.
- camera: The camera: where it stands so that all of the robot is in the picture, and what it sees there.
- compiled: What is seen of a robot that MuJoCo compiled, at its keyframe `home`.
- guest: Guest process that draws the robot: many triangles take memory, and time.
- look: What is seen of a robot, as plain data: shapes, where they are at `home`, their colours, and the
  camera.
- model_text: The text that MuJoCo compiles: one MJCF or URDF without links to other files but its meshes.
- solids: Surfaces of MuJoCo's primitive shapes, as triangles (m, 3, 3) [m].
- surface: The triangles of a look.
- thinning: Fewer triangles for a robot that has more than there are pixels.
- webp: An animated WebP of pictures: the one place that needs pillow.
"""

from collections.abc import Mapping
from typing import Literal

Kind = Literal["png", "turn", "none"]

PICTURE = "preview.png"
TURN = "preview.webp"
SMALL = "small.png"
"""The picture in the size of a thumbnail, which is a file only in the cache."""

REFUSED = "refused.json"
ENDED = "ended.json"
"""Why there is no picture: by the robot's files, and by an accident that is not kept."""

VERSION = 5
"""Raised when the same robot gives another picture."""

SCENE = "scene.xml"


def names(kind: Kind) -> tuple[str, ...]:
    """The files of a kind of preview."""
    return {"png": (PICTURE,), "turn": (PICTURE, TURN), "none": ()}[kind]


def model_of(files: Mapping[str, bytes]) -> str | None:
    """The file from which the picture is drawn: a scene, else a URDF, the one in the highest folder."""
    paths = sorted(files, key=lambda path: (path.count("/"), path))
    scenes = [path for path in paths if path.rpartition("/")[2] == SCENE]
    return next(iter([*scenes, *(path for path in paths if path.endswith(".urdf"))]), None)


def needed_by(model: str, files: Mapping[str, bytes]) -> list[str]:
    """The files that a model may read: of a URDF the pose at home too, which it does not have."""
    folder = model.rpartition("/")[0]
    # The URDF of a ROS package lies in a folder beside that of its meshes.
    folder = folder.removesuffix("urdf").rstrip("/") if folder.endswith("/urdf") else folder
    prefix = f"{folder}/" if folder else ""
    own = [path for path in files if path.startswith(prefix)]
    if model.endswith(".urdf"):
        kept = [path for path in own if path == model or _is_asset(path)]
        return sorted({*kept, "robot.json"})
    return sorted(path for path in own if path.endswith(".xml") or _is_asset(path))


def _is_asset(path: str) -> bool:
    return path.lower().endswith((".stl", ".obj", ".msh", ".png", ".mtl"))
