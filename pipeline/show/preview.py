"""Draws the robot's picture for a build while later stages run, and keeps it in the cache by its content.

Imports nothing heavy: a cached build only reads the pictures.
"""

import importlib.util
import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from linkwright.pipeline.caching.actions import Action, Cache
from linkwright.pipeline.digest import sha256
from linkwright.stages.robot.errors import ConfigError, Diagnostic, LinkwrightError
from linkwright.stages.robot.system.install import install, installed
from linkwright.stages.show.preview import (
    ENDED,
    PICTURE,
    REFUSED,
    SMALL,
    VERSION,
    Kind,
    model_of,
    names,
    needed_by,
)
from linkwright.stages.show.preview.ask import Painting

Make = Callable[[], Mapping[str, bytes]]

CODE = "I-PREVIEW"

_HINT = "page.preview=none leaves it out"
_EXPORT_HINT = "export it as MJCF or URDF too: export=[mjcf,...]"


@dataclass(frozen=True, slots=True)
class Preview:
    """The pictures of a robot."""

    files: Mapping[str, bytes]
    """The pictures by file name."""

    small: bytes = b""
    """A PNG of at most 66 kB; b"" without a picture."""

    diagnostics: tuple[Diagnostic, ...] = ()
    """Diagnostics about a missing picture."""

    lasts: bool = True
    """Whether another build of the same robot gives the same pictures; false after an unexpected end."""

    @property
    def path(self) -> str:
        """The picture's file name; "" without one."""
        return PICTURE if PICTURE in self.files else ""


NONE = Preview({})


def require(kind: Kind) -> None:
    """Raises ConfigError if a kind of preview needs a library that is not installed."""
    if kind == "turn" and importlib.util.find_spec("PIL") is None:
        msg = "turn needs pillow, which is not installed"
        raise ConfigError(msg, "page.preview", install("pillow"))


@dataclass(frozen=True, slots=True)
class Drawing:
    """A drawing of pictures that runs beside the build: `result` waits for the pictures, and `end` cancels
    it."""

    result: Callable[[], Preview] = lambda: NONE
    end: Callable[[], None] = lambda: None


def start_drawing(
    cache: Cache,
    files: Mapping[str, bytes],
    digests: Mapping[str, str],
    kind: Kind,
    say: Callable[[str], None] = lambda _: None,
) -> Drawing:
    """Begins to draw the robot whose `files` were exported, unless the cache has a picture of its look.
    `digests`: the known SHA-256 digests of the files. `say`: called with a line about the drawing time."""
    if kind == "none" or "robot.json" not in files:
        return Drawing()
    model = model_of(files)
    if model is None:
        no_preview = _no_preview("MuJoCo reads none of the exported files", _EXPORT_HINT)
        return Drawing(lambda: no_preview)
    needed_paths = needed_by(model, files)
    inputs = {path: digests.get(path) or sha256(files[path]) for path in needed_paths}
    action = Action("preview", VERSION, {"model": model, "kind": kind}, inputs, _versions("mujoco", "numpy"))
    make, end = _no_pictures, _no_end
    if cache.reusable(action) is None:
        make, end = _begin_painting(cache, model, {path: files[path] for path in needed_paths}, kind, say)
    return Drawing(lambda: _preview(cache.run(action, make, lasts=_lasts)[0], kind), end)


def _begin_painting(
    cache: Cache, model: str, files: Mapping[str, bytes], kind: Kind, say: Callable[[str], None]
) -> tuple[Make, Callable[[], None]]:
    """Returns two functions: the first waits for the pictures of the model's look, which are drawn beside the
    build unless the cache has them; the second cancels the drawing."""
    # Late: cached pictures need none of it.
    from linkwright.stages.show.preview.compiled import look_of_files

    try:
        look = look_of_files(model, files)
    except LinkwrightError as error:
        refused = {REFUSED: json.dumps({"why": error.message}).encode()}
        return lambda: refused, _no_end
    versions = _versions("numpy", *(["pillow"] if kind == "turn" else []))
    action = Action("preview/look", VERSION, {"kind": kind, **look.key()}, {}, versions)
    if (pictures := cache.reusable(action)) is not None:
        return lambda: pictures, _no_end
    painting = Painting(look, kind)

    def make() -> Mapping[str, bytes]:
        pictures, _ = cache.run(action, painting.result, lasts=_lasts)
        say(f"the picture of the robot took {painting.seconds:.1f} s, beside the checks")
        return pictures

    return make, painting.end


def _preview(pictures: Mapping[str, bytes], kind: Kind) -> Preview:
    for file in (REFUSED, ENDED):
        if file in pictures:
            return _no_preview(json.loads(pictures[file])["why"], _HINT, lasts=file == REFUSED)
    return Preview({name: pictures[name] for name in names(kind)}, pictures[SMALL])


def _lasts(pictures: Mapping[str, bytes]) -> bool:
    return ENDED not in pictures


def _no_pictures() -> Mapping[str, bytes]:
    return {}


def _no_end() -> None:
    """Does nothing: nothing is being drawn."""


def _versions(*libraries: str) -> dict[str, str]:
    return {name: installed(name) for name in libraries}


def _no_preview(reason: str, hint: str, lasts: bool = True) -> Preview:
    diagnostic = Diagnostic(CODE, f"no preview of the robot: {reason}", PICTURE, hint)
    return Preview({}, diagnostics=(diagnostic,), lasts=lasts)
