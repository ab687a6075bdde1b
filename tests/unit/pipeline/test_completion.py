"""What the tab key offers."""

import shutil
import subprocess
from contextlib import chdir

import pytest

from linkwright.pipeline import completion, options
from linkwright.pipeline.cli import run
from linkwright.pipeline.completion import candidates, install, query, split
from tests.support.users import MY_ARM, write

SHELLS = ("bash", "zsh", "fish")
ROBOTS = ("bare", "delta", "hand", "legged", "legs/left", "my_arm", "quadruped", "rover", "sample")


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "experiment").mkdir()
    (tmp_path / "experiment" / "wide.yaml").touch()
    (tmp_path / "there").mkdir()
    (tmp_path / "motors").mkdir()
    (tmp_path / "motors" / "my_servo.yaml").touch()
    write(tmp_path / "there", other=MY_ARM)
    return write(tmp_path, my_arm=MY_ARM, **{"legs/left": MY_ARM})


@pytest.mark.parametrize(("line", "offered"), [
    ("cac", ["cache", "cache."]),
    ("robot=bare cac", ["cache."]),
    ("so", ["source.", "source="]),
    ("source.off", ["source.offline="]),
    ("source.tess", ["source.tessellation."]),
    ("source.tessellation.a", ["source.tessellation.angle="]),
    ("source.offline=", ["source.offline=false", "source.offline=true"]),
    ("joints.elbow.da", ["joints.elbow.damping="]),
    ("frames.add.tool.", ["frames.add.tool.link=", "frames.add.tool.rpy=", "frames.add.tool.xyz="]),
    ("+joints.elbow.da", ["+joints.elbow.damping="]),
    ("robot=m", ["robot=my_arm"]),
    (
        "robot=",
        [f"robot={name}" for name in ROBOTS],
    ),
    ("robot=robot/m", ["robot=robot/my_arm.yaml"]),
    ("--config-dir there robot=o", ["robot=other"]),
    ("--config-dir=there robot=o", ["robot=other"]),
    ("--config-dir th", ["there/"]),
    ("root=f", ["root=fixed", "root=free"]),
    ("-m root=auto,f", ["root=auto,fixed", "root=auto,free"]),
    ("experi", ["experiment="]),
    ("experiment=", ["experiment=wide"]),
    ("+experiment=w", ["+experiment=wide"]),
    ("~gro", ["~ground="]),
    ("validate.level=s", ["validate.level=standard", "validate.level=strict"]),
    ("source.path=the", ["source.path=there/"]),
    ("source.path=there/", ["source.path=there/robot/"]),
    ("source.path=nowhere/", []),
    ("hydra/l", ["hydra/launcher="]),
    ("-m hydra/launcher=w", ["hydra/launcher=workstation"]),
    ("--cf", ["--cfg"]),
    ("--cfg j", ["job"]),
    ("-c ", ["all", "hydra", "job"]),
    ("--info def", ["defaults", "defaults-tree"]),
    ("--install-completion z", ["zsh"]),
    ("--package ", []),
    ("explain W-LIM", ["W-LIMIT", "W-LIMIT-DOUBT", "W-LIMIT-LOCKED", "W-LIMIT-LOST"]),
    ("explain joints.<glob>.d", ["joints.<glob>.damping"]),
    ("actuators.elbow.motor=mx", ["actuators.elbow.motor=mx106", "actuators.elbow.motor=mx64"]),
    ("actuators.elbow.motor=my", ["actuators.elbow.motor=my_servo"]),
    ("actuators=m", ["actuators=motor"]),
    ("motors=", []),
    ("explain sts", ["sts3215"]),
    ("diff --m", ["--markdown"]),
    ("snapshot --c", ["--check", "--config-dir"]),
    ("snapshot rob", ["robot/"]),
    ("diff rob", ["robot/"]),
    ("nothing.like.it", []),
    ("nothing=", []),
])  # fmt: skip
def test_what_may_follow_a_line(here, line, offered):
    words = split(f"linkwright {line}")
    assert candidates(words[-1], words[1:-1], here) == offered


def test_a_first_word_may_be_a_verb_and_an_empty_one_anything(here):
    offered = candidates("", [], here)
    assert {"bundle", "cache", "explain", "robot=", "joints.", "until="} <= set(offered)
    assert "bundle" not in candidates("", ["robot=bare"], here)


@pytest.mark.parametrize(
    ("line", "words"),
    [("a", ["a"]), ("a ", ["a", ""]), ("a  b", ["a", "b"]), ("a 'b c' d", ["a", "'b c'", "d"]), ("", [""]),
     (r"a b\ c d", ["a", r"b\ c", "d"]), (r"a b\' c", ["a", r"b\'", "c"]), (r"a 'b\' c", ["a", r"'b\'", "c"]),
     (r"a b\\ c", ["a", r"b\\", "c"])],
)  # fmt: skip
def test_a_line_is_split_at_spaces_outside_quotes(line, words):
    assert split(line) == words


@pytest.mark.parametrize(("shell", "environ", "printed"), [
    ("bash", {"COMP_LINE": "linkwright root=fr"}, ["free "]),
    ("bash", {"COMP_LINE": "linkwright root=fr", "COMP_WORDBREAKS": " "}, ["root=free "]),
    ("bash", {"COMP_LINE": "linkwright -m root=fr"}, ["free"]),
    ("bash", {"COMP_LINE": "linkwright root=free", "COMP_POINT": "14"}, ["root."]),
    ("bash", {"COMP_LINE": "linkwright root.bas"}, ["root.base="]),
    ("zsh", {"COMP_LINE": "linkwright root=fr"}, ["root=free"]),
    ("fish", {"COMP_LINE": "linkwright root=fr"}, ["root=free"]),
    ("fish", {"COMP_LINE": "linkwright"}, []),
    ("fish", {}, []),
])  # fmt: skip
def test_each_shell_gets_what_it_puts_into_the_line(here, shell, environ, printed):
    offered = query(shell, environ)
    assert offered[: len(printed)] == printed
    assert bool(offered) == bool(printed)


HOSTILE = [
    "a$(touch x)", "a`b`", "a;b", "a\nb", "a\tb", "it's", 'a"b', "a\\", "a*", "a!b", "a~b", "a#b", "a\x1b[m",
    "a>b",
]  # fmt: skip


@pytest.mark.parametrize("shell", SHELLS)
def test_name_that_is_no_word_to_a_shell_is_not_offered(here, shell):
    write(here, **dict.fromkeys(HOSTILE, MY_ARM))
    for word in ("a", "robot/a", "it"):
        assert query(shell, {"COMP_LINE": f"linkwright robot={word}"}) == []
    for name in ("-rf", "--output=x", "=ls"):
        (here / "there" / name).touch()
    with chdir(here / "there"):
        offered = query(shell, {"COMP_LINE": "linkwright check "})
    assert not {"-rf", "--output=x", "=ls"} & {text.strip() for text in offered}, "where a word begins"


@pytest.mark.parametrize("shell", SHELLS)
def test_hydras_own_way_prints_a_script_that_the_shell_can_read(shell, capsys):
    for verb in ("install", "uninstall"):
        assert run(["-sc", f"{verb}={shell}"]) == 0
        script = capsys.readouterr().out
        assert "linkwright" in script
        if shutil.which(shell):
            subprocess.run([shell, "-n"], input=script, text=True, check=True)
    assert run(["--shell-completion", "install=cmd"]) == 2
    assert "there is no completion" in capsys.readouterr().err


@pytest.mark.parametrize(("shell", "script", "start"), [
    ("bash", ".local/share/linkwright/completion.bash", ".bashrc"),
    ("zsh", ".local/share/linkwright/completion.zsh", ".zshrc"),
    ("fish", ".config/fish/completions/linkwright.fish", None),
])  # fmt: skip
def test_installing_twice_is_installing_once(tmp_path, shell, script, start):
    if start:
        (tmp_path / start).write_text("mine")
    environ = {"HOME": str(tmp_path), "SHELL": f"/bin/{shell}"}
    assert [install("", environ), install(shell, environ)][0] == install("", environ)
    assert (tmp_path / script).is_file()
    if start:
        lines = (tmp_path / start).read_text().splitlines()
        assert lines[0] == "mine"
        assert len(lines) == 2


def test_name_of_the_home_folder_runs_nothing(tmp_path):
    home = tmp_path / "$(touch ran)`touch ran`"
    home.mkdir()
    install("bash", {"HOME": str(home)})
    environ = {"PATH": "/usr/bin:/bin", "HOME": str(home)}
    done = subprocess.run(
        ["bash", "--rcfile", str(home / ".bashrc"), "-ic", "complete -p linkwright"],
        cwd=tmp_path, capture_output=True, text=True, check=True, env=environ,
    )  # fmt: skip
    assert "_linkwright" in done.stdout
    assert not list(tmp_path.rglob("ran"))


def test_another_shell_is_reported_and_every_option_completed(capsys, monkeypatch):
    monkeypatch.setenv("SHELL", "/bin/tcsh")
    assert run(["--install-completion"]) == 2
    message = "error: there is no completion for tcsh\n  → linkwright --install"
    assert capsys.readouterr().err.startswith(message)
    not_typed = {"--run", "--shell-completion"}
    assert {*options._OPTIONS, *options.HELP} - not_typed == set(completion.OPTIONS)
