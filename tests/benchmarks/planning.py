"""`python -m tests.benchmarks.planning`: CPU time of a plan: the first, later ones, those of a sweep."""

import statistics
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from linkwright.pipeline.config.compose import compose_plan, session
from linkwright.pipeline.config.hydra.node import JobIdentity
from tests.support.users import MY_ARM, write

TIMES = 20
GOAL = 0.03
"""CPU seconds of a job of a sweep."""


def seconds(plan):
    """CPU time of the first plan, and the median of later ones [s]."""
    taken = []
    for number in range(TIMES + 1):
        start = time.process_time()
        plan(number)
        taken.append(time.process_time() - start)
    return taken[0], statistics.median(taken[1:])


def main():
    with tempfile.TemporaryDirectory() as folder:
        here = write(Path(folder), my_arm=MY_ARM, other=MY_ARM)
        plans: dict[str, Callable[[int], object]] = {
            "the sample": lambda _: compose_plan(["robot=sample"]),
            "a URDF": lambda _: compose_plan(["source=urdf", "source.path=arm.urdf", "mesh=hull"]),
            "a robot's file": lambda _: compose_plan(["robot=my_arm"], cwd=here),
        }
        print(f"{'plan':30} {'first, s':>9} {'later, s':>9}")
        for title, plan in plans.items():
            print(f"{title:30} {{:9.4f}} {{:9.4f}}".format(*seconds(plan)))
        with session(cwd=here) as composer:
            jobs: dict[str, Callable[[int], object]] = {
                "a job, other values": lambda number: composer.compose(
                    ["robot=my_arm", f"++mesh.tolerance=0.{number + 1}"], job=JobIdentity(number, f"{number}")
                ),
                "a job, other options": lambda number: composer.compose(
                    [f"robot={('my_arm', 'other')[number % 2]}", f"mesh={('hull', 'raw')[number // 2 % 2]}"],
                    job=JobIdentity(number, f"{number}"),
                ),
            }
            for title, job in jobs.items():
                print(f"{title:30} {{:9.4f}} {{:9.4f}}  goal < {GOAL} s".format(*seconds(job)))


if __name__ == "__main__":
    main()
