"""The colliders of the sample, made once for all tests: cutting them takes seconds.

They are kept as the cache keeps them, each under a key that holds all that it depends on, so a test that
changes a part or a setting makes its own.
"""

import json
import os
import shutil
import subprocess
import sys
import tempfile
from functools import cache
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path

from filelock import FileLock

from tests.support.places import PROJECT

KINDS = ("mesh/mesh.collider", "mesh/mesh.by_contact")
LIBRARIES = ("numpy", "scipy", "manifold3d", "coacd", "coal", "mujoco")


def seed(folder):
    """Makes `folder` a cache that knows the colliders of the sample."""
    for name, data in _records().items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)


@cache
def _records():
    """The records of colliders and their blobs, by path below the cache folder."""
    root = _built() / "cache"
    contents = {}
    for path in sorted((root / "ac").glob("*/*.json")):
        data = path.read_bytes()
        record = json.loads(data)
        if record["stage"] in KINDS:
            contents[str(path.relative_to(root))] = data
            for digest in record["outputs"].values():
                blob = root / "cas" / digest[:2] / digest
                contents[str(blob.relative_to(root))] = blob.read_bytes()
    assert contents
    return contents


def _built():
    """A folder where the sample was built with this source and these libraries, by this or another run."""
    here = Path(tempfile.gettempdir()) / f"linkwright-tests-{os.getuid()}" / _state()
    here.mkdir(parents=True, exist_ok=True)
    with FileLock(here / "lock"):
        if not (here / "done").exists():
            shutil.rmtree(here / "cache", ignore_errors=True)
            environ = {"PATH": os.environ["PATH"], "HOME": str(here), "LINKWRIGHT_CACHE": str(here / "cache")}
            command = [sys.executable, "-m", "linkwright", "until=mesh"]
            subprocess.run(command, cwd=here, env=environ, check=True, capture_output=True, timeout=900)
            (here / "done").touch()
    return here


def _state():
    """A digest of what colliders may depend on, beside what is in their keys."""
    every = sorted((PROJECT / "stages" / "mesh").rglob("*.py"))
    parts = [sha256(path.read_bytes()).hexdigest() for path in every]
    parts += [f"{name} {version(name)}" for name in LIBRARIES] + [sys.version]
    return sha256("\n".join(parts).encode()).hexdigest()[:20]
