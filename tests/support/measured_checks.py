"""What the checks of a finished build take: `python -m tests.support.measured_checks FOLDER WARM` prints the
seconds of the processor, those of them in which MuJoCo compiles, and the memory [bytes] that it grows by,
after the imports that a build of `WARM` needs, and the names of the checks that fail."""

import json
import resource
import sys
import time
from pathlib import Path

from linkwright.stages.formats.described import read_robot_json
from linkwright.stages.validate import validate
from linkwright.stages.validate.engines import mujoco_engine
from linkwright.stages.validate.section import ValidateSections


def checks_of(folder, truth):
    return validate(folder, truth.written, ValidateSections.model_validate({}))


def truth_of(folder):
    return read_robot_json((folder / "robot.json").read_bytes())


def _memory():
    """The largest so far [bytes]. `ru_maxrss` begins with that of the process that started this."""
    status = Path("/proc/self/status")
    if not status.exists():
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    (line,) = (line for line in status.read_text().splitlines() if line.startswith("VmHWM:"))
    return int(line.split()[1]) * 1024


def _timed(load, spent):
    def timed(path):
        before = time.process_time()
        loaded = load(path)
        spent.append(time.process_time() - before)
        return loaded

    return timed


def main():
    folder, warm = map(Path, sys.argv[1:])
    checks_of(warm, truth_of(warm))
    truth = truth_of(folder)
    spent = []
    mujoco_engine.load = _timed(mujoco_engine.load, spent)
    seconds, memory = time.process_time(), _memory()
    checks = checks_of(folder, truth)
    figures = {"seconds": time.process_time() - seconds, "memory": _memory() - memory, "compiles": sum(spent)}
    print(json.dumps({**figures, "failed": [check.name for check in checks if check.fails]}))


if __name__ == "__main__":
    main()
