"""Compiles an MJCF or URDF, as text or as a file, to a model of MuJoCo."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import mujoco

from linkwright.stages.formats.xml import parse, to_bytes
from linkwright.stages.mujoco.urdf import move_floating_joints_to_world, remove_package_prefixes
from linkwright.stages.mujoco.warnings import collected_warnings, deprecations, unquoted

MAX_CACHE_SIZE = 20_000_000
"""Largest size of MuJoCo's cache of processed meshes [bytes]."""


class NotCompiled(ValueError):
    """An error of a model that MuJoCo refuses, with MuJoCo's message."""


@contextmanager
def refusals(folder: Path | None = None) -> Iterator[None]:
    """Raises NotCompiled in place of any exception of MuJoCo inside the context. The message lacks the path
    of the model's `folder`, which says nothing about the robot."""
    try:
        yield
    except (ValueError, RuntimeError, SyntaxError, MemoryError, mujoco.FatalError) as error:
        message = unquoted(error)
        if folder is not None:
            message = message.replace(str(folder.resolve()), "")
        raise NotCompiled(message.strip()) from None


def compiled_text(text: bytes, files: Mapping[str, bytes]) -> Any:
    """Returns the model of an MJCF or URDF. `files`: path → content of the files that it refers to. Raises
    NotCompiled if MuJoCo refuses it."""
    with collected_warnings(), refusals():
        return mujoco.MjSpec.from_string(text.decode(), assets=dict(files)).compile()


def compiled_file(path: Path) -> Any:
    """Returns the model of an MJCF or URDF in its folder. Raises NotCompiled if MuJoCo refuses it."""
    with collected_warnings(), refusals(path.parent):
        return spec_of(path).compile()


def compiled_with_warnings(make: Callable[[], Any], folder: Path | None = None) -> tuple[Any, list[str]]:
    """Returns the model of the spec that `make` returns, and the warnings of MuJoCo and of its Python module.
    Raises NotCompiled if MuJoCo refuses the spec; the message lacks the path of the model's `folder`."""
    with collected_warnings() as warnings, deprecations(warnings), refusals(folder):
        return make().compile(), warnings


def compiled_and_rewritten(path: Path, files: Mapping[str, bytes]) -> tuple[Any, Any]:
    """Returns the model of an MJCF, and the model of the MJCF that MuJoCo writes from it. `files`: path →
    content of the files that the MJCF refers to. Raises NotCompiled if MuJoCo refuses either."""
    with deprecations([]), refusals():
        spec = spec_of_mjcf(path)
        first = spec.compile()
        return first, mujoco.MjSpec.from_string(spec.to_xml(), assets=dict(files)).compile()


def spec_of(path: Path) -> Any:
    """Returns MuJoCo's spec of an MJCF or URDF in its folder.

    A spec is freed after it is compiled, while MuJoCo's own loader keeps the meshes of the last file in
    memory.
    """
    if path.suffix != ".urdf":
        return spec_of_mjcf(path)
    _bound_cache()
    root = parse(path.read_bytes())
    remove_package_prefixes(root)
    if not move_floating_joints_to_world(root):
        # From the text, since MuJoCo 3.4.0 accepts only files whose names end in .xml.
        return spec_of_text(to_bytes(root), path.resolve().parent)
    meshes = {f"assets/{mesh.name}": mesh.read_bytes() for mesh in sorted((path.parent / "assets").glob("*"))}
    return mujoco.MjSpec.from_string(to_bytes(root).decode(), assets=meshes)


def spec_of_mjcf(path: Path) -> Any:
    """Returns MuJoCo's spec of an MJCF in its folder, whatever the file's extension."""
    _bound_cache()
    return mujoco.MjSpec.from_file(str(path.resolve()))


def spec_of_text(text: bytes, folder: Path) -> Any:
    """Returns MuJoCo's spec of a text whose paths are relative to `folder`."""
    spec = mujoco.MjSpec.from_string(text.decode())
    spec.modelfiledir = str(folder)
    return spec


def _bound_cache() -> None:
    """Limits MuJoCo's cache of processed meshes, which may take half a gigabyte by default. Versions of
    MuJoCo without the function keep the default."""
    set_capacity = getattr(mujoco, "mj_setCacheCapacity", None)
    if set_capacity is not None:
        set_capacity(mujoco.mj_getCache(), MAX_CACHE_SIZE)
