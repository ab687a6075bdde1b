"""A working folder full of traps: the command runs none of them, and opens only what it must."""

import ast
import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from linkwright.stages.validate.external import TOOLS
from tests.support.command import environment, run_in
from tests.support.places import PROJECT

pytestmark = pytest.mark.slow

AUDITED = """
import os, sys
log = open({log!r}, "a", encoding="utf-8")
here = os.path.realpath(os.getcwd()) + os.sep

def seen(event, words):
    if event == "open" and isinstance(words[0], (str, bytes, os.PathLike)):
        path = os.path.abspath(os.fsdecode(words[0]))
        if path.startswith(here):
            log.write("open\\t" + path[len(here):] + "\\n")
    elif event in ("subprocess.Popen", "os.exec", "os.posix_spawn", "os.system", "ctypes.dlopen"):
        log.write(event + "\\t" + os.fsdecode(words[0] or "") + "\\n")

sys.addaudithook(seen)
import linkwright.__main__ as command
sys.argv[0] = "linkwright"
status = command.main()
log.close()
sys.exit(status)
"""
"""Runs the command, and logs which files of the working folder Python opens and which programs it starts."""

URDF = """<robot name="arm">
  <link name="base">
    <inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
    <visual><geometry><mesh filename="parts/block.stl"/></geometry></visual>
    <collision><geometry><mesh filename="parts/block.stl"/></geometry></collision></link>
  <link name="hand">
    <inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
    <visual><origin xyz="0 0 3"/><geometry><box size="1 1 1"/></geometry></visual>
    <collision><origin xyz="0 0 3"/><geometry><box size="1 1 1"/></geometry></collision></link>
  <joint name="wrist" type="revolute"><parent link="base"/><child link="hand"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="5" velocity="2"/></joint>
</robot>
"""
ROBOT = """# @package _global_
defaults: [override /source: urdf, override /mesh: hull, override /export: [urdf, mjcf, sdf]]
name: arm
source: {path: arm.urdf}
"""
NO_SIMCHECK = TOOLS["simcheck"].command(os.environ) is None
CHECKS = "validate: {checks: [{_target_: trap_plugin.x}]}\n"
DOTENV = """ONSHAPE_ACCESS_KEY=from-dotenv
ONSHAPE_SECRET_KEY=from-dotenv-too
LINKWRIGHT_TRUST=robot/evil.yaml
LINKWRIGHT_CACHE=stolen
PYTHONPATH=.
PATH=.
LD_PRELOAD=./trap.so
"""
OTHERS = ("python", "python3", "pip", "xacro", "mjpython", "git", "ps", "sh", "ldconfig", "gcc", "uname")


def programs_of_the_product():
    """The names of programs in the product: of checkers, and what `program` and `subprocess` are given."""
    yield from (tool.program for tool in TOOLS.values())
    for folder in ("pipeline", "stages"):
        for file in (PROJECT / folder).rglob("*.py"):
            for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
                if isinstance(node, ast.Call) and re.search("(program|run|Popen)$", ast.unparse(node.func)):
                    words = node.args[:1]
                    if words and isinstance(words[0], ast.List):
                        words = words[0].elts[:1]
                    yield from (word.value for word in words if isinstance(word, ast.Constant))


@pytest.fixture(scope="module")
def marks(tmp_path_factory):
    return tmp_path_factory.mktemp("ran")


@pytest.fixture(scope="module")
def folder(tmp_path_factory, marks):
    """A robot between traps; each leaves a file in `marks` if it runs."""
    here = tmp_path_factory.mktemp("robot")
    corner = "vertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0"
    last = "vertex 1 0 0\nvertex 0 1 0\nvertex 0 0 1"
    corners = [corner, corner.replace("0 1 0", "0 0 1"), corner.replace("1 0 0", "0 0 1"), last]
    facets = "".join(f"facet normal 0 0 0\nouter loop\n{text}\nendloop\nendfacet\n" for text in corners)
    trap = "import os\nopen(os.path.join({!r}, {!r}), 'w').close()\n"
    files = {
        "arm.urdf": URDF,
        "parts/block.stl": f"solid block\n{facets}endsolid block\n",
        "robot/arm.yaml": ROBOT,
        "robot/evil.yaml": f"{ROBOT}plugins: [trap_plugin]\n{CHECKS}",
        ".env": DOTENV,
        "conf/build.yaml": "name: evil\n",
        "conf/robot/sample.yaml": "# @package _global_\nname: evil\n",
        "hydra.yaml": "hydra: {run: {dir: evil}}\n",
        "pyproject.toml": "[tool.linkwright]\nplugins = ['trap_plugin']\n",
        ".config/git/config": f"[core]\nfsmonitor = touch {marks / 'home-git'}\n",
        "setup.cfg": "[options]\n",
        "mujoco_plugin/libtrap.so": "no library",
    }
    modules = ("trap_plugin", "sitecustomize", "usercustomize", "pinocchio", "pxr", "hydra_plugins", "numpy")
    for name in modules:
        files[f"{name}.py"] = trap.format(str(marks), name)
    for name in ("conf", "pipeline", "stages"):
        files[f"{name}/__init__.py"] = trap.format(str(marks), name)
    for path, text in files.items():
        (here / path).parent.mkdir(parents=True, exist_ok=True)
        (here / path).write_text(text)
    for name in {*programs_of_the_product(), *OTHERS}:
        for place in (here, here / "bin"):
            place.mkdir(exist_ok=True)
            (place / name).write_text(f"#!/bin/sh\ntouch {marks / 'program'}-{name}\n")
            (place / name).chmod(0o755)
    return here


def audited(folder, log, *words):
    """The command's result, and what it opened and started."""
    script = log.with_suffix(".py")
    script.write_text(AUDITED.format(log=str(log)))
    log.unlink(missing_ok=True)
    environ = environment(log.parent)
    environ["PATH"] = os.pathsep.join(["", ".", "bin", environ["PATH"]])
    done = run_in(folder, sys.executable, script, *words, environ=environ)
    return done, [line.split("\t") for line in log.read_text(encoding="utf-8").splitlines()]


def opened(folder, log):
    """The files of the working folder that were opened, without those of builds."""
    files = {words[1] for words in log if words[0] == "open" and (folder / words[1]).is_file()}
    return {path for path in files if not path.startswith(("outputs", ".linkwright"))}


def test_every_verb_runs_no_trap_and_opens_what_the_robot_names(folder, marks, tmp_path):
    log, own = tmp_path / "log", {"robot/arm.yaml", "arm.urdf", "parts/block.stl", ".env"}
    done, seen = audited(folder, log, "robot=arm")
    assert done.returncode == 0, done.stdout + done.stderr
    assert opened(folder, seen) <= own
    assert {"robot/arm.yaml", "arm.urdf"} <= opened(folder, seen)
    assert not (folder / "stolen").exists()
    git = ["git", "-c", "user.name=a", "-c", "user.email=a@b.c"]
    for words in (["init", "-q"], ["add", "-f", "outputs"], ["commit", "-q", "-m", "one"]):
        subprocess.run([*git, *words], cwd=folder, check=True)
    for key in ("core.fsmonitor", "core.pager", "core.sshCommand", "diff.external"):
        subprocess.run(["git", "config", key, f"touch {marks / key}"], cwd=folder, check=True)
    for words, status, files in (
        (["robot=arm"], 0, own),
        (["check", "outputs/arm"], 0, set()),
        (["check", "arm.urdf"], 3, {"arm.urdf", "parts/block.stl"}),
        (["diff", "HEAD:outputs/arm", "outputs/arm"], 0, set()),
        (["view", "arm"], 1, set()),
        (["explain", "E-MASS"], 0, set()),
        (["bundle", "arm", str(tmp_path / "arm.zip")], 0, own),
        (["cache", "info"], 0, set()),
        (["-sc", "query=bash"], 0, own),
        (["-m", "robot=arm", "root=auto,free", "until=graph"], 0, own),
        (["robot=arm", "validate.external=[simcheck]"], 2 if NO_SIMCHECK else 0, own),
        (["robot=evil"], 2, {*own, "robot/evil.yaml"}),
    ):
        done, seen = audited(folder, log, *words)
        assert "Traceback" not in done.stderr, done.stderr
        assert done.returncode == status or words[0] in ("view", "check", "-sc"), (words, done)
        assert opened(folder, seen) <= {*files, ".env"}, words
        started = {Path(name[1]) for name in seen if name[0] != "open" and name[1]}
        ours = [path for path in started if path.is_relative_to(folder) or str(path).startswith(".")]
        assert ours == [], words
    assert sorted(path.name for path in marks.iterdir()) == []


def test_of_dotenv_only_our_keys_count(folder, tmp_path):
    done, _ = audited(folder, tmp_path / "log", "robot=evil")
    assert "E-TRUST plugins" in done.stderr
    done, _ = audited(folder, tmp_path / "log", "cache", "info", "--json")
    assert "stolen" not in done.stdout + json.dumps(sorted(map(str, folder.iterdir())))
