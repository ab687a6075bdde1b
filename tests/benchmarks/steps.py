"""`python -m tests.benchmarks.steps [--cache FOLDER] [ROBOT ...]`: steps per second with the colliders of the
ladder against those with the visual meshes themselves.

Each robot is built with both, from its visuals and with self-contact; the second gets the excludes of the
first. It is dropped from where it stands in its scene, in some seeded poses of its joints, settles, and then
both take turns of steps, so that a machine that slows down meanwhile slows both. Times are of the processor.
Prints contacts, geoms and the share of parts that ended on a primitive or a hull too; ends with exit status 1
where a goal is missed. `--cache` keeps the colliders for the next run: their first making takes minutes.
"""

import argparse
import json
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np

from tests.support.command import environment, linkwright
from tests.support.other_robots import ROBOTS, source_of

GOALS = {"duck": 1.5, "so101": 0.95, "reachy2": 0.95}
DROPS, SETTLED, STEPS, TURN = 5, 1000, 1500, 150
"""Poses, the first of them `home`; of each the steps before and in the measurement, and those of one turn."""


@dataclass
class Stepping:
    """A robot on the ground, the processor time [s] that its steps took, and its contacts in each turn."""

    model: mujoco.MjModel
    data: mujoco.MjData
    seconds: float = 0.0
    contacts: tuple[int, ...] = ()

    def drop(self, number: int) -> None:
        """Starts anew in a pose of its joints, and settles."""
        model, data = self.model, self.data
        mujoco.mj_resetData(model, data)
        if model.nkey:
            mujoco.mj_resetDataKeyframe(model, data, 0)
        random = np.random.default_rng(number)
        for joint in np.flatnonzero(model.jnt_limited):
            low, high = model.jnt_range[joint]
            at = model.jnt_qposadr[joint]
            data.qpos[at] += (random.uniform(low, high) - data.qpos[at]) * (0.3 if number else 0.0)
        mujoco.mj_step(model, data, SETTLED)

    def step(self, count: int) -> None:
        start = time.process_time()
        mujoco.mj_step(self.model, self.data, count)
        self.seconds += time.process_time() - start
        self.contacts += (self.data.ncon,)

    @property
    def colliders(self) -> int:
        return int(((self.model.geom_contype != 0) | (self.model.geom_conaffinity != 0)).sum())


def built(here: Path, cache: Path, name: str, mesh: str) -> Path:
    """The folder of a build."""
    told = [
        *source_of(name),
        f"mesh={mesh}",
        "mesh.basis=visual",
        "contact.self=auto",
        f"output={name}_{mesh}",
    ]
    done = linkwright(
        here, *source_of(name), *told, environ=environment(here, LINKWRIGHT_CACHE=str(cache)), timeout=3600
    )
    if done.returncode != 0:
        raise SystemExit(f"the build of {name} with mesh={mesh} failed:\n{done.stdout}{done.stderr}")
    return here / f"{name}_{mesh}"


def on_the_ground(folder: Path, excludes: Sequence[Sequence[str]]) -> Stepping:
    """The scene of a build with these excludes instead of its own."""
    spec = mujoco.MjSpec.from_file(str(folder / "scene.xml"))
    for one in list(spec.excludes):
        spec.delete(one)
    for first, second in excludes:
        spec.add_exclude(bodyname1=first, bodyname2=second)
    model = spec.compile()
    return Stepping(model, mujoco.MjData(model))


def compared(ladder: Path, raw: Path) -> tuple[Stepping, Stepping]:
    """Both after all their steps, taken in turns."""
    report = json.loads((ladder / "report.json").read_text())
    excludes = [one["links"] for one in report["details"].get("excludes", [])]
    both = on_the_ground(ladder, excludes), on_the_ground(raw, excludes)
    for number in range(DROPS):
        for one in both:
            one.drop(number)
        for _ in range(STEPS // TURN):
            for one in both:
                one.step(TURN)
    return both


def lines(here: Path, cache: Path, names: Sequence[str]) -> Iterator[tuple[str, bool]]:
    """A line for each robot, and whether its goal is met."""
    for name in names:
        folder = built(here, cache, name, "ladder")
        ours, theirs = compared(folder, built(here, cache, name, "raw"))
        ratio = theirs.seconds / ours.seconds
        goal = GOALS.get(name, 0.0)
        rates = [f"{DROPS * STEPS / one.seconds:9.0f}" for one in (ours, theirs)]
        counts = [f"{one.colliders:5d} {np.mean(one.contacts):8.1f}" for one in (ours, theirs)]
        plain = f"{plainly(folder):6.0%}"
        text = f"{name:8} {rates[0]} {rates[1]} {ratio:6.2f} {goal or '':>5} {counts[0]} {counts[1]} {plain}"
        yield text, ratio >= goal


def plainly(folder: Path) -> float:
    """The share of a robot's parts that collide as one primitive or hull, counted per use."""
    figures = json.loads((folder / "report.json").read_text())["details"]["colliders"]
    every = [one for one in figures if one["pieces"] for _ in one["parts"]]
    return sum(one["pieces"] == 1 for one in every) / max(1, len(every))


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    options.add_argument("--cache", type=Path)
    options.add_argument("robots", nargs="*", default=list(ROBOTS), metavar="ROBOT")
    given = options.parse_args()
    met = True
    with tempfile.TemporaryDirectory() as here:
        cache = (given.cache or Path(here) / "cache").resolve()
        print("           steps/s of     steps/s of               ladder:        raw:        parts as one")
        print("robot       ladder       raw  ratio  goal geoms contacts geoms contacts primitive or hull")
        for text, good in lines(Path(here), cache, given.robots):
            print(text if good else f"{text}  MISSED", flush=True)
            met &= good
    sys.exit(0 if met else 1)


if __name__ == "__main__":
    main()
