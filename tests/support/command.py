"""The installed `linkwright`, run as a user runs it, and the same without the start of a process."""

import json
import os
import subprocess
import sys
from contextlib import chdir, contextmanager, redirect_stderr, redirect_stdout
from pathlib import Path
from subprocess import CompletedProcess
from tempfile import TemporaryFile
from unittest.mock import patch

from linkwright.pipeline import cli
from tests.support import kept_colliders

COMMAND = Path(sys.executable).with_name("linkwright")
RUN_FACTS = {".linkwright.json", "report.json", "report.html", "build.log", "config.yaml", "preview.png"}


def environment(here, *, seeded=True, **more):
    """A clean environment: no keys, no terminal, a cache of its own below `here`.

    The cache knows nothing but, where it is `seeded`, the colliders of the sample.
    """
    if seeded and not (here / "cache").exists():
        kept_colliders.seed(here / "cache")
    kept = {
        key: os.environ[key] for key in ("PATH", "LANG", "TMPDIR", "LINKWRIGHT_PAGE") if key in os.environ
    }
    return {**kept, "HOME": str(here), "LINKWRIGHT_CACHE": str(here / "cache"), **more}


def run_in(here, *command, environ=None, timeout=600):
    """Runs a program in the folder `here`, in the clean environment unless another is passed."""
    words, env = [str(word) for word in command], dict(environ or environment(here))
    return subprocess.run(
        words, cwd=here, env=env, capture_output=True, text=True, timeout=timeout, check=False
    )


def linkwright(here, *arguments, environ=None, status=None, timeout=600):
    """Runs the command in the folder `here`; it must end with `status` if that is passed."""
    return _ended(run_in(here, COMMAND, *arguments, environ=environ, timeout=timeout), status)


def called(here, *arguments, environ=None, status=None):
    """As `linkwright`, but in this process, whose imports are done: for the many cases of what few tests
    show of the command itself."""
    with TemporaryFile("w+", encoding="utf-8") as out, TemporaryFile("w+", encoding="utf-8") as err:
        with chdir(here), patch.dict(os.environ, environ or environment(here), clear=True), _into(out, err):
            returned = cli.run(arguments)
        out.seek(0)
        err.seek(0)
        return _ended(CompletedProcess(arguments, returned, out.read(), err.read()), status)


def _ended(done, status):
    assert status in (None, done.returncode), f"{done.returncode}\n{done.stdout}{done.stderr}"
    return done


@contextmanager
def _into(out, err):
    """Inside, all that is printed goes to these files, also by libraries and child processes."""
    theirs = {1: os.dup(1), 2: os.dup(2)}
    for number, file in {1: out, 2: err}.items():
        os.dup2(file.fileno(), number)
    try:
        with redirect_stdout(out), redirect_stderr(err):
            yield
    finally:
        for number, copy in theirs.items():
            os.dup2(copy, number)
            os.close(copy)


def report_of(folder):
    """The report of a build, from its folder."""
    return json.loads((folder / "report.json").read_bytes())


def robot_files(folder):
    """Every file that must be the same between runs, by relative path."""
    contents = {str(p.relative_to(folder)): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}
    return {name: data for name, data in contents.items() if name not in RUN_FACTS}


def tree(here):
    """Everything that a run left in `here` beside its cache, its locks and its manifests."""
    return {
        str(path.relative_to(here))
        for path in here.rglob("*")
        if path.relative_to(here).parts[0] != "cache"
        and path.suffix != ".lock"
        and not path.name.startswith(".linkwright")
    }
