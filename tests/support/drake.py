"""Drake, in an environment of its own: it pins what we do not, and takes 400 MB.

`LINKWRIGHT_DRAKE_PYTHON` names the Python of an environment that has it; else one is made for the run of the
tests, and where that cannot be, tests are skipped.
"""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from filelock import FileLock

VERSION = "1.51.1"
"""That of `stages/targets/readers.py`."""

READER = Path(__file__).with_name("drake_reader.py")


def drake_python(shared):
    """The Python that has Drake. `shared`: a folder that all workers of the run share."""
    path = os.environ.get("LINKWRIGHT_DRAKE_PYTHON")
    if path:
        return path
    home = shared / "drake"
    python = home / "bin" / "python"
    with FileLock(shared / "drake.lock"):
        if not (home / "failed").exists() and not (home / "made").exists():
            made = _run([sys.executable, "-m", "venv", str(home)])
            if not made:
                made = _run([str(python), "-m", "pip", "install", "--quiet", f"drake=={VERSION}"])
            (home / ("failed" if made else "made")).write_text(made)
        failed = home / "failed"
        if failed.exists():
            pytest.skip(f"no environment with Drake {VERSION} can be made: {failed.read_text()}")
    return str(python)


def _run(command):
    """The last line of what went wrong; "" for nothing."""
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    return (done.stderr.strip().splitlines() or ["?"])[-1] if done.returncode else ""


def read(python, file, joints, values, weld):
    """What `drake_reader` answers."""
    done = _read(python, file, joints, values, weld)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def refusal(python, file):
    """Why Drake refuses a file; "" where it does not."""
    return _read(python, file, (), ({},), None).stderr


def _read(python, file, joints, values, weld):
    request = {
        "file": str(file),
        "weld": weld,
        "joints": list(joints),
        "values": [dict(value) for value in values],
    }
    command = [python, "-I", str(READER)]
    return subprocess.run(command, input=json.dumps(request), capture_output=True, text=True, check=False)
