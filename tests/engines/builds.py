"""The robots that engines are given, each built as a user builds it, with its reference beside its files."""

import json
import os
import subprocess
import sys
from collections.abc import Callable, Mapping
from pathlib import Path

from tests.engines.humanoid import humanoid
from tests.engines.quadruped import write_quadruped
from tests.engines.reference import reference
from tests.support import other_robots

COMMON = ("export=[mjcf,urdf,sdf,usd]", "page.preview=none", "validate=quick")

_DAMPED = "joints={'*':{damping: 0.02}}"
"""Without any damping the fall of a robot is chaos within half a second."""

TOLD: Mapping[str, tuple[str, ...]] = {
    "sample": (),
    "quadruped": ("robot=boxes",),
    "humanoid": ("source=urdf", "source.path=humanoid.urdf", "robot=legged", "actuators=position"),
    "so101": ("actuators=position", "root=fixed", "mesh.collider=hull", _DAMPED),
    "duck": ("robot=legged", "mesh.collider=hull", _DAMPED),
}
"""Overrides of a robot, besides those of where it comes from."""


def is_here(robot):
    return other_robots.is_here(robot)


def built(robot, keys, builds):
    """The folder of the robot, built with these overrides where it is not there; its `reference.json` is
    what MuJoCo makes of it."""
    above = builds / "-".join([robot, *(key.replace("=", "_") for key in keys)])
    folder = above / "out"
    if not (folder / "reference.json").exists():
        above.mkdir(parents=True, exist_ok=True)
        source = other_robots.source_of(robot) if robot in other_robots.FILES else []
        _WRITERS.get(robot, lambda _: None)(above)
        command = [sys.executable, "-m", "linkwright", *source, *TOLD[robot], *COMMON, *keys]
        done = subprocess.run(
            [*command, f"name={robot}", "output=out"],
            cwd=above,
            env=dict(os.environ),
            capture_output=True,
            text=True,
            check=False,
        )
        # A target may refuse something of a robot (3): its files are there, and rows say what it reads.
        if done.returncode not in (0, 3):
            raise SystemExit(f"{robot} could not be built:\n{done.stdout}{done.stderr}")
        (folder / "reference.json").write_text(json.dumps(reference(folder)))
    return folder


_WRITERS: Mapping[str, Callable[[Path], object]] = {
    "quadruped": write_quadruped,
    "humanoid": lambda folder: (folder / "humanoid.urdf").write_text(humanoid()),
}
"""What a robot is built from, where that is made first."""
