"""A Slurm of one computer, without systemd, munge or accounting, for as long as a test needs it."""

import os
import shutil
import socket
import subprocess
import time
from contextlib import contextmanager

from tests.support.places import MODELS

WANTED = ("slurmctld", "slurmd", "sbatch", "srun")


def missing():
    """Why no Slurm can be started here; nothing where one can."""
    absent = [name for name in WANTED if shutil.which(name) is None]
    if absent:
        return f"{', '.join(absent)} not found (apt-get install slurmctld slurmd slurm-client)"
    return "" if os.geteuid() == 0 else "slurmd needs root"


@contextmanager
def running(folder):
    """Inside, Slurm runs with its files in `folder`; the variables with which its commands find it."""
    for name in ("state", "spool"):
        (folder / name).mkdir(parents=True)
    settings = folder / "slurm.conf"
    settings.write_text(_settings(folder))
    variables = {"SLURM_CONF": str(settings)}
    environ = {**os.environ, **variables}
    with open(folder / "daemons.log", "w") as log:
        daemons = [
            subprocess.Popen([name, "-D"], env=environ, stdin=subprocess.DEVNULL, stdout=log, stderr=log)
            for name in ("slurmctld", "slurmd")
        ]
    try:
        _wait(["sinfo", "--noheader", "--format=%T"], "idle", environ)
        yield variables
    finally:
        subprocess.run(["scancel", "--user=root"], env=environ, capture_output=True, check=False)
        _wait(["squeue", "--noheader"], "", environ)
        for daemon in daemons:
            daemon.kill()
            daemon.wait()


def _settings(folder):
    host = socket.gethostname().partition(".")[0]
    with socket.socket() as first, socket.socket() as second:
        for listener in (first, second):
            listener.bind(("127.0.0.1", 0))
        ports = first.getsockname()[1], second.getsockname()[1]
    names = {"host": host, "folder": folder, "processors": os.cpu_count()}
    text = (MODELS / "slurm.conf").read_text()
    return text.format(**names, controller=ports[0], daemon=ports[1])


def _wait(command, answer, environ):
    """Until a command of Slurm answers so."""
    until = time.monotonic() + 60
    while time.monotonic() < until:
        done = subprocess.run(command, env=environ, capture_output=True, text=True, check=False)
        if done.returncode == 0 and done.stdout.strip() == answer:
            return
        time.sleep(0.2)
    msg = f"{command[0]} does not answer {answer!r}: {done.stdout}{done.stderr}"
    raise RuntimeError(msg)
