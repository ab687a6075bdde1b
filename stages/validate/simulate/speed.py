"""Measures the speed of the simulation. It is not a check, since it also depends on the machine."""

import time
from pathlib import Path

import mujoco

from linkwright.stages.mujoco.compile import NotCompiled, compiled_file
from linkwright.stages.mujoco.state import at_keyframe
from linkwright.stages.mujoco.warnings import collected_warnings

MIN_SECONDS = 0.5
"""Smallest duration [s] of the measurement, which is done in pieces of `STEPS_PER_PIECE` steps."""

STEPS_PER_PIECE = 50
"""Number of steps between two looks at the clock."""


def steps_per_second(folder: Path, robot: str) -> float | None:
    """Returns the number of steps per second of a single thread's time, to two digits, from `home` with the
    controls there. Returns None without an MJCF that compiles and moves."""
    path = next((path for path in (folder / "scene.xml", folder / f"{robot}.xml") if path.exists()), None)
    if path is None:
        return None
    try:
        with collected_warnings():
            model = compiled_file(path)
            data = at_keyframe(model)
            mujoco.mj_step(model, data)
            steps, start = 0, time.thread_time()
            while (elapsed := time.thread_time() - start) < MIN_SECONDS:
                mujoco.mj_step(model, data, STEPS_PER_PIECE)
                steps += STEPS_PER_PIECE
    except NotCompiled:
        return None  # the checks report it
    return float(f"{steps / elapsed:.2g}") if model.nv else None
