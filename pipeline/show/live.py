"""The view of a robot for its page: made once, and kept in the cache by its content.

Imports nothing heavy: a cached build only reads the pack.
"""

import os
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Any, Literal

from linkwright.pipeline.caching.actions import Action, canonical
from linkwright.pipeline.digest import sha256
from linkwright.pipeline.stages.context import FILES, ROBOT
from linkwright.stages.robot.errors import Diagnostic
from linkwright.stages.robot.system.install import installed
from linkwright.stages.show.live import NEVER_READ, VERSION, source_of
from linkwright.stages.show.live.viewer import engine_script

if TYPE_CHECKING:
    from linkwright.pipeline.stages.context import BuildContext

ENGINE_FILE = "linkwright-engine.js"
"""The engine of several pages, beside the page or in the folder of a sweep."""

CODE = "I-LIVE"
_LIBRARIES = ("linkwright", "mujoco", "numpy", "scipy", "manifold3d", "lxml")

_PACK, _POSED, _REFUSED = "pack", "posed.pack", "refused.txt"
"""What is kept: a pack, one without a model for the engine, or why there is none."""

_WITHOUT = "no live view"

Engine = Literal["whole", "shared", "none"]


@dataclass(frozen=True, slots=True)
class Live:
    """The view of a page: the robot's pack, None for a page without the view; the engine, in the page, in the
    file at `engine_path`, or none; the `files` beside the page; and why something is not there.

    `lasts`: whether another build of the same has the same; not after an accident."""

    pack: bytes | None = None
    engine: Engine = "none"
    engine_path: str = ""
    files: Mapping[str, bytes] = field(default_factory=dict)
    found: tuple[Diagnostic, ...] = ()
    lasts: bool = True


NOTHING = Live()


def is_plain(environ: Mapping[str, str]) -> bool:
    """Whether the environment asks for pages without the live view, and for no picture."""
    return environ.get("LINKWRIGHT_PAGE", os.environ.get("LINKWRIGHT_PAGE", "")) == "plain"


def live(
    context: "BuildContext",
    colliders: Iterable[Mapping[str, Any]],
    folder: Path,
    sweep: Path | None,
    say: Callable[[str], None],
) -> Live:
    """The view of the robot that a build exports to `folder`, from the cache where it was made before.

    `colliders`: rows of the report's table. `sweep`: the folder of the sweep that the build is a job of. What
    cannot be made is a diagnostic, never an error. `say` is told how long making it took.
    """
    if "export" not in context.files or is_plain(context.environ):
        return NOTHING
    exported = context.files["export"].below(FILES)
    source = source_of(exported, context.plan.name)
    if source is None:
        why = f"{_WITHOUT}: there is no MJCF or URDF"
        return Live(found=(Diagnostic(CODE, why, "report.html", "export one: export=[mjcf,...]"),))
    try:
        made = _made(context, source, [_shown(row) for row in colliders], say)
    except Exception as error:  # Whatever it is, the robot is built.
        why = f"{_WITHOUT}: {type(error).__name__}: {error}"
        return Live(found=(Diagnostic(CODE, why, "report.html", ""),), lasts=False)
    if _REFUSED in made:
        why = f"{_WITHOUT}: {made[_REFUSED].decode()}"
        return Live(found=(Diagnostic(CODE, why, "report.html", ""),))
    if _POSED in made:
        return Live(made[_POSED])
    return _with_engine(made[_PACK], context.plan.page.live, folder, sweep)


def _with_engine(pack: bytes, asked: str, folder: Path, sweep: Path | None) -> Live:
    if asked == "kinematics":
        return Live(pack)
    if sweep is not None:
        path = PurePosixPath(Path(os.path.relpath(sweep / ENGINE_FILE, folder)).as_posix())
        return Live(pack, "shared", str(path))
    return view_of(pack, "shared" if asked == "shared" else "whole")


def view_of(pack: bytes | None, engine: Engine) -> Live:
    """The view of a page that is no page of a sweep."""
    if engine == "shared":
        return Live(pack, engine, ENGINE_FILE, {ENGINE_FILE: engine_file()})
    return Live(pack, engine)


def engine_file() -> bytes:
    """The content of the engine's file."""
    return engine_script()


def _made(
    context: "BuildContext", source: str, colliders: list[dict[str, Any]], say: Callable[[str], None]
) -> Mapping[str, bytes]:
    """What is kept of the view."""
    exported = context.files["export"].below(FILES)
    needed = [path for path in sorted(exported) if not path.endswith(NEVER_READ)]
    faces = context.plan.page.faces

    def make() -> dict[str, bytes]:
        # Late: what was made before is not made again.
        from linkwright.stages.show.live.pack import unpacked
        from linkwright.stages.show.live.scene import pack_of

        start = time.perf_counter()
        with context.cache.store.scratch({path: exported[path] for path in needed}) as folder:
            try:
                pack = pack_of(folder, source, context.robot, colliders, faces)
            except ValueError as error:
                # MuJoCo's message may name the folder.
                return {_REFUSED: str(error).replace(str(folder), "").strip().encode()}
        say(f"the view of the robot took {time.perf_counter() - start:.1f} s, {len(pack) / 1e6:.2f} MB")
        return {_PACK if unpacked(pack)[0]["engine"] else _POSED: pack}

    inputs = {path: exported.digests[path] for path in needed}
    inputs |= {"robot": context.files["graph"].digests[ROBOT], "colliders": sha256(canonical(colliders))}
    config = {"source": source, "faces": faces}
    versions = {name: installed(name) for name in _LIBRARIES}
    found, _ = context.cache.run(Action("page/live", VERSION, config, inputs, versions), make)
    return found


def _shown(row: Mapping[str, Any]) -> dict[str, Any]:
    """What the page shows of a row of the table of colliders: no fact of the run."""
    names = ("link", "parts", "rung", "maker", "tolerance", "meets", "protrusion_max", "bareness_max")
    return {name: row.get(name) for name in names}
