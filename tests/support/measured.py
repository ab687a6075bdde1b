"""What a command takes of the processor and of memory, with all that it starts.

The kernel counts the memory of the process that starts a command as the command's own until the command's
program is loaded, and a worker of the tests may be large. So a small process starts the command, and reads
what its children took.
"""

import json
import resource
import subprocess
import sys
from dataclasses import dataclass


@dataclass(frozen=True)
class Done:
    status: int
    shown: str
    seconds: float
    """Processor time [s]."""
    memory: int
    """The largest of its processes [bytes]."""


def measured(command, here, environ, timeout):
    """Runs the command in the folder `here`; its output and its errors are one text. `timeout` [s] is by the
    clock."""
    ran = subprocess.run(
        [sys.executable, "-I", "-S", __file__, repr(timeout), *command],
        cwd=here,
        env=dict(environ),
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        check=False,
    )
    assert ran.returncode == 0, ran.stderr[-2000:]
    return Done(**json.loads(ran.stdout))


def _main(timeout, command):
    with subprocess.Popen(
        command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    ) as run:
        try:
            shown, _ = run.communicate(timeout=timeout)
        except subprocess.TimeoutExpired:
            run.kill()
            raise
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = Done(run.returncode, shown, used.ru_utime + used.ru_stime, used.ru_maxrss * 1024)
    json.dump(vars(done), sys.stdout)


if __name__ == "__main__":
    _main(float(sys.argv[1]), sys.argv[2:])
