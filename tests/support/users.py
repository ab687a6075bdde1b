"""Robots of a user's own, as files in a folder they work in."""

import pytest

URL = "https://cad.onshape.com/documents/5f1a0c2b9d8e7f6a5b4c3d2e/w/0a1b2c3d4e5f60718293a4b5/e/a1b2c3d4e5f60718293a4b5c"

GLOBAL = "# @package _global_\n"
SAMPLE = f"{GLOBAL}defaults:\n  - override /source: sample\n"

MY_ARM = f"""\
# @package _global_
defaults:
  - override /source: onshape
  - override /export: [mjcf]
source:
  url: "{URL}"
root: {{base: fixed}}
joints:
  "*": {{damping: 1}}
  elbow: {{limits: [-1, 1]}}
export: {{urdf: {{meshes: relative}}}}
"""


def write(folder, **robots):
    """Puts robots into `folder/robot/`; the folder."""
    return put(folder, {f"robot/{name}.yaml": text for name, text in robots.items()})


def put(folder, files):
    """Writes files, path below the folder → text; the folder."""
    for path, text in files.items():
        file = folder / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")
    return folder


def composed(folder, *arguments, dirs=(), **more):
    """The composed plan of a command line that is typed in a folder."""
    # Late: most users of this module compose nothing.
    from linkwright.pipeline.config.compose import compose_plan

    return compose_plan(arguments, dirs, folder, **more)


def refused(folder, *arguments, dirs=(), **more):
    """The message with which such a command line is refused."""
    from linkwright.stages.robot.errors import ConfigError

    with pytest.raises(ConfigError) as caught:
        composed(folder, *arguments, dirs=dirs, **more)
    return str(caught.value)
