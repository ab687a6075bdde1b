"""`python -m tests.benchmarks`: how long the command takes, against the bare interpreter."""

import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from tests.support.command import COMMAND, environment

GOALS = {"linkwright --help": 0.25, "a fully cached build": 1.5}


def seconds(run, times=5):
    """The median wall time of `run` [s]."""
    taken = []
    for _ in range(times):
        start = time.perf_counter()
        run()
        taken.append(time.perf_counter() - start)
    return statistics.median(taken)


def main():
    with tempfile.TemporaryDirectory() as folder:
        here = Path(folder)

        def command(*arguments):
            line = [str(COMMAND), *arguments]
            return lambda: subprocess.run(
                line, cwd=here, env=environment(here), capture_output=True, check=True
            )

        bare = seconds(lambda: subprocess.run([sys.executable, "-c", ""], check=True))
        times = {
            "the bare interpreter": bare,
            "linkwright --help": seconds(command("--help")),
            "a first build of the sample": seconds(command("cache.mode=bypass"), times=3),
        }
        command()()
        times["a fully cached build"] = seconds(command())
    print(f"{'what':30} {'seconds':>8} {'× bare':>7}  goal")
    for title, taken in times.items():
        goal = f"< {GOALS[title]} s" if title in GOALS else ""
        print(f"{title:30} {taken:8.3f} {taken / bare:7.1f}  {goal}")


if __name__ == "__main__":
    main()
