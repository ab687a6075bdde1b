"""MJCF and URDF in another MuJoCo: statics to 1e-9, a second of motion, five seconds of servos."""

import mujoco
import numpy as np
import reference as own
from told import KINEMATICS, MOTION, apart, links_apart, masses_apart, run

EXACT = 1e-9
"""The tolerance of masses, mass matrices and biases, as a share."""


def main(folder, reference, rows):
    files = reference["files"]
    readers = {
        "mjcf": lambda: own.held(folder / files["mjcf"]),
        "urdf": lambda: own.with_links(folder / files["urdf"]),
    }
    for kind, read in readers.items():
        if kind in files:
            model = rows.trying(kind, "loads", read)
            if model is not None:
                rows.measured(kind, "loads", 0, 0)
                statics(model, reference[kind], kind, rows)
    scene = rows.trying("scene", "loads", lambda: mujoco.MjModel.from_xml_path(str(folder / files["scene"])))
    if scene is not None:
        for start, push in own.STARTS.items():
            motion(own.scene_motion(scene, push), reference["scene"][start], start, rows)
    return mujoco.__version__


def statics(model, expected, kind, rows):
    found = own.tree(model)
    if found["joints"] != expected["joints"]:
        rows.failed(
            kind, "joints", f"{len(found['joints'])} of {len(expected['joints'])}, or in another order"
        )
        return
    rows.measured(kind, "masses", masses_apart(found["masses"], expected["masses"]), EXACT)
    pairs = list(zip(found["poses"], expected["poses"], strict=True))
    rows.measured(kind, "kinematics", max(links_apart(a["links"], b["links"]) for a, b in pairs), KINEMATICS)
    for thing in ("mass_matrix", "bias"):
        worst = max(apart(a[thing], b[thing]) / np.abs(b[thing]).max(initial=1e-12) for a, b in pairs)
        rows.measured(kind, thing.replace("_", " "), worst, EXACT)
    clear = expected["bare"]["clear"]
    off = apart(found["bare"]["qpos"][:clear], expected["bare"]["qpos"][:clear])
    rows.measured(kind, "motion", off, MOTION)


def motion(found, expected, start, rows):
    if found["timestep"] != expected["timestep"]:
        rows.failed("scene", "time step", f"{found['timestep']} s for {expected['timestep']} s")
        return
    rows.measured("scene", f"{start}: 100 steps", apart(found["hundred"], expected["hundred"]), MOTION)
    if start == "saturated":
        return  # what is left of it later is chance
    rows.measured("scene", f"{start}: 1 s", apart(found["end"], expected["end"]), MOTION)
    rows.measured("scene", f"{start}: 5 s", apart(found["held"], expected["held"]), MOTION)


if __name__ == "__main__":
    run(main)
