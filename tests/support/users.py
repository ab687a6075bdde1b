"""Robots of a user's own, as files in a folder they work in."""

from pathlib import Path

URL = "https://cad.onshape.com/documents/5f1a0c2b9d8e7f6a5b4c3d2e/w/0a1b2c3d4e5f60718293a4b5/e/a1b2c3d4e5f60718293a4b5c"

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


def write(folder: Path, **robots: str) -> Path:
    """Puts robots into `folder/robot/`; the folder."""
    for name, text in robots.items():
        file = folder / "robot" / f"{name}.yaml"
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")
    return folder
