"""`python -m tests.benchmarks.growth [ROBOT ...]`: what each stage of a whole build takes at two sizes.

Of each robot and size a process of its own builds it cold, with the page and the checks, and the table shows
of each stage the processor time, the largest memory so far, both per part, and the exponent of the time
between the sizes. `--level` is that of the checks, `--sizes` replaces the sizes. The exit status is 1 where a
stage grows faster than it should.
"""

import argparse
import json
import math
import sys
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

from linkwright.pipeline.config.compose import compose_plan
from linkwright.pipeline.run.build import build_files
from linkwright.pipeline.terminal.progress import Quiet
from linkwright.stages.fetch.bundle.archive import pack
from tests.benchmarks.graph import peak
from tests.benchmarks.large import PARTS, large
from tests.benchmarks.many_parts import many_parts
from tests.fake_onshape.bundle import bundle_bytes
from tests.support.command import environment, run_in
from tests.support.places import PROJECT

GOAL = 1.1
"""The largest exponent of a stage's time."""

LEAST = 0.2
"""A stage that takes less at the larger size [s] is not judged."""


def modules(parts):
    """Like sub-assemblies on hinges, with loops and relations, as a bundle."""
    bundle = large(max(2, round(parts / PARTS)))
    old = next(iter(set(bundle.requests.values()) - set(bundle.blobs)), None)
    named = {request: bundle.definition if name == old else name for request, name in bundle.requests.items()}
    kept = {name: bundle.blobs[name] for name in {*named.values(), bundle.definition}}
    return "bundle", pack(replace(bundle, requests=named, blobs=kept))


def discs(parts):
    """Parts that all differ, four to a link, as a bundle."""
    return "bundle", bundle_bytes(many_parts(parts, links=parts // 4))


def urdf(links):
    """A tree of hinged boxes, eight on each, side by side."""
    said = ['<robot name="tree">']
    shape = '<geometry><box size="0.02 0.02 0.08"/></geometry>'
    inertia = '<inertia ixx="1e-4" iyy="1e-4" izz="5e-5" ixy="0" ixz="0" iyz="0"/>'
    inertial = f'<inertial><mass value="0.1"/>{inertia}</inertial>'
    wide = math.ceil(math.sqrt(links))
    for number in range(links):
        body = f"{inertial}<visual>{shape}</visual><collision>{shape}</collision>"
        said.append(f'<link name="link_{number}">{body}</link>')
    for number in range(1, links):
        above = (number - 1) // 8
        x, y = number % wide - above % wide, number // wide - above // wide
        said.append(
            f'<joint name="joint_{number}" type="revolute"><parent link="link_{above}"/>'
            f'<child link="link_{number}"/><origin xyz="{x / 10} {y / 10} 0"/><axis xyz="0 0 1"/>'
            '<limit lower="-0.1" upper="0.1" effort="5" velocity="3"/></joint>'
        )
    return "urdf", "\n".join([*said, "</robot>"]).encode()


Maker = Callable[[int], tuple[str, bytes]]
"""From a number of parts to a kind of source and its file."""

ROBOTS: Mapping[str, tuple[Maker, tuple[int, int], Sequence[str]]] = {
    # The modules stand in each other.
    "modules": (modules, (1_020, 5_010), ("contact.self=none",)),
    "discs": (discs, (200, 1_000), ()),
    "urdf": (urdf, (4_000, 20_000), ()),
}
"""By name the maker, two sizes, and overrides."""


class Clock(Quiet):
    """The processor time [s] at the beginning of each stage, and the largest memory [MiB] until then."""

    def __init__(self):
        self._began: list[tuple[str, float, float]] = []
        self.start("compose")

    def start(self, stage):
        self._began.append((stage, time.process_time(), peak()))

    def table(self):
        """Yields each step, its processor time [s], and the largest memory at its end [MiB]."""
        self.start("")
        for (step, begun, _), (_, ended, most) in pairwise(self._began):
            yield step, ended - begun, most


def measure(kind, path, more):
    """Builds the robot in `path`, and prints a line of JSON for each step."""
    clock = Clock()
    robot = [f"source={kind}", f"source.path={path}", "name=robot", "root=fixed", "mesh=hull"]
    build_files(compose_plan([*robot, *more]).plan, clock)
    for row in clock.table():
        print(json.dumps(row))


def measured(name, size, more):
    """What `measure` prints, of a process of its own."""
    maker, _, own = ROBOTS[name]
    kind, content = maker(size)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / {"bundle": "robot.zip", "urdf": "robot.urdf"}[kind]
        path.write_bytes(content)
        line = [sys.executable, "-m", __spec__.name, "--measure", kind, str(path), *own, *more]
        environ = environment(Path(folder), seeded=False, PYTHONPATH=str(PROJECT))
        done = run_in(Path(folder), *line, environ=environ, timeout=3600)
    if done.returncode:
        sys.exit(f"{name} of {size} parts:\n{done.stderr[-4000:]}")
    return {step: (busy, most) for step, busy, most in map(json.loads, done.stdout.splitlines())}


def report(name, sizes, more):
    """Prints the table of a robot; whether all grows as it should."""
    small, big = (measured(name, size, more) for size in sizes)
    print(f"{name}, {sizes[0]:,} and {sizes[1]:,} parts")
    print(f"  {'':10}{'seconds':>16}{'ms a part':>18}{'MiB':>14}{'KiB a part':>18}  exponent")
    good = True
    for step, (large_s, high) in big.items():
        small_s, low = small[step]
        exponent = math.log(max(large_s, 1e-3) / max(small_s, 1e-3)) / math.log(sizes[1] / sizes[0])
        steep = large_s >= LEAST and exponent > GOAL
        good &= not steep
        print(
            f"  {step:10}{small_s:8.2f}{large_s:8.2f}"
            f"{1e3 * small_s / sizes[0]:10.2f}{1e3 * large_s / sizes[1]:8.2f}"
            f"{low:7.0f}{high:7.0f}{1024 * low / sizes[0]:11.0f}{1024 * high / sizes[1]:7.0f}"
            f"  {exponent:5.2f}{'  too steep' if steep else ''}",
            flush=True,
        )
    return good


def main():
    if sys.argv[1:2] == ["--measure"]:
        measure(sys.argv[2], sys.argv[3], sys.argv[4:])
        return 0
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("robots", nargs="*", choices=[[], *ROBOTS], default=[])
    parser.add_argument("--sizes", type=int, nargs=2)
    parser.add_argument("--level", default="standard")
    asked = parser.parse_args()
    more = [f"validate.level={asked.level}"]
    names = asked.robots or list(ROBOTS)
    within_goals = [report(name, asked.sizes or ROBOTS[name][1], more) for name in names]
    return 0 if all(within_goals) else 1


if __name__ == "__main__":
    sys.exit(main())
