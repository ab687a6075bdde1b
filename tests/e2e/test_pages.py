"""The commands of the pages on URDF and MJCF do what they say."""

import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

from linkwright.stages.robot.model.robot import Limits, Relation
from tests.support.building import plan_of, write
from tests.support.places import PROJECT
from tests.support.robots import at, joint, robot_with
from tests.support.validators import PACKAGES

PAGES = PROJECT / "pipeline" / "reference" / "formats"


def blocks(page: str) -> dict[str, str]:
    """The marked blocks of a page, by their marks."""
    text = (PAGES / page).read_text(encoding="utf-8")
    return dict(re.findall(r"^<!-- (\w+) -->\n```\w+\n(.*?)^```$", text, re.DOTALL | re.MULTILINE))


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder in which my_arm is built: a hinge, and one that follows it."""
    rows = [
        joint("revolute", "base", "arm", name="shoulder", limits={"shoulder": Limits(-1.0, 2.0)}),
        joint("revolute", "arm", "hand", name="wrist", place=at(0, 0, 0.2), limits={"wrist": Limits(-4, 2)}),
    ]
    robot = robot_with(rows, relations=[Relation("belt", "wrist", "shoulder", -2.0, 0.0)], name="my_arm")
    folder = tmp_path / "outputs" / "my_arm"
    folder.mkdir(parents=True)
    write(robot, folder, plan_of(name="my_arm"))
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(code: str) -> dict[str, Any]:
    """What a block of Python leaves."""
    found: dict[str, Any] = {}
    exec(compile(code, "page", "exec"), found)
    return found


def test_every_format_has_a_page_that_the_readme_names() -> None:
    readme = (PROJECT / "README.md").read_text(encoding="utf-8")
    for page in PAGES.glob("*.md"):
        assert f"formats/{page.name}" in readme, page
    formats = {path.stem.upper() for path in (PROJECT / "conf" / "export").glob("*.yaml")}
    assert formats <= {page.stem for page in PAGES.glob("*.md")}


def test_links_between_the_pages_lead_somewhere() -> None:
    for page in PAGES.glob("*.md"):
        for target in re.findall(r"\]\((?!http)([^)]+)\)", page.read_text(encoding="utf-8")):
            path, _, anchor = target.partition("#")
            there = PAGES / path if path else page
            assert there.is_file(), (page, target)
            titles = (
                re.findall(r"^## (.*)$", there.read_text(encoding="utf-8"), re.MULTILINE) if anchor else []
            )
            anchors = [title.lower().replace(",", "").replace(" ", "-") for title in titles]
            assert not anchor or anchor in anchors, (page, target)


def test_check_urdf_finds_the_tree(here: Path) -> None:
    if not shutil.which("check_urdf"):
        pytest.skip(f"check_urdf is not installed (Debian: {PACKAGES['check_urdf']})")
    command = blocks("URDF.md")["check"]
    done = subprocess.run(["bash", "-c", command], cwd=here, capture_output=True, text=True, check=True)
    assert "root Link: base" in done.stdout


def test_pinocchio_has_the_follower_follow(here: Path) -> None:
    pytest.importorskip("pinocchio")
    model = run(blocks("URDF.md")["pinocchio"])["model"]
    assert model.nq == 1
    assert list(model.names)[1:] == ["shoulder", "wrist"]


def test_mujoco_reads_the_urdf(here: Path) -> None:
    model = run(blocks("URDF.md")["mujoco"])["model"]
    assert [model.joint(index).name for index in range(model.njnt)] == ["shoulder", "wrist"]


def test_a_second_is_simulated_from_home(here: Path) -> None:
    left = run(blocks("MJCF.md")["simulate"])
    data = left["data"]
    assert data.time >= 1.0
    assert np.isfinite(data.qpos).all()
    assert data.warning.number.sum() == 0


def test_two_robots_are_in_one_scene(here: Path) -> None:
    model = run(blocks("MJCF.md")["attach"])["model"]
    names = {model.joint(index).name for index in range(model.njnt)}
    assert names == {"shoulder", "wrist", "left_shoulder", "left_wrist"}
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    apart = data.body("left_arm").xpos - data.body("arm").xpos
    assert np.abs(apart[:2] - [0, 1]).max() < 1e-9
