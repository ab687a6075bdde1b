"""MuJoCo as a reader of model files: the compiled model, and every warning on the way."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mujoco

from stages.robot.check import Check


@dataclass(frozen=True, slots=True)
class Loaded:
    """`model` is None where it did not compile; `check` says what MuJoCo said."""

    model: Any
    check: Check


def load(path: Path) -> Loaded:
    """Compiles one MJCF or URDF file from where it lies."""
    heard: list[str] = []
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(heard.append)
    try:
        model = mujoco.MjModel.from_xml_path(str(path.resolve()))
    except (ValueError, RuntimeError) as error:
        # MuJoCo's message may name the folder of this build, which is no fact of the robot.
        said = str(error).replace(str(path.resolve().parent), "").strip()
        return Loaded(None, Check(f"{path.name}: compiles", False, said))
    finally:
        mujoco.set_mju_user_warning(before)
    unique = sorted(set(heard))
    detail = "; ".join(unique) if unique else "MuJoCo compiles it without warnings"
    return Loaded(model, Check(f"{path.name}: compiles", not unique, detail, float(len(unique)), 0.0))
