"""`python -m tests.benchmarks.against CHECKOUT [TIMES]`: the command against that of another checkout.

`CHECKOUT/.venv` holds the other command. The two run in turn, so that whatever else the computer does slows
both; shown are the medians of each.
"""

import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from tests.support.command import COMMAND, environment

COMMANDS: Mapping[str, Sequence[str]] = {
    "linkwright --help": ["--help"],
    "a fully cached build": [],
    "a wrong key": ["mesh.colider=hull"],
}
TIMES = 15


@dataclass(frozen=True, slots=True)
class Taken:
    """What one run took [s]."""

    processor: float
    wall: float


def run(command, here, arguments):
    start = time.perf_counter()
    process = subprocess.Popen(
        [str(command), *arguments],
        cwd=here,
        env=environment(here),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    _, status, used = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    return Taken(used.ru_utime + used.ru_stime, time.perf_counter() - start)


def compared(commands, arguments, times):
    """The medians of each command; each has a folder and a cache of its own."""
    with tempfile.TemporaryDirectory() as above:
        folders = [Path(above) / str(number) for number in range(len(commands))]
        taken: list[list[Taken]] = [[] for _ in commands]
        for folder in folders:
            folder.mkdir()
        for turn in range(times + 1):
            for command, folder, measurements in zip(commands, folders, taken, strict=True):
                measured = run(command, folder, arguments)
                if turn:  # the first fills caches
                    measurements.append(measured)
    return [
        Taken(
            statistics.median(measured.processor for measured in measurements),
            statistics.median(measured.wall for measured in measurements),
        )
        for measurements in taken
    ]


def main(checkout, times=str(TIMES)):
    other = Path(checkout).resolve() / ".venv" / "bin" / "linkwright"
    if not other.is_file():
        raise SystemExit(f"there is no {other}")
    print(f"{'':22}{'processor [s]':>25}  {'wall [s]':>25}")
    print(f"{'':22}" + "  ".join(f" {'there':>8}{'here':>8}{'ratio':>8}" for _ in range(2)))
    for title, arguments in COMMANDS.items():
        there, here = compared([other, COMMAND], arguments, int(times))
        pairs = (there.processor, here.processor), (there.wall, here.wall)
        print(f"{title:22}" + "  ".join(f" {old:8.3f}{new:8.3f}{new / old:8.2f}" for old, new in pairs))


if __name__ == "__main__":
    main(*sys.argv[1:])
