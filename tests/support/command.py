"""The installed `linkwright`, run as a user runs it."""

import os
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

COMMAND = Path(sys.executable).with_name("linkwright")
RUN_FACTS = {".linkwright.json", "report.json", "report.html", "build.log", "config.yaml"}


def environment(here: Path, **more: str) -> dict[str, str]:
    """A clean environment: no keys, a cache of its own below `here`, no terminal."""
    kept = {key: os.environ[key] for key in ("PATH", "LANG", "TMPDIR") if key in os.environ}
    return {**kept, "HOME": str(here), "LINKWRIGHT_CACHE": str(here / "cache"), **more}


def linkwright(
    here: Path, *arguments: str, environ: Mapping[str, str] | None = None, timeout: float = 120
) -> subprocess.CompletedProcess[str]:
    """Runs the command in the folder `here`."""
    return subprocess.run(
        [str(COMMAND), *arguments],
        cwd=here,
        env=dict(environ or environment(here)),
        capture_output=True,
        text=True,
        timeout=timeout,
        check=False,
    )


def robot_files(folder: Path) -> dict[str, bytes]:
    """Every file that must be the same between runs, by relative path."""
    found = {str(p.relative_to(folder)): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}
    return {name: data for name, data in found.items() if name not in RUN_FACTS}


def tree(here: Path) -> set[str]:
    """Everything that a run left in `here` beside its cache, its locks and its manifests."""
    return {
        str(path.relative_to(here))
        for path in here.rglob("*")
        if path.relative_to(here).parts[0] != "cache"
        and path.suffix != ".lock"
        and not path.name.startswith(".linkwright")
    }
