"""MuJoCo as a reader of model files: the compiled model, and every warning on the way."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mujoco

from stages.formats.xml import element, parse, to_bytes
from stages.robot.check import Check
from stages.robot.mujoco_warnings import listening

KEPT_MESHES = 20_000_000
"""What MuJoCo may keep of the meshes of one model for the next [bytes]."""


@dataclass(frozen=True, slots=True)
class Loaded:
    """`model` is None where it did not compile; `check` says what MuJoCo said."""

    model: Any
    check: Check


def load(path: Path) -> Loaded:
    """Compiles one MJCF or URDF file from where it lies."""
    with listening() as heard:
        try:
            model = _compiled(path)
        except (ValueError, RuntimeError, SyntaxError) as error:
            # MuJoCo's message may name the folder of this build, which is no fact of the robot.
            said = str(error).replace(str(path.resolve().parent), "").strip()
            return Loaded(None, Check(f"{path.name}: compiles", False, said))
    return Loaded(model, quiet(f"{path.name}: compiles", heard))


def _compiled(path: Path) -> Any:
    """The model of a file. MuJoCo takes a floating joint only at the top: what floats from a URDF's root
    is read as floating from a world that holds the root, which is the same where the root stands still.

    By way of a spec, which is given up: MuJoCo's own loader holds on to the last file's meshes.
    """
    root = parse(path.read_bytes()) if path.suffix == ".urdf" else None
    afloat = [] if root is None else root.xpath("joint[@type='floating']/parent[@link != 'world']")
    _bound_cache()
    if not afloat:
        return _spec(path.resolve()).compile()
    holder = element(root, "joint", name="world_fixed", type="fixed")
    element(holder, "parent", link="world")
    element(holder, "child", link=afloat[0].get("link"))
    element(root, "link", name="world")
    for parent in afloat:
        parent.set("link", "world")
    meshes = {f"assets/{mesh.name}": mesh.read_bytes() for mesh in sorted((path.parent / "assets").glob("*"))}
    return mujoco.MjSpec.from_string(to_bytes(root).decode(), assets=meshes).compile()


def _spec(path: Path) -> Any:
    """What a file says. Of a URDF by its text, since MuJoCo 3.4.0 knows files by the ending .xml alone."""
    if path.suffix != ".urdf":
        return mujoco.MjSpec.from_file(str(path))
    spec = mujoco.MjSpec.from_string(path.read_text(encoding="utf-8"))
    spec.modelfiledir = str(path.parent)
    return spec


def _bound_cache() -> None:
    """Lets MuJoCo keep what it makes of small meshes from one model to the next, not what takes much
    memory: it keeps half a gigabyte by itself. Versions without this call keep it."""
    bound = getattr(mujoco, "mj_setCacheCapacity", None)
    if bound is not None:
        bound(mujoco.mj_getCache(), KEPT_MESHES)


def quiet(name: str, heard: list[str]) -> Check:
    """Passes where MuJoCo had nothing to warn of."""
    unique = sorted(set(heard))
    return Check(
        name, not unique, "; ".join(unique) or "without a warning from MuJoCo", float(len(unique)), 0.0
    )
