"""The commands of the pages on URDF, MJCF and SDF do what they say."""

import re
import shutil
import subprocess

import mujoco
import numpy as np
import pytest

from linkwright.stages.robot.model.robot import Limits, Relation
from tests.support.building import plan_of, write
from tests.support.drake import drake_python
from tests.support.pages import FORMATS, blocks, page
from tests.support.places import PROJECT
from tests.support.robots import at, joint, robot_with
from tests.support.validators import PACKAGES


@pytest.fixture
def here(tmp_path, monkeypatch):
    """A folder in which my_arm is built: a hinge, and one that follows it."""
    rows = [
        joint("revolute", "base", "arm", name="shoulder", limits={"shoulder": Limits(-1.0, 2.0)}),
        joint("revolute", "arm", "hand", name="wrist", place=at(0, 0, 0.2), limits={"wrist": Limits(-4, 2)}),
    ]
    robot = robot_with(rows, relations=[Relation("belt", "wrist", "shoulder", -2.0, 0.0)], name="my_arm")
    folder = tmp_path / "outputs" / "my_arm"
    folder.mkdir(parents=True)
    formats = {"urdf": {}, "mjcf": {}, "sdf": {}}
    write(robot, folder, plan_of(name="my_arm", export=formats))
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(text):
    """The names that a block of Python leaves."""
    namespace = {}
    exec(compile(text, "page", "exec"), namespace)
    return namespace


def shell(here, text):
    """The output of a block's commands, of Gazebo as it is called here."""
    tool = text.split()[0]
    names = ("gz", "ign") if tool == "gz" else (tool,)
    program = next((name for name in names if shutil.which(name)), None)
    if program is None:
        pytest.skip(f"{names[-1]} is not installed (Debian: {PACKAGES[names[-1]]})")
    command = re.sub(r"\bgz sdf\b", f"{program} sdf", text)
    done = subprocess.run(["bash", "-c", command], cwd=here, capture_output=True, text=True, check=False)
    assert "Error" not in done.stderr, done.stderr
    return done.stdout


def test_every_format_has_a_page_that_the_guide_names():
    pages = [path.name for path in FORMATS.glob("*.md")]
    assert [name for name in pages if f"formats/{name}" not in page("docs/guide/files.md")] == []
    formats = {path.stem.upper() for path in (PROJECT / "conf" / "export").glob("*.yaml")}
    assert {f"{name}.md" for name in formats} <= set(pages)


def test_links_between_the_pages_lead_somewhere():
    for path in FORMATS.glob("*.md"):
        for target in re.findall(r"\]\((?!http)([^)]+)\)", page(path.name)):
            name, _, anchor = target.partition("#")
            there = FORMATS / name if name else path
            assert there.is_file(), (path, target)
            titles = re.findall(r"^#+ (.*)$", there.read_text(encoding="utf-8"), re.MULTILINE)
            anchors = [title.lower().replace(",", "").replace(" ", "-") for title in titles]
            assert not anchor or anchor in anchors, (path, target)


def test_check_urdf_finds_the_tree(here):
    assert "root Link: base" in shell(here, blocks("URDF.md")["check"])


def test_gazebo_calls_the_sdf_valid(here):
    assert "Valid." in shell(here, blocks("SDF.md")["check"])


def test_the_graph_of_poses_has_every_link_and_joint(here):
    shell(here, blocks("SDF.md")["poses"])
    graph = (here / "poses.dot").read_text()
    assert [
        word for word in ("digraph", "base", "arm", "hand", "shoulder", "wrist") if word not in graph
    ] == []


@pytest.mark.slow
def test_drake_loads_the_sdf(here, run_folder):
    text = blocks("SDF.md")["drake"] + "print(plant.num_positions())"
    done = subprocess.run([drake_python(run_folder), "-c", text], capture_output=True, text=True, check=False)
    assert done.stdout.strip() == "2", done.stderr


def test_pinocchio_has_the_follower_follow(here):
    pytest.importorskip("pinocchio")
    model = run(blocks("URDF.md")["pinocchio"])["model"]
    assert model.nq == 1
    assert list(model.names)[1:] == ["shoulder", "wrist"]


def test_mujoco_reads_the_urdf(here):
    model = run(blocks("URDF.md")["mujoco"])["model"]
    assert [model.joint(index).name for index in range(model.njnt)] == ["shoulder", "wrist"]


def test_a_second_is_simulated_from_home(here):
    left = run(blocks("MJCF.md")["simulate"])
    data = left["data"]
    assert data.time >= 1.0
    assert np.isfinite(data.qpos).all()
    assert data.warning.number.sum() == 0


def test_two_robots_are_in_one_scene(here):
    model = run(blocks("MJCF.md")["attach"])["model"]
    names = {model.joint(index).name for index in range(model.njnt)}
    assert names == {"shoulder", "wrist", "left_shoulder", "left_wrist"}
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    distance = data.body("left_arm").xpos - data.body("arm").xpos
    assert np.abs(distance[:2] - [0, 1]).max() < 1e-9
