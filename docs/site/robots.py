"""Builds the robots of the gallery, and makes the page of the gallery.

They are built as a sweep, so that their pages share the file with the physics engine.
"""

import re
import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from docs.site.pages import PROJECT

CONF = PROJECT / "conf" / "robot"

HEAD = """\
# Gallery

Robots that are part of the package. Each builds offline. Click a picture to start the robot: this is its
page, simulated by MuJoCo in your browser. Nothing is sent anywhere.
"""

ROBOT = """
## {title}

{about}

[![{title}, built from its YAML](pictures/{name}.webp)](../conf/robot/{name}.yaml)

```sh
linkwright robot={name}
```

[The page of its build](robots/{name}/report.html)

```yaml
{yaml}```
"""


def gallery() -> list[str]:
    """The names of the robots in the package that build by themselves; the sample is the first."""
    files = [file for file in CONF.glob("*.yaml") if "override /source: sample" in _text(file.stem)]
    return sorted((file.stem for file in files), key=lambda name: (name != "sample", name))


def _text(name: str) -> str:
    return (CONF / f"{name}.yaml").read_text(encoding="utf-8")


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


def page(names: Sequence[str]) -> str:
    """The page of the gallery, with links as from `docs/`."""
    return HEAD + "".join(_robot(name) for name in names)


def _robot(name: str) -> str:
    text = _text(name)
    comments = re.match(r"# @package _global_\n((?:#.*\n)*)", text)
    about = " ".join(line.strip("# ") for line in comments[1].splitlines()) if comments else ""
    return ROBOT.format(title=name.capitalize(), about=about, name=name, yaml=text)
