"""`python -m tests.benchmarks.contacts [--cache FOLDER] [ROBOT ...]`: do the colliders touch where the robot
touches, how long does their making take, and how light are they to simulate?

Each robot is built in the default configuration, from nothing, others' robots from their visuals. Prints a
table of the goals, and ends with exit status 1 where one of them is missed. Times are of the processor, but
for the clock's; ratios are of one run. `--cache`: colliders that were made before count, and times do not.
"""

import argparse
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import mujoco

from linkwright.stages.formats.described import read_robot_json
from linkwright.stages.validate.checks.contact.false_contact import CHOSEN_REASONS
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.contact_errors import contact_errors
from linkwright.stages.validate.model.shapes import seen_and_solid
from tests.benchmarks.arm import write_arm
from tests.benchmarks.dropped import DROPS, STEPS, forward, models, stepped
from tests.benchmarks.walker import write_walker
from tests.support.command import COMMAND, environment
from tests.support.measured import measured
from tests.support.other_robots import FILES, ROBOTS, is_here, source_of

POSES, SALT = 1000, "poses of the benchmark"

NAMED, MOST = 0.01, 0.05
"""A pair is bad that is false or missed in a larger share of the poses; none may be in a larger one than
`MOST`."""

SHOWN = 5
"""The number of pairs that are named."""

HARD = ("duck", "reachy2")
"""Robots that may have three bad pairs."""


@dataclass(frozen=True)
class Figure:
    """What was found, and what it must be: at most, or at least, so much; None where there is no goal."""

    quantity: str
    found: float
    goal: float | None = None
    least: bool = False
    note: str = ""

    @property
    def met(self):
        return self.goal is None or (self.found >= self.goal if self.least else self.found <= self.goal)

    def __str__(self):
        goal = "" if self.goal is None else f"{'≥' if self.least else '≤'} {self.goal:g}"
        missed = "" if self.met else "MISSED"
        return f"{self.quantity:44} {self.found:9.4g} {goal:>8} {missed:6} {self.note}".rstrip()


CLOCK = {"sample": 9.0, "walker": 10.0}
SECONDS = {"so101": 12.0, "walker": 15.0, "duck": 45.0, "reachy2": 45.0}
FORWARD = {"sample": 0.9, "reachy2": 0.9, "walker": 1.8}
STEPPED = {"walker": 1.35}


def built(here, cache, name, *more):
    """The folder of a build, and its seconds by the clock."""
    source = source_of(name)
    choices = ["mesh.basis=visual", "contact.self=auto"] if name in FILES else []
    folder = here / "_".join((name, *(option.rpartition("=")[2] for option in more)))
    command = [str(COMMAND), *source, *choices, *more, f"output={folder.name}"]
    start = time.perf_counter()
    done = measured(command, here, environment(here, seeded=False, LINKWRIGHT_CACHE=str(cache)), 3600)
    clock = time.perf_counter() - start
    if done.status not in (0, 3):
        raise SystemExit(f"the build of {name} failed:\n{done.shown}")
    return folder, clock, done


def compiled_model(folder):
    """The MJCF of a build, as a check gets it."""
    truth = read_robot_json((folder / "robot.json").read_bytes())
    path = folder / f"{truth.written.robot.name}.xml"
    return CompiledModel(path, mujoco.MjModel.from_xml_path(str(path)), truth.written)


def counts(model):
    """Colliders; those of ends, on which no body hangs; and how many a link has of the others."""
    solid = {body: len(pair[1]) for body, pair in seen_and_solid(model).items() if pair[1]}
    ends = solid.keys() - set(model.body_parentid.tolist())
    solids = [number for body, number in solid.items() if body not in ends]
    every, of_ends = sum(solid.values()), sum(solid[body] for body in ends)
    return every, of_ends, sum(solids) / max(1, len(solids))


def figures(here, cache, name, *, cold):
    """The measurements of a robot."""
    if cold:
        _, clock, done = built(here, cache / "hull", name, "mesh=hull")
        note = f"{done.seconds:.1f} s of the processor"
        yield Figure("mesh=hull, cold, s by the clock", clock, 3.0, note=note)
    folder, clock, done = built(here, cache, name)
    if cold:
        yield Figure("default, cold, s by the clock", clock, CLOCK.get(name))
        yield Figure("default, cold, s of the processor", done.seconds, SECONDS.get(name))
    robot = compiled_model(folder)
    every, ends, each = counts(robot.model)
    yield Figure("colliders", every, note=f"{ends} of them of links on which none hangs")
    yield Figure("colliders a link, without those", each, 4.0)
    errors = contact_errors(robot, POSES, SALT)
    pairs = [pair for pair in errors.pairs if pair.reason not in CHOSEN_REASONS]
    shares = {pair: max(pair.false_count, pair.missed_count) / max(1, errors.pose_count) for pair in pairs}
    bad = sorted((pair for pair in pairs if shares[pair] > NAMED), key=lambda pair: -shares[pair])
    note = "; ".join(f"{_names(robot.model, pair)} {shares[pair]:.1%}" for pair in bad[:SHOWN])
    most = 3 if name in HARD else 0
    yield Figure(f"pairs false or missed in > 1 % of {errors.pose_count}", len(bad), most, note=note)
    worst = 100.0 * max(shares.values(), default=0.0)
    yield Figure("the worst pair, % of poses", worst, 100.0 * (MOST if name in HARD else NAMED))
    yield Figure("false contacts a pose", sum(pair.false_count for pair in pairs) / max(1, errors.pose_count))
    home = [_names(robot.model, pair) for pair in pairs if pair.home_depth]
    yield Figure("pairs that touch at home and stand apart", len(home), 0, note="; ".join(home[:SHOWN]))
    variants = models(folder)
    took = forward(variants)
    note = ", ".join(f"{variant} {1e6 * seconds:.0f} µs" for variant, seconds in took.items())
    goal = FORWARD.get(name, 1.0)
    yield Figure("mj_forward, times the raw visuals' speed", took["raw"] / took["made"], goal, True, note)
    yield Figure("mj_forward, times one hull a link's", took["hulls"] / took["made"], 0.8, True)
    rates = {variant: DROPS * STEPS / each.seconds for variant, each in stepped(variants).items()}
    note = ", ".join(f"{variant} {rate:.0f}" for variant, rate in rates.items())
    goal = STEPPED.get(name, 0.85)
    yield Figure("steps/s dropped, times the raw visuals'", rates["made"] / rates["raw"], goal, True, note)


def _names(model, pair):
    return " and ".join(model.body(body).name for body in pair.bodies)


def main():
    every = [*filter(is_here, ROBOTS), "walker", "arm"]
    options = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    options.add_argument("--cache", type=Path)
    options.add_argument("robots", nargs="*", default=every, metavar="ROBOT")
    parsed = options.parse_args()
    met = True
    with tempfile.TemporaryDirectory() as folder:
        here = Path(folder)
        write_walker(here)
        write_arm(here)
        print(f"{'robot':10} {'what':44} {'found':>9} {'goal':>8}")
        for name in parsed.robots:
            cache = parsed.cache.resolve() if parsed.cache else here / "caches" / name
            for figure in figures(here, cache, name, cold=parsed.cache is None):
                print(f"{name:10} {figure}", flush=True)
                met &= figure.met
    sys.exit(0 if met else 1)


if __name__ == "__main__":
    main()
