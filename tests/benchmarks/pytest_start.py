"""`python -m tests.benchmarks.pytest_start`: what the plug-in costs a run of pytest that does not ask for it.

The module is loaded, and pytest reads the list of files of each installed package with a plug-in, to rewrite
the assertions in them. That list is short where linkwright is installed from a checkout with `-e`.
"""

import statistics
import subprocess
import sys
import time
from importlib.metadata import distribution

RUNS, GOAL = 15, 10.0
"""Fresh interpreters, and what the module may take [ms]."""

LOAD = (
    "import time; start = time.process_time(); import linkwright.pytest_plugin; "
    "print(time.process_time() - start)"
)


def main():
    loads = [float(subprocess.check_output([sys.executable, "-c", LOAD])) for _ in range(RUNS)]
    lists, installed = [], distribution("linkwright")
    for _ in range(RUNS):
        start = time.process_time()
        files = [str(file) for file in installed.files or ()]
        lists.append(time.process_time() - start)
    print(f"loading the plug-in: {1e3 * statistics.median(loads):.2f} ms (goal: {GOAL:g})")
    print(f"reading the list of {len(files)} files: {1e3 * statistics.median(lists):.2f} ms")


if __name__ == "__main__":
    main()
