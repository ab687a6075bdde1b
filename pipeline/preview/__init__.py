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

import importlib.util
import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal

from linkwright.pipeline.caching.actions import Action, Cache
from linkwright.pipeline.digest import sha256
from linkwright.stages.robot.errors import ConfigError, Diagnostic, LinkwrightError
from linkwright.stages.robot.system.install import install, installed

Kind = Literal["png", "turn", "none"]
Make = Callable[[], Mapping[str, bytes]]

PICTURE = "preview.png"
TURN = "preview.webp"
SMALL = "small.png"
"""The picture in the size of a thumbnail, which is a file only in the cache."""

REFUSED = "refused.json"
ENDED = "ended.json"
"""Why there is no picture: by the robot's files, and by an accident that is not kept."""

VERSION = 5
CODE = "I-PREVIEW"

SCENE = "scene.xml"
_HINT = "page.preview=none leaves it out"
_OTHERWISE = "export it as MJCF or URDF too: export=[mjcf,...]"


@dataclass(frozen=True, slots=True)
class Preview:
    """`files`: the pictures by file name; `small`: a PNG of at most 66 kB, b"" without a picture; `found`:
    why there is none. `lasts`: whether another build of the same has the same; not after an accident."""

    files: Mapping[str, bytes]
    small: bytes = b""
    found: tuple[Diagnostic, ...] = ()
    lasts: bool = True

    @property
    def path(self) -> str:
        """The picture's file name; "" without one."""
        return PICTURE if PICTURE in self.files else ""


NONE = Preview({})


def names(kind: Kind) -> tuple[str, ...]:
    """The files of a kind of preview."""
    return {"png": (PICTURE,), "turn": (PICTURE, TURN), "none": ()}[kind]


def require(kind: Kind) -> None:
    """ConfigError where a kind of preview needs a library that is not installed."""
    if kind == "turn" and importlib.util.find_spec("PIL") is None:
        msg = "turn needs pillow, which is not installed"
        raise ConfigError(msg, "page.preview", install("pillow"))


@dataclass(frozen=True, slots=True)
class Drawing:
    """Pictures that are being drawn beside the build: `result` waits for them, and `end` gives them up."""

    result: Callable[[], Preview] = lambda: NONE
    end: Callable[[], None] = lambda: None


def begun(
    cache: Cache,
    files: Mapping[str, bytes],
    digests: Mapping[str, str],
    kind: Kind,
    say: Callable[[str], None] = lambda _: None,
) -> Drawing:
    """Begins to draw the robot whose `files` were exported, where no picture of its look was made before.
    `digests`: SHA-256 of each file, as far as they are known. `say` is told how long making them took."""
    if kind == "none" or "robot.json" not in files:
        return Drawing()
    model = model_of(files)
    if model is None:
        without = _without("MuJoCo reads none of the exported files", _OTHERWISE)
        return Drawing(lambda: without)
    needed = needed_by(model, files)
    inputs = {path: digests.get(path) or sha256(files[path]) for path in needed}
    action = Action("preview", VERSION, {"model": model, "kind": kind}, inputs, _versions("mujoco", "numpy"))
    make, end = _nothing, _no_end
    if cache.known(action) is None:
        make, end = _made(cache, model, {path: files[path] for path in needed}, kind, say)
    return Drawing(lambda: _kept(cache.run(action, make, lasts=_lasts)[0], kind), end)


def _made(
    cache: Cache, model: str, files: Mapping[str, bytes], kind: Kind, say: Callable[[str], None]
) -> tuple[Make, Callable[[], None]]:
    """What waits for the pictures of a look, which are drawn beside the build unless they were made before,
    and what gives them up."""
    from linkwright.pipeline.preview.ask import Painting
    from linkwright.pipeline.preview.compiled import look_of_files

    try:
        look = look_of_files(model, files)
    except LinkwrightError as error:
        refused = {REFUSED: json.dumps({"why": error.message}).encode()}
        return lambda: refused, _no_end
    versions = _versions("numpy", *(["pillow"] if kind == "turn" else []))
    action = Action("preview/look", VERSION, {"kind": kind, **look.key()}, {}, versions)
    if (known := cache.known(action)) is not None:
        return lambda: known, _no_end
    painting = Painting(look, kind)

    def make() -> Mapping[str, bytes]:
        made, _ = cache.run(action, painting.result, lasts=_lasts)
        say(f"the picture of the robot took {painting.seconds:.1f} s, beside the checks")
        return made

    return make, painting.end


def _kept(made: Mapping[str, bytes], kind: Kind) -> Preview:
    for why in (REFUSED, ENDED):
        if why in made:
            return _without(json.loads(made[why])["why"], _HINT, lasts=why == REFUSED)
    return Preview({name: made[name] for name in names(kind)}, made[SMALL])


def _lasts(made: Mapping[str, bytes]) -> bool:
    return ENDED not in made


def _nothing() -> Mapping[str, bytes]:
    return {}


def _no_end() -> None:
    """Nothing is being drawn."""


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


def _versions(*libraries: str) -> dict[str, str]:
    return {name: installed(name) for name in libraries}


def _without(why: str, hint: str, lasts: bool = True) -> Preview:
    found = Diagnostic(CODE, f"no preview of the robot: {why}", PICTURE, hint)
    return Preview({}, found=(found,), lasts=lasts)
