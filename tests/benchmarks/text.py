"""`python -m tests.benchmarks.text [LINKS]`: how long the text of a chain of so many links takes.

Without meshes. A whole export does more: it looks for `home`, and it drives and places the robot.
"""

import statistics
import sys
import time
from collections.abc import Callable
from itertools import pairwise

import numpy as np

from linkwright.stages.export import export
from linkwright.stages.export.ground.standing import stand
from linkwright.stages.export.mjcf.form import form_of as mjcf_form_of
from linkwright.stages.export.urdf.form import form_of
from linkwright.stages.export.writer import WriterInput
from linkwright.stages.export.writers import WRITERS
from linkwright.stages.formats.written import Written
from linkwright.stages.robot.model.actuation import NONE
from linkwright.stages.robot.model.robot import Limits, Robot
from tests.support.building import NO_MESHES, plan_of
from tests.support.robots import joint, pose, robot_with

TEXTS = ("urdf", "mjcf")

LINKS, GOAL = 1000, 150.0
"""The chain, and what the text of a format may take [ms]."""


def chain(links: int) -> Robot:
    """Links on hinges, one on the other, each turned and with limits."""
    rng = np.random.default_rng(1)
    names = ["base", *(f"link_{number}" for number in range(1, links))]
    limits = {f"{name}_joint": Limits(-1.0, 1.5) for name in names}
    return robot_with(
        [joint("revolute", one, other, place=pose(rng), limits=limits) for one, other in pairwise(names)]
    )


def written(robot: Robot) -> dict[str, Callable[[], object]]:
    """The work of each format, and of the whole export."""
    plan = plan_of()
    forms = {"urdf_form": form_of(robot, plan, NONE), "mjcf_form": mjcf_form_of(robot, NO_MESHES, plan)}
    given = WriterInput(Written(robot, geometry=NO_MESHES, **forms), plan, stand(robot, NO_MESHES, plan))

    def text(name: str) -> Callable[[], object]:
        return lambda: WRITERS[name].write(given)

    return {name: text(name) for name in TEXTS} | {"whole export": lambda: export(robot, NO_MESHES, plan)}


def milliseconds(work: Callable[[], object], times: int = 7) -> float:
    """The median time of the processor, which other work on the machine does not lengthen much."""
    taken = []
    for _ in range(times):
        before = time.process_time()
        work()
        taken.append(1000 * (time.process_time() - before))
    return statistics.median(taken)


def main(links: int) -> None:
    found = {name: milliseconds(work) for name, work in written(chain(links)).items()}
    print(f"{links} links {'ms':>10}  goal")
    for name, taken in found.items():
        print(f"{name:14} {taken:7.0f}  {f'< {GOAL:.0f}' if name in TEXTS else ''}")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else LINKS)
