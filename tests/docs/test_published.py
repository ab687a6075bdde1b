"""The commands of the documents that need a published package, with the wheel of this checkout instead."""

import os
import re
import subprocess
import sys

import pytest

from tests.docs.blocks import blocks, pages
from tests.support import kept_colliders
from tests.support.command import environment, run_in
from tests.support.places import copy_source

pytestmark = [pytest.mark.slow, pytest.mark.e2e]

COMMANDS = [
    line
    for page in pages()
    for block in blocks(page)
    if "published" in block.marks
    for line in block.text.splitlines()
    if line
]


def from_wheel(command, wheel):
    """The command with the wheel in place of the package's name."""
    tool = command.split()[0]
    if tool == "uvx":
        return command.replace("uvx linkwright", f"uvx --from {wheel} linkwright")
    if tool == "pipx":
        return command.replace("pipx run linkwright", f"pipx run --spec {wheel} linkwright")
    return re.sub(r"\blinkwright\b", f"{wheel}", command)


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """A folder with the wheel, and an environment with the installers."""
    folder = tmp_path_factory.mktemp("published")
    copy_source(folder / "source")
    pip = folder / "venv" / "bin" / "pip"
    steps = [
        [sys.executable, "-m", "venv", folder / "venv"],
        [pip, "install", "--quiet", "uv", "pipx"],
        [pip, "wheel", "--quiet", "--no-deps", "--wheel-dir", folder, folder / "source"],
    ]
    for step in steps:
        done = subprocess.run(list(map(str, step)), capture_output=True, text=True, check=False)
        if done.returncode:
            pytest.skip(f"pip cannot install uv and pipx here: {done.stderr[-300:]}")
    kept_colliders.seed(folder / "cache")
    return folder


@pytest.mark.parametrize("command", COMMANDS)
def test_a_command_works_once_the_package_is_published(command, place, tmp_path):
    (wheel,) = place.glob("*.whl")
    environ = environment(tmp_path, seeded=False, LINKWRIGHT_CACHE=str(place / "cache"))
    environ["PATH"] = f"{place / 'venv' / 'bin'}:{environ['PATH']}"
    environ |= {name: value for name, value in os.environ.items() if name.startswith(("PIP_", "UV_"))}
    environ |= {"UV_NATIVE_TLS": "1", "UV_SYSTEM_CERTS": "1"}  # the certificates of the system
    done = run_in(tmp_path, "bash", "-c", from_wheel(command, wheel), environ=environ, timeout=1200)
    if "Failed to fetch" in done.stderr:
        pytest.skip(f"uv cannot reach an index of packages: {done.stderr[-300:]}")
    assert done.returncode == 0, done.stdout + done.stderr
    if command.startswith(("uvx", "pipx run")):
        assert (tmp_path / "outputs" / "sample" / "report.html").is_file()
