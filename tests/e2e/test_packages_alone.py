"""A build of packages only is as good as its files say: no check of it raises an alarm."""

import shutil
from pathlib import Path

import pytest
import yaml

from linkwright.pipeline.checking.run import checked
from tests.support.command import called

pytestmark = pytest.mark.slow

ELEMENTS = {
    "mark": {"into": {"tag": "body", "name": "wrist"}, "xml": "<site name='mark' pos='0 0 0.1'/>"},
    "lamp": {
        "into": {"tag": "link", "name": "wrist"},
        "xml": "<visual><geometry><sphere radius='0.01'/></geometry></visual>",
    },
    "flag": {
        "into": {"tag": "robot", "name": "sample"},
        "xml": "<link name='flag'/>"
        "<joint name='pole' type='fixed'><parent link='wrist'/><child link='flag'/></joint>",
    },
}


@pytest.mark.parametrize("formats", ["ros2", "python", "[python,sdf,ros2]"])
def test_a_build_of_packages_raises_no_alarm(formats: str, tmp_path: Path) -> None:
    robot = {"defaults": ["/robot/sample", "_self_"], "mesh": {"collider": "hull"}, "elements": ELEMENTS}
    (tmp_path / "robot").mkdir()
    (tmp_path / "robot/own.yaml").write_text("# @package _global_\n" + yaml.safe_dump(robot, sort_keys=False))
    done = called(tmp_path, "robot=own", f"export={formats}", "output=out")
    assert done.returncode == 0, done.stdout + done.stderr
    assert [check for check in checked(str(tmp_path / "out"), "standard").checks if not check.passed] == []


def test_a_build_of_an_older_version_is_no_fault(tmp_path: Path) -> None:
    """Its robot.json says nothing of what wrote the package."""
    done = called(tmp_path, "robot=sample", "mesh=hull", "export=[urdf,ros2]", "output=out")
    assert done.returncode == 0, done.stdout + done.stderr
    file = tmp_path / "out/robot.json"
    text = file.read_text()
    (line,) = (line for line in text.splitlines() if '"writer"' in line)
    file.write_text(text.replace(line + "\n", ""))
    shutil.rmtree(tmp_path / "out/ros2/sample_description/launch")
    checks = checked(str(tmp_path / "out"), "standard").checks
    assert [check for check in checks if check.fails and check.code == "C-ROS2"] == []
