"""What drivers share: the reference that they are given, and the rows that they print. Only NumPy."""

import json
import sys
import traceback
from pathlib import Path

import numpy as np

KINEMATICS = 1e-6
MASSES = 1e-6
MOTION = 1e-3
"""[m, rad]"""

FRAME = 1e-9
"""[kg] A link of less is a frame, which has a mass for readers that need some."""

SECOND = 1.0
"""[s] of a motion."""


class Rows:
    """Rows of one engine and robot, printed as JSON at the end."""

    def __init__(self):
        self.rows = []

    def measured(self, kind, thing, off, limit, said=""):
        """`off`: how far it is from the reference, which must be within `limit`."""
        off = float(off)
        row = {"format": kind, "thing": thing, "off": off, "holds": bool(off <= limit), "said": said}
        self.rows.append(row)

    def failed(self, kind, thing, said):
        row = {"format": kind, "thing": thing, "off": None, "holds": False, "said": said}
        self.rows.append(row)

    def trying(self, kind, thing, measure):
        """What `measure` returns, None where it fails, which is a row."""
        try:
            return measure()
        except Exception as error:
            traceback.print_exc()
            lines = [line for line in str(error).splitlines() if line.strip()] or [""]
            self.failed(kind, thing, f"{type(error).__name__}: {lines[-1].strip()[:160]}")
            return None


def run(measure):
    """`measure(folder, reference, rows)` with the arguments of the command: the folder of a build and its
    reference; prints {"version": text, "rows": [...]}, to a stream of its own since engines print too."""
    folder, reference = Path(sys.argv[1]), json.loads(Path(sys.argv[2]).read_text())
    rows = Rows()
    version = measure(folder, reference, rows)
    Path(sys.argv[3]).write_text(json.dumps({"version": version, "rows": rows.rows}))


def apart(measured, expected):
    """The largest difference of numbers; infinite where there is none to compare."""
    measured, expected = np.asarray(measured, float), np.asarray(expected, float)
    if measured.shape != expected.shape or not np.isfinite(measured).all():
        return np.inf
    return float(np.abs(measured - expected).max(initial=0.0))


def links_apart(measured, expected):
    """The largest difference of poses of the links that the reference has; a link that lacks is infinite."""
    if not set(expected) <= set(measured):
        return np.inf
    return max((apart(measured[name], pose) for name, pose in expected.items()), default=0.0)


def masses_apart(measured, expected):
    """The largest difference of masses, as a share of all; a link that lacks is infinite."""
    if not {name for name, mass in expected.items() if mass} <= set(measured):
        return np.inf
    total = sum(expected.values())
    return max(abs(float(measured.get(name, 0.0)) - mass) / total for name, mass in expected.items())


def scene(engine, read, reference, rows):
    """A scene that MuJoCo reads, in an engine that takes its models: `engine(model)` has `masses()`,
    `poses(qpos)` as places and rotations of bodies, and `motion(qpos, controls, steps)`."""
    model = rows.trying("scene", "loads", read)
    made = None if model is None else rows.trying("scene", "loads", lambda: engine(model))
    if made is None:
        return
    rows.measured("scene", "loads", 0, 0)
    names = [model.body(body).name for body in range(model.nbody)]
    expected = reference["mjcf"]
    masses = dict(zip(names, made.masses(), strict=True))
    rows.measured("scene", "masses", masses_apart(masses, expected["masses"]), MASSES)
    base = model.nq - len(expected["poses"][0]["qpos"])
    worst = rows.trying("scene", "kinematics", lambda: _poses_apart(made, names, base, expected["poses"]))
    if worst is not None:
        rows.measured("scene", "kinematics", worst, KINEMATICS)
    for start, wanted in reference["scene"].items():
        _moves(made, start, wanted, rows)


def _poses_apart(made, names, base, poses):
    worst = 0.0
    for pose in poses:
        places, turns = made.poses(np.array([0, 0, 0, 1, 0, 0, 0][:base] + pose["qpos"], float))
        worst = max(worst, links_apart(from_root(names, places, turns, 1), pose["links"]))
    return worst


def from_root(names, places, turns, root):
    """root_from_link (4, 4) by name, of places and rotations in the world; `root`: its place in the lists."""
    made = {}
    for name, place, turn in zip(names, places, turns, strict=True):
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = turns[root].T @ turn, turns[root].T @ (place - places[root])
        made[name] = pose
    return made


def _moves(made, start, wanted, rows):
    second = round(SECOND / wanted["timestep"])
    steps = second if start == "home" else len(wanted["hundred"]) - 1

    def run():
        return np.array(list(made.motion(np.array(wanted["start"]), np.array(wanted["controls"]), steps)))

    values = rows.trying("scene", f"{start}: 100 steps", run)
    if values is None:
        return
    hundred = len(wanted["hundred"]) - 1
    rows.measured("scene", f"{start}: 100 steps", apart(values[:hundred], wanted["hundred"][1:]), MOTION)
    if steps == second:
        rows.measured("scene", f"{start}: 1 s", apart(values[-1], wanted["end"]), MOTION)


def tree(read, kind, expected, rows, frames=True):
    """A file of a robot whose base is held, in an engine of its own: `read()` gives what has `masses()` by
    link, `poses(values)`, world_from_link by link at values by joint, and `motion(values, seconds, samples)`,
    a list of values by joint. `expected`: of the reference. `frames`: whether links without mass are links
    there too."""
    made = rows.trying(kind, "loads", read)
    if made is None:
        return
    rows.measured(kind, "loads", 0, 0)
    joints = expected["joints"]
    solid = {name: mass for name, mass in expected["masses"].items() if mass > FRAME or frames}
    masses = rows.trying(kind, "masses", lambda: masses_apart(made.masses(), solid))
    if masses is not None:
        rows.measured(kind, "masses", masses, MASSES)
    worst = rows.trying(
        kind, "kinematics", lambda: max(_apart_at(made, joints, solid, p) for p in expected["poses"])
    )
    if worst is not None:
        rows.measured(kind, "kinematics", worst, KINEMATICS)
    bare = expected["bare"]
    start, samples = dict(zip(joints, bare["start"], strict=True)), len(bare["qpos"])
    motion = rows.trying(kind, "motion", lambda: made.motion(start, bare["seconds"], samples))
    if motion is not None:
        clear = bare["clear"]
        measured = [[values.get(joint, np.nan) for joint in joints] for values in motion[:clear]]
        said = f"up to {bare['seconds'] * clear / samples:g} s, then chaos" if clear < samples else ""
        rows.measured(kind, "motion", apart(measured, bare["qpos"][:clear]), MOTION, said)


def _apart_at(made, joints, solid, pose):
    placed = made.poses(dict(zip(joints, pose["qpos"], strict=True)))
    root = next(iter(pose["links"]))
    if root not in placed:
        return np.inf
    every, names = np.array(list(placed.values())), list(placed)
    links = from_root(names, every[:, :3, 3], every[:, :3, :3], names.index(root))
    return links_apart(links, {name: pose for name, pose in pose["links"].items() if name in solid})
