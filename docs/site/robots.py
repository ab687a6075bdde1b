"""Builds the robots of the gallery.

They are built as a sweep, so that their pages share the file with the physics engine.
"""

import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from docs.site.pages import PROJECT


def gallery() -> list[str]:
    """The names of the robots in the package that build by themselves; the sample is the first."""
    files = PROJECT.glob("conf/robot/*.yaml")
    names = [file.stem for file in files if "override /source: sample" in file.read_text(encoding="utf-8")]
    return sorted(names, key=lambda name: (name != "sample", name))


def build(names: Sequence[str], work: Path, to: Path) -> None:
    """Builds robots below the folder `work`; the files of each go to a folder of its name in `to`, beside the
    engine that their pages share. Exits with what the command printed if it fails."""
    work.mkdir(parents=True)
    command = [sys.executable, "-m", "linkwright", "-m", f"robot={','.join(names)}", "page.live=shared"]
    command += ["hydra.sweep.dir=robots", "hydra.sweep.subdir=${hydra.job.num}", "-q"]
    done = subprocess.run(command, cwd=work, capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(done.stdout + done.stderr)
    for number, name in enumerate(names):
        shutil.copytree(work / "robots" / str(number), to / name, ignore=shutil.ignore_patterns(".*"))
    shutil.copy(work / "robots" / "linkwright-engine.js", to)
