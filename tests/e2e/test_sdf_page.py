"""The commands of the page on SDF do what it says."""

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from tests.support.building import plan_of, write
from tests.support.drake import drake_python
from tests.support.places import PROJECT
from tests.support.robots import at, joint, robot_with
from tests.support.validators import PACKAGES

PAGE = (PROJECT / "pipeline" / "reference" / "formats" / "SDF.md").read_text(encoding="utf-8")
BLOCKS = dict(re.findall(r"^<!-- (\w+) -->\n```\w+\n(.*?)^```$", PAGE, re.DOTALL | re.MULTILINE))


@pytest.fixture
def here(tmp_path: Path) -> Path:
    """A folder in which my_arm is built."""
    rows = [joint("revolute", "base", "arm"), joint("ball", "arm", "hand", place=at(0, 0, 0.2))]
    folder = tmp_path / "outputs" / "my_arm"
    folder.mkdir(parents=True)
    write(robot_with(rows, name="my_arm"), folder, plan_of(name="my_arm", export={"sdf": {}}))
    return tmp_path


def run(name: str, here: Path) -> str:
    """What the commands of a block print, of Gazebo as it is called here."""
    gazebo = next((tool for tool in ("gz", "ign") if shutil.which(tool)), None)
    if gazebo is None:
        pytest.skip(f"neither gz nor ign is installed (Debian: {PACKAGES['ign']})")
    command = re.sub(r"\bgz sdf\b", f"{gazebo} sdf", BLOCKS[name])
    done = subprocess.run(["bash", "-c", command], cwd=here, capture_output=True, text=True, check=False)
    assert "Error" not in done.stderr, done.stderr
    return done.stdout


def test_the_page_has_the_blocks_that_are_run() -> None:
    assert set(BLOCKS) == {"check", "poses", "drake"}


def test_the_check_says_valid(here: Path) -> None:
    assert "Valid." in run("check", here)


def test_the_graph_of_poses_has_every_link_and_joint(here: Path) -> None:
    run("poses", here)
    graph = (here / "poses.dot").read_text()
    assert "digraph" in graph
    for name in ("base", "arm", "hand", "arm_joint", "hand_joint"):
        assert name in graph


@pytest.mark.slow
def test_drake_loads_it(here: Path, tmp_path_factory: pytest.TempPathFactory) -> None:
    base = tmp_path_factory.getbasetemp()
    python = drake_python(base.parent if base.name.startswith("popen-") else base)
    code = BLOCKS["drake"] + "print(plant.num_positions())"
    done = subprocess.run([python, "-c", code], cwd=here, capture_output=True, text=True, check=False)
    assert done.stdout.strip() == "4", done.stderr
