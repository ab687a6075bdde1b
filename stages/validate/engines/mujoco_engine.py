"""MuJoCo as an `Engine`: the compiled model of an MJCF or URDF, and every warning on the way."""

from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import mujoco

from stages.formats.xml import Element, element, parse, to_bytes
from stages.robot.check import Check
from stages.robot.mujoco_warnings import deprecations, listening, unquoted
from stages.validate.compiled import Loaded, without_warnings
from stages.validate.located import located

CODE = "C-COMPILE"

KEPT_MESHES = 20_000_000
"""The size of MuJoCo's cache of processed meshes [bytes]."""


def files(robot: str) -> tuple[str, ...]:
    """The names of the files that it reads, for a robot of this name."""
    return f"{robot}.xml", "scene.xml", f"{robot}.urdf"


def warnings() -> AbstractContextManager[list[str]]:
    """Collects what MuJoCo warns of while models are used."""
    return listening()


def load(path: Path) -> Loaded:
    """Compiles one MJCF or URDF file from where it lies."""
    with listening() as found, deprecations(found):
        try:
            model = spec_of(path).compile()
        except (ValueError, RuntimeError, SyntaxError) as error:
            # MuJoCo's message may name the folder of this build, which is no fact of the robot.
            message = unquoted(error).replace(str(path.resolve().parent), "").strip()
            where = located(path, message)
            return Loaded(None, Check(f"{path.name}: compiles", False, message, code=CODE, findings=where))
    return Loaded(model, without_warnings(f"{path.name}: compiles", found, CODE))


def spec_of(path: Path) -> Any:
    """What MuJoCo compiles of a file. MuJoCo accepts a floating joint only below the world, so a link
    `world` is put above a URDF's root and the floating joints are moved to it: the same, since the root does
    not move.

    A spec, which is given up once it is compiled: MuJoCo's own loader keeps the last file's meshes in memory.
    """
    _bound_cache()
    if path.suffix != ".urdf":
        return mujoco.MjSpec.from_file(str(path.resolve()))
    root = parse(path.read_bytes())
    _without_packages(root)
    floating = root.xpath("joint[@type='floating']/parent[@link != 'world']")
    if not floating:
        return _spec_of_urdf(root, path.resolve().parent)
    holder = element(root, "joint", name="world_fixed", type="fixed")
    element(holder, "parent", link="world")
    element(holder, "child", link=floating[0].get("link"))
    element(root, "link", name="world")
    for parent in floating:
        parent.set("link", "world")
    meshes = {f"assets/{mesh.name}": mesh.read_bytes() for mesh in sorted((path.parent / "assets").glob("*"))}
    return mujoco.MjSpec.from_string(to_bytes(root).decode(), assets=meshes)


def _spec_of_urdf(root: Element, folder: Path) -> Any:
    """The spec of a URDF: from its text, since MuJoCo 3.4.0 accepts only files that end in .xml."""
    spec = mujoco.MjSpec.from_string(to_bytes(root).decode())
    spec.modelfiledir = str(folder)
    return spec


def _without_packages(root: Element) -> None:
    """Makes the paths `package://<package>/...` relative: a URDF lies at the top of its package, whose name
    MuJoCo takes for a folder."""
    for node in root.xpath("//*[starts-with(@filename, 'package://')]"):
        node.set("filename", node.get("filename").removeprefix("package://").partition("/")[2])


def _bound_cache() -> None:
    """Limits MuJoCo's cache of processed meshes, which may take half a gigabyte by default. Versions without
    this call keep the default."""
    bound = getattr(mujoco, "mj_setCacheCapacity", None)
    if bound is not None:
        bound(mujoco.mj_getCache(), KEPT_MESHES)
