"""MuJoCo as a reader of model files: the compiled model, and every warning on the way."""

from collections.abc import Iterator
from contextlib import contextmanager
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
    with listening() as heard:
        try:
            model = mujoco.MjModel.from_xml_path(str(path.resolve()))
        except (ValueError, RuntimeError) as error:
            # MuJoCo's message may name the folder of this build, which is no fact of the robot.
            said = str(error).replace(str(path.resolve().parent), "").strip()
            return Loaded(None, Check(f"{path.name}: compiles", False, said))
    return Loaded(model, quiet(f"{path.name}: compiles", heard))


@contextmanager
def listening() -> Iterator[list[str]]:
    """Collects MuJoCo's warnings, which would go to a log file in the working folder otherwise."""
    heard: list[str] = []
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(heard.append)
    try:
        yield heard
    finally:
        mujoco.set_mju_user_warning(before)


def quiet(name: str, heard: list[str]) -> Check:
    """Passes where MuJoCo had nothing to warn of."""
    unique = sorted(set(heard))
    return Check(
        name, not unique, "; ".join(unique) or "without a warning from MuJoCo", float(len(unique)), 0.0
    )
