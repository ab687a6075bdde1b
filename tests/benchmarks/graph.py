"""`python -m tests.benchmarks.graph`: the graph stage and what follows it, and how they grow.

A machine of 1,000 parts and 200 joints in nested sub-assemblies, and one of ten times that; then the same
joints in a chain, on one part, geared, in loops.
"""

import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from linkwright.stages.export import export
from linkwright.stages.graph import build_robot
from linkwright.stages.robot.codec import decode_robot, encode_robot
from linkwright.stages.show.graph_view.views import views
from tests.benchmarks.large import PARTS, large
from tests.benchmarks.shapes import SHAPES
from tests.support.building import NO_MESHES, plan_of, write
from tests.support.checked import checked

MODULES = 34
GOALS = {"seconds": 2.0, "MiB": 500.0, "ratio": 12.0}
"""Goals of the graph stage at 1,000 parts; `ratio`: its time at ten times that, by its time at 1,000."""

MAKERS = {"modules": large, **SHAPES}


def measure(name, size):
    """Prints "<step> <seconds>" for each step, the best of three by processor time, and "peak <MiB>" of
    the process after the graph stage."""
    bundle, plan = MAKERS[name](size), plan_of()
    build_robot(MAKERS[name](2), plan)  # imports

    def timed(step, work):
        taken = []
        for _ in range(3):
            start = time.process_time()
            result = work()
            taken.append(time.process_time() - start)
        print(step, min(taken))
        return result

    robot = timed("graph", lambda: build_robot(bundle, plan))
    print("peak", peak())
    if name != "modules":
        return
    kept = timed("encode", lambda: encode_robot(robot))
    timed("decode", lambda: decode_robot(kept))
    timed("views", lambda: views(robot))
    timed("export", lambda: export(robot, NO_MESHES, plan))
    with tempfile.TemporaryDirectory() as folder:
        write(robot, Path(folder))
        timed("validate", lambda: checked(Path(folder), robot, plan))


def peak():
    """The most memory that this process has had [MiB]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def measured(name, size):
    """What `measure` prints, of a process of its own."""
    line = [sys.executable, "-m", __spec__.name, name, str(size)]
    output = subprocess.run(line, capture_output=True, text=True, check=True).stdout
    return {name: float(number) for name, number in map(str.split, output.splitlines())}


def main():
    small, big = measured("modules", MODULES), measured("modules", 10 * MODULES)
    print(f"{MODULES * PARTS:,} parts and ten times that   goals of graph: {GOALS}")
    for step in small:
        print(f"  {step:10} {small[step]:8.2f} {big[step]:8.2f}   × {big[step] / small[step]:.1f}")
    print("graph stage alone, [s]")
    for name in SHAPES:
        taken = [measured(name, size)["graph"] for size in (50, 200)]
        print(f"  {name:10} {taken[0]:8.2f} {taken[1]:8.2f}   × {taken[1] / taken[0]:.1f} of 4")


if __name__ == "__main__":
    if len(sys.argv) > 1:
        measure(sys.argv[1], int(sys.argv[2]))
    else:
        main()
