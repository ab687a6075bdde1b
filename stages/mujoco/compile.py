"""From text or a file to a compiled model, or MuJoCo's reason why not."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import mujoco

from linkwright.stages.formats.xml import parse, to_bytes
from linkwright.stages.mujoco.urdf import with_floating_on_world, without_packages
from linkwright.stages.mujoco.warnings import deprecations, listening, unquoted

KEPT_MESHES = 20_000_000
"""The size of MuJoCo's cache of processed meshes [bytes]."""


class NotCompiled(ValueError):
    """MuJoCo refuses a model; the message is MuJoCo's."""


@contextmanager
def refusals(folder: Path | None = None) -> Iterator[None]:
    """Raises NotCompiled for whatever MuJoCo raises inside, without the path of the model's `folder`, which
    is no fact of the robot."""
    try:
        yield
    except (ValueError, RuntimeError, SyntaxError, MemoryError, mujoco.FatalError) as error:
        message = unquoted(error)
        if folder is not None:
            message = message.replace(str(folder.resolve()), "")
        raise NotCompiled(message.strip()) from None


def compiled_text(text: bytes, files: Mapping[str, bytes]) -> Any:
    """The model of an MJCF or URDF whose other files are `files`, by path. NotCompiled where MuJoCo refuses
    it."""
    with listening(), refusals():
        return mujoco.MjSpec.from_string(text.decode(), assets=dict(files)).compile()


def compiled_file(path: Path) -> Any:
    """The model of an MJCF or URDF where it lies. NotCompiled where MuJoCo refuses it."""
    with listening(), refusals(path.parent):
        return spec_of(path).compile()


def compiled_heard(make: Callable[[], Any], folder: Path | None = None) -> tuple[Any, list[str]]:
    """The model of the spec that `make` returns, and the warnings of MuJoCo and of its Python module.
    NotCompiled where MuJoCo refuses it, its message without the path of the model's `folder`."""
    with listening() as warnings, deprecations(warnings), refusals(folder):
        return make().compile(), warnings


def compiled_and_rewritten(path: Path, files: Mapping[str, bytes]) -> tuple[Any, Any]:
    """The model of an MJCF, and the model of what MuJoCo writes of it; `files`: the MJCF's other files, by
    path. NotCompiled where MuJoCo refuses either."""
    with deprecations([]), refusals():
        spec = spec_of_mjcf(path)
        first = spec.compile()
        return first, mujoco.MjSpec.from_string(spec.to_xml(), assets=dict(files)).compile()


def spec_of(path: Path) -> Any:
    """What MuJoCo compiles of an MJCF or URDF where it lies.

    A spec, which is given up once it is compiled: MuJoCo's own loader keeps the last file's meshes in memory.
    """
    if path.suffix != ".urdf":
        return spec_of_mjcf(path)
    _bound_cache()
    root = parse(path.read_bytes())
    without_packages(root)
    if not with_floating_on_world(root):
        # From its text, since MuJoCo 3.4.0 accepts only files that end in .xml.
        return spec_of_text(to_bytes(root), path.resolve().parent)
    meshes = {f"assets/{mesh.name}": mesh.read_bytes() for mesh in sorted((path.parent / "assets").glob("*"))}
    return mujoco.MjSpec.from_string(to_bytes(root).decode(), assets=meshes)


def spec_of_mjcf(path: Path) -> Any:
    """What MuJoCo compiles of an MJCF where it lies, whatever its ending."""
    _bound_cache()
    return mujoco.MjSpec.from_file(str(path.resolve()))


def spec_of_text(text: bytes, folder: Path) -> Any:
    """What MuJoCo compiles of a text whose paths are below `folder`."""
    spec = mujoco.MjSpec.from_string(text.decode())
    spec.modelfiledir = str(folder)
    return spec


def _bound_cache() -> None:
    """Limits MuJoCo's cache of processed meshes, which may take half a gigabyte by default. Versions without
    this call keep the default."""
    bound = getattr(mujoco, "mj_setCacheCapacity", None)
    if bound is not None:
        bound(mujoco.mj_getCache(), KEPT_MESHES)
