"""Makes the live view of a robot for its page once, and keeps it in the cache by its content.

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
from linkwright.stages.show.live.pack import read_pack
from linkwright.stages.show.live.viewer import engine_script

if TYPE_CHECKING:
    from linkwright.pipeline.stages.context import BuildContext

ENGINE_FILE = "linkwright-engine.js"
"""The file of an engine that several pages share: beside the page, or in the folder of a sweep."""

CODE = "I-LIVE"
_LIBRARIES = ("linkwright", "mujoco", "numpy", "scipy", "manifold3d", "lxml")

_PACK, _POSED, _REFUSED = "pack", "posed.pack", "refused.txt"
"""Files of a cached view: a pack, a pack without a model for the engine, or the reason for no pack."""

_NO_VIEW = "no live view"

Engine = Literal["whole", "shared", "none"]


@dataclass(frozen=True, slots=True)
class Live:
    """The live view of a page."""

    pack: bytes | None = None
    """The robot's pack; None for a page without the view."""

    engine: Engine = "none"
    """The place of the engine: whole in the page, shared in the file at `engine_path`, or none."""

    engine_path: str = ""
    files: Mapping[str, bytes] = field(default_factory=dict)
    """The files to write beside the page."""

    diagnostics: tuple[Diagnostic, ...] = ()
    """Diagnostics about a missing view."""

    lasts: bool = True
    """Whether another build of the same robot gives the same view; false after an unexpected error."""


NOTHING = Live()


def is_plain(environ: Mapping[str, str]) -> bool:
    """Tells whether the environment asks for pages without the live view, and for no picture."""
    return environ.get("LINKWRIGHT_PAGE", os.environ.get("LINKWRIGHT_PAGE", "")) == "plain"


def live(
    context: "BuildContext",
    colliders: Iterable[Mapping[str, Any]],
    folder: Path,
    sweep: Path | None,
    say: Callable[[str], None],
) -> Live:
    """Returns the view of the robot that a build exports to `folder`, from the cache if possible.

    `colliders`: rows of the report's table. `sweep`: the folder of the sweep that the build belongs to.
    `say`: called with a line about the time that making the view took. If the view cannot be made, the result
    has a diagnostic; no error is raised.
    """
    if "export" not in context.files or is_plain(context.environ):
        return NOTHING
    exported = context.files["export"].below(FILES)
    source = source_of(exported, context.plan.name)
    if source is None:
        message = f"{_NO_VIEW}: there is no MJCF or URDF"
        return Live(diagnostics=(Diagnostic(CODE, message, "report.html", "export one: export=[mjcf,...]"),))
    try:
        files = _view_files(context, source, [_shown_fields(row) for row in colliders], say)
    except Exception as error:  # Whatever it is, the robot is built.
        message = f"{_NO_VIEW}: {type(error).__name__}: {error}"
        return Live(diagnostics=(Diagnostic(CODE, message, "report.html", ""),), lasts=False)
    if _REFUSED in files:
        message = f"{_NO_VIEW}: {files[_REFUSED].decode()}"
        return Live(diagnostics=(Diagnostic(CODE, message, "report.html", ""),))
    if _POSED in files:
        return Live(files[_POSED])
    return _with_engine(files[_PACK], context.plan.page.live, folder, sweep)


def _with_engine(pack: bytes, choice: str, folder: Path, sweep: Path | None) -> Live:
    if choice == "kinematics":
        return Live(pack)
    if sweep is not None:
        path = PurePosixPath(Path(os.path.relpath(sweep / ENGINE_FILE, folder)).as_posix())
        return Live(pack, "shared", str(path))
    return view_of(pack, "shared" if choice == "shared" else "whole")


def view_of(pack: bytes | None, engine: Engine) -> Live:
    """Returns the view of a page outside of a sweep."""
    if engine == "shared":
        return Live(pack, engine, ENGINE_FILE, {ENGINE_FILE: engine_file()})
    return Live(pack, engine)


def engine_file() -> bytes:
    """Returns the content of the engine's file."""
    return engine_script()


def _view_files(
    context: "BuildContext", source: str, colliders: list[dict[str, Any]], say: Callable[[str], None]
) -> Mapping[str, bytes]:
    """Returns the files of the view, as the cache keeps them."""
    exported = context.files["export"].below(FILES)
    needed_paths = [path for path in sorted(exported) if not path.endswith(NEVER_READ)]
    faces = context.plan.page.faces

    def make() -> dict[str, bytes]:
        # Late: a cached view needs none of it.
        from linkwright.stages.show.live.scene import pack_of

        start = time.perf_counter()
        with context.cache.store.scratch({path: exported[path] for path in needed_paths}) as folder:
            try:
                pack = pack_of(folder, source, context.robot, colliders, faces)
            except ValueError as error:
                # MuJoCo's message may name the folder.
                return {_REFUSED: str(error).replace(str(folder), "").strip().encode()}
        say(f"the view of the robot took {time.perf_counter() - start:.1f} s, {len(pack) / 1e6:.2f} MB")
        return {_PACK if read_pack(pack)[0]["engine"] else _POSED: pack}

    inputs = {path: exported.digests[path] for path in needed_paths}
    inputs |= {"robot": context.files["graph"].digests[ROBOT], "colliders": sha256(canonical(colliders))}
    config = {"source": source, "faces": faces}
    versions = {name: installed(name) for name in _LIBRARIES}
    result, _ = context.cache.run(Action("page/live", VERSION, config, inputs, versions), make)
    return result


def _shown_fields(row: Mapping[str, Any]) -> dict[str, Any]:
    """Returns the fields of a row of the colliders' table that the page shows, without facts about the
    run."""
    names = ("link", "parts", "rung", "maker", "tolerance", "meets", "protrusion_max", "bareness_max")
    return {name: row.get(name) for name in names}
