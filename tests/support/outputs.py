"""Output folders, as builds leave them and as users fill them."""

import os
import stat
import subprocess
from pathlib import Path

from linkwright.pipeline.output import manifest

OURS = b'{"linkwright-report": 1}'
"""The report by which a folder is known as that of a build."""


def build(text, **more):
    """The files of a build, all with this text."""
    return {"report.json": OURS, "arm.xml": text, "assets/a.stl": text, **more}


def content(folder):
    """Every entry below the folder, but for manifests and locks: path → bytes, or what else it is."""
    entries = {}
    for top, below, files in os.walk(folder):
        below[:] = [name for name in below if name != ".linkwright"]
        for name in (*below, *files):
            path = Path(top, name)
            if name != manifest.NAME:
                entries[str(path.relative_to(folder))] = content_of(path)
    return {path: value for path, value in sorted(entries.items()) if value is not dir}


def content_of(path):
    mode = path.lstat().st_mode
    if stat.S_ISREG(mode):
        return path.read_bytes()
    if stat.S_ISLNK(mode):
        return str(path.readlink())
    if stat.S_ISDIR(mode):
        return dir if any(path.iterdir()) else "empty"
    return stat.S_IFMT(mode)


def shell(folder, script):
    """Runs a line of the shell in a folder, as a user does who puts something there."""
    subprocess.run(["sh", "-c", script], cwd=folder, check=True)
