"""The tab key in bash, zsh and fish, pressed in a terminal, after the script was installed and read."""

import os
import shutil
from pathlib import Path

import pytest

from tests.support.command import COMMAND, environment, linkwright
from tests.support.terminal import Terminal
from tests.support.users import MY_ARM, write

START = {
    "bash": ["bash", "-i"],
    "zsh": ["zsh", "-i"],
    "fish": ["fish", "-i"],
}


@pytest.fixture(params=list(START))
def shell(request, tmp_path: Path):
    """An interactive shell that has just started where `robot/my_arm.yaml` is, completion installed."""
    name = request.param
    if shutil.which(name) is None:
        pytest.skip(f"{name} is not installed")
    write(tmp_path, my_arm=MY_ARM)
    path = f"{COMMAND.parent}{os.pathsep}{os.environ['PATH']}"
    environ = environment(tmp_path, PATH=path, SHELL=f"/usr/bin/{name}", PS1="$ ")
    (tmp_path / ".zshrc").write_text("PROMPT='$ '\n")
    (tmp_path / ".bashrc").write_text("PS1='$ '\n")
    done = linkwright(tmp_path, "--install-completion", environ=environ)
    assert done.returncode == 0, done.stderr
    assert f"completion for {name}" in done.stdout
    with Terminal(START[name], tmp_path, environ) as terminal:
        terminal.type("echo rea''dy\n")
        terminal.until("ready\n")
        yield terminal


TYPED = [
    ("linkwright robot=my_", "linkwright robot=my_arm"),
    ("linkwright source=sample root.ba", "root.base="),
    ("linkwright robot=my_arm root=fr", "root=free"),
    ("linkwright joints.elbow.dam", "joints.elbow.damping="),
    ("linkwright robot=robot/my", "robot=robot/my_arm.yaml"),
    ("linkwright --install-c", "--install-completion"),
]


def test_the_tab_key_completes(shell: Terminal) -> None:
    for typed, becomes in TYPED:
        shell.type(f"{typed}\t")
        shell.until(becomes)
        shell.type("\x15")  # clears the line
