"""The tab key in bash, zsh and fish, pressed in a terminal, after the script was installed and read."""

import os
import shutil
from collections.abc import Callable

import pytest

from tests.support.command import COMMAND, environment, linkwright
from tests.support.terminal import Terminal
from tests.support.users import MY_ARM, write

pytestmark = pytest.mark.slow

START = {"bash": ["bash", "-i"], "zsh": ["zsh", "-i"], "fish": ["fish", "-i"]}


STAND_IN = f"""\
#!/bin/sh
[ "$1" = -sc ] && exec {COMMAND} "$@"
printf '<%s>' "$@"
echo ' ended'
"""
"""The command: completes, and else shows its arguments."""


@pytest.fixture(params=list(START))
def shell(request, tmp_path):
    """An interactive shell that has just started where `robot/my_arm.yaml` is, completion installed."""
    name = request.param
    if shutil.which(name) is None:
        pytest.skip(f"{name} is not installed")
    write(tmp_path, my_arm=MY_ARM)
    command = tmp_path / "bin" / "linkwright"
    command.parent.mkdir()
    command.write_text(STAND_IN)
    command.chmod(0o755)
    path = f"{command.parent}{os.pathsep}{COMMAND.parent}{os.pathsep}{os.environ['PATH']}"
    environ = environment(tmp_path, PATH=path, SHELL=f"/usr/bin/{name}", PS1="$ ")
    (tmp_path / ".zshrc").write_text("PROMPT='$ '\n")
    (tmp_path / ".bashrc").write_text("PS1='$ '\n")
    done = linkwright(tmp_path, "--install-completion", environ=environ, status=0)
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


HOSTILE = (
    "$(touch ran)", "`touch ran`", "a;touch ran", "a;touch ran;", "a&touch ran&", "a|touch ran",
    "a&&touch ran",
    ">ran", "a>ran", "<(touch ran)", "$(touch${IFS}ran)", "a\ntouch ran\n", "a\n$(touch ran)", "a\rtouch ran",
    "a\ttouch ran", "it's", "'$(touch ran)'", 'a"b', '"$(touch ran)"', "'; touch ran; '", "\\", "a\\", "*",
    "?", "[a-z]*", "{a,b}", "~", "~root", "!!", "!ls", "#c", "^a", "a\x1b]0;title\x07", "(touch ran)", "a)",
    "$HOME", "%1", "\x01", "\u202e", "$'\\x24(touch ran)'",
)  # fmt: skip
"""Names of files that are more than a word to a shell."""

IN_FRONT = ("-rf", "--output=x", "=ls", "-")
"""Names that are something else where a word begins."""


def pressed(shell, line):
    """What a line runs after a press of the tab key, and the enter key."""
    shell.type(f"{line}\t\n")
    return shell.until(" ended\n")


def test_the_tab_key_completes(shell):
    for typed, becomes in TYPED:
        shell.type(f"{typed}\t")
        shell.until(becomes)
        shell.type("\x15")  # clears the line


def test_a_name_with_spaces_is_completed_as_a_word(shell, tmp_path):
    write(tmp_path, **{"our arm": MY_ARM})
    (tmp_path / "a folder" / "of robots").mkdir(parents=True)
    (tmp_path / "a folder" / "of robots" / "big arm.urdf").touch()
    assert "<robot=our arm> ended" in pressed(shell, "linkwright robot=our")
    assert "<robot=our arm> ended" in pressed(shell, "linkwright robot=our\\ a")
    shell.type("linkwright check a\t\t\t\n")
    assert "<check><a folder/of robots/big arm.urdf> ended" in shell.until(" ended\n")


PLACES: dict[str, Callable[[int, str], tuple[str, str]]] = {
    "option": lambda number, name: (f"robot/p{number}_{name}.yaml", f"linkwright robot=p{number}_"),
    "file": lambda number, name: (f"p{number}_{name}.urdf", f"linkwright check p{number}_"),
    "alone": lambda number, name: (f"d{number}/{name}", f"linkwright source.path=d{number}/"),
    "folder": lambda number, name: (f"f{number}_{name}/a.urdf", f"linkwright output=f{number}_"),
}
"""Kind of completion → the file with a name, and the line that the tab key completes with it."""


@pytest.mark.slow
@pytest.mark.parametrize("place", PLACES)
def test_a_hostile_name_runs_nothing(shell, tmp_path, place):
    for number, name in enumerate(HOSTILE):
        path, line = PLACES[place](number, name)
        file = tmp_path / path
        file.parent.mkdir(exist_ok=True)
        file.touch()
        # What is typed stays as it is, and nothing of the name is added.
        assert f"<{'><'.join(line.split()[1:])}> ended" in pressed(shell, line), name
    assert not [*tmp_path.rglob("ran")]


@pytest.mark.slow
def test_a_hostile_name_at_the_front_of_a_word_is_not_added(shell, tmp_path):
    for number, name in enumerate((*IN_FRONT, *HOSTILE)):
        folder = tmp_path / f"d{number}"
        folder.mkdir()
        (folder / name).touch()
        shell.type(f"cd {folder}\n")
        assert "<check> ended" in pressed(shell, "linkwright check "), name
    assert not [*tmp_path.rglob("ran")]


@pytest.mark.slow
def test_a_name_is_not_a_pattern_for_other_names(shell, tmp_path):
    """A candidate with a star must not become the name of a file that it matches."""
    for number, star in enumerate(("*", "?*", "[!q]*")):
        (tmp_path / "robot" / f"g{number}{star}.yaml").touch()
        (tmp_path / f"robot=g{number}$(touch ran)").touch()
        (tmp_path / f"g{number}$(touch ran)").touch()
        assert f"<robot=g{number}> ended" in pressed(shell, f"linkwright robot=g{number}")
    shell.type("linkwright 'joints.*.da\t\x15")
    (tmp_path / "joints.$(touch ran).damping=").touch()
    shell.type("linkwright joints.*.da\t")
    shell.until("joints.*.damping=")
    assert not [*tmp_path.rglob("ran")]
