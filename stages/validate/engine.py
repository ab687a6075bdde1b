"""MuJoCo as a reader of model files: the compiled model, and every warning on the way."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mujoco

from stages.robot.check import Check
from stages.robot.listening import listening
from stages.robot.xml import element, parse, to_bytes


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
    is read as floating from a world that holds the root, which is the same where the root stands still."""
    root = parse(path.read_bytes()) if path.suffix == ".urdf" else None
    afloat = [] if root is None else root.xpath("joint[@type='floating']/parent[@link != 'world']")
    if not afloat:
        return mujoco.MjModel.from_xml_path(str(path.resolve()))
    holder = element(root, "joint", name="world_fixed", type="fixed")
    element(holder, "parent", link="world")
    element(holder, "child", link=afloat[0].get("link"))
    element(root, "link", name="world")
    for parent in afloat:
        parent.set("link", "world")
    meshes = {f"assets/{mesh.name}": mesh.read_bytes() for mesh in sorted((path.parent / "assets").glob("*"))}
    return mujoco.MjModel.from_xml_string(to_bytes(root).decode(), meshes)


def quiet(name: str, heard: list[str]) -> Check:
    """Passes where MuJoCo had nothing to warn of."""
    unique = sorted(set(heard))
    return Check(
        name, not unique, "; ".join(unique) or "without a warning from MuJoCo", float(len(unique)), 0.0
    )
