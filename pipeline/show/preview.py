"""The robot's picture for a build: drawn beside the stages that come, and kept in the cache by its content.

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

Make = Callable[[], Mapping[str, bytes]]

CODE = "I-PREVIEW"

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
    # Late: what was drawn before is not drawn again.
    from linkwright.stages.show.preview.ask import Painting
    from linkwright.stages.show.preview.compiled import look_of_files

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


def _versions(*libraries: str) -> dict[str, str]:
    return {name: installed(name) for name in libraries}


def _without(why: str, hint: str, lasts: bool = True) -> Preview:
    found = Diagnostic(CODE, f"no preview of the robot: {why}", PICTURE, hint)
    return Preview({}, found=(found,), lasts=lasts)
