"""The tools that other worlds check their files with, from Debian: without one, its tests are skipped."""

import shutil
import subprocess
from pathlib import Path

import pytest

PACKAGES = {
    "check_urdf": "liburdfdom-tools",
    "ign": "ignition-tools and libsdformat-dev",
    "colcon": "colcon, python3-colcon-ros, python3-colcon-cmake, python3-colcon-recursive-crawl, ament-cmake",
}
"""Tool → what has it in Debian 12."""


def check_urdf(path):
    """Says what is wrong with a URDF; "" for nothing."""
    done = _run("check_urdf", path.name, cwd=path.parent)
    accepted = done.returncode == 0 and "Successfully Parsed XML" in done.stdout
    return "" if accepted else done.stdout + done.stderr


def ign_sdf(path):
    """What sdformat says against an SDF, warnings too; "" for nothing.

    Its exit status says nothing, and its library may end with a backtrace after the verdict.
    """
    done = _run("ign", "sdf", "-k", path.name, cwd=path.parent)
    complaints = [line for line in done.stderr.splitlines() if "Error" in line or "Warning" in line]
    if "Valid." in done.stdout and not complaints:
        return ""
    return "\n".join(complaints) or done.stdout + done.stderr


def colcon_build(workspace):
    """Says what is wrong with the packages in a workspace's `src`; "" where all are built and installed.

    colcon reads each package.xml with catkin_pkg, and a package of ours with ament_cmake.
    """
    if not Path("/usr/share/ament_cmake").is_dir():
        pytest.skip(f"ament_cmake is not installed (Debian: {PACKAGES['colcon']})")
    # Its own interpreter, not that of the tests, has ament's modules.
    done = _run("colcon", "build", "--symlink-install", cwd=workspace, env={"PATH": "/usr/bin:/bin"})
    return "" if done.returncode == 0 and not done.stderr else done.stdout + done.stderr


def _run(tool, *arguments, cwd, env=None):
    if shutil.which(tool) is None:
        pytest.skip(f"{tool} is not installed (Debian: {PACKAGES[tool]})")
    return subprocess.run([tool, *arguments], cwd=cwd, env=env, capture_output=True, text=True, check=False)
