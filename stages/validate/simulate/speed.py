"""How fast the simulated file runs: a figure of the machine as much as of the robot, no check."""

import time
from pathlib import Path

import mujoco

from linkwright.stages.mujoco.compile import NotCompiled, compiled_file
from linkwright.stages.mujoco.state import at_keyframe
from linkwright.stages.mujoco.warnings import listening

SECONDS = 0.5
"""So long it is measured, in pieces of `PIECE` steps."""

PIECE = 50


def steps_per_second(folder: Path, robot: str) -> float | None:
    """Steps that MuJoCo makes in a second of one thread's time, from `home` with the controls there, to two
    digits; None where there is no MJCF that compiles and moves."""
    path = next((path for path in (folder / "scene.xml", folder / f"{robot}.xml") if path.exists()), None)
    if path is None:
        return None
    try:
        with listening():
            model = compiled_file(path)
            data = at_keyframe(model)
            mujoco.mj_step(model, data)
            steps, start = 0, time.thread_time()
            while (spent := time.thread_time() - start) < SECONDS:
                mujoco.mj_step(model, data, PIECE)
                steps += PIECE
    except NotCompiled:
        return None  # the checks say so
    return float(f"{steps / spent:.2g}") if model.nv else None
