"""The check of sensors finds what is changed in a file."""

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from linkwright.stages.export import Exported
from linkwright.stages.robot.model.robot import Frame, Limits, Robot, frozen
from linkwright.stages.validate import validate
from tests.support.building import plan_of, write
from tests.support.robots import joint, pose, robot_with

pytestmark = pytest.mark.usefixtures("no_score")

PLACES = [pose(np.random.default_rng(seed)) for seed in range(4)]
SENSORS = {
    "imu": {"type": "imu", "frame": "hand", "xyz": [0.1, 0, 0]},
    "load": {"type": "force", "frame": "mount"},
    "tip": {"type": "frame", "frame": "eye", "relative_to": "hand"},
    "angle": {"type": "joint", "joints": "arm_joint", "measure": ["pos", "actuator_force"]},
    "view": {"type": "camera", "frame": "hand", "rpy": [0.3, 0, 0.2], "sees": ["mount"]},
    "pad": {"type": "touch", "frame": "hand", "size": [0.1, 0.2, 0.3]},
}
KEYS = {"sensors": SENSORS, "actuators": {"*": {"type": "motor", "encoder": True}}}


def chain(root: str = "base") -> Robot:
    """The root – turn – arm – fixed – hand – turn – eye, and a frame on the root."""
    joints = [
        joint("revolute", root, "arm", place=PLACES[0], limits={"arm_joint": Limits(-1, 1)}),
        joint("fixed", "arm", "hand", place=PLACES[1]),
        joint("revolute", "hand", "eye", place=PLACES[2]),
    ]
    return robot_with(joints, root=root, frames=[Frame("mount", root, frozen(PLACES[3]), "")])


def checked(robot: Robot, folder: Path, found: Exported) -> dict[str, bool]:
    checks = validate(folder, found.written, plan_of(**KEYS))
    return {check.name: check.passed for check in checks}


@pytest.mark.parametrize("root", ["base", "world"])
def test_what_was_written_passes(root: str, tmp_path: Path) -> None:
    robot = chain(root)
    placed = {"pose": {"xyz": [1, 2, 3], "rpy": [0.1, 0.2, 0.3]}}
    checks = checked(robot, tmp_path, write(robot, tmp_path, plan_of(**KEYS, scene=placed)))
    assert checks["robot.xml: sensors"]
    assert checks["robot.xml: places of sensors"]
    assert all(checks.values())


def swap(old: str, new: str) -> Callable[[str], str]:
    return lambda text: re.sub(old, new, text, count=1)


FAULTS = {
    "a sensor lost": (swap(r'<gyro name="imu_gyro"[^>]*/>', ""), "sensors"),
    "another type": (swap('<gyro name="imu_gyro"', '<velocimeter name="imu_gyro"'), "sensors"),
    "on another site": (swap('site="imu"', 'site="mount"'), "sensors"),
    "on another joint": (swap('angle_pos" joint="arm_joint"', 'angle_pos" joint="eye_joint"'), "sensors"),
    "relative to something else": (swap('refname="hand"', 'refname="mount"'), "sensors"),
    "relative to the world": (swap('reftype="site" refname="hand"', ""), "sensors"),
    "not relative to the world": (swap('"imu_quat"', '"imu_quat" reftype="site" refname="mount"'), "sensors"),
    "a site moved": (swap(r'(<site name="imu" pos=")[^ ]+', r"\g<1>9"), "places of sensors"),
    "a camera turned": (swap(r'(<camera name="view".* quat=")[^"]+', r"\g<1>1 0 0 0"), "places of sensors"),
    "a camera's angle": (swap(r'(<camera name="view".* fovy=")[^"]+', r"\g<1>9"), "sensors"),
    "a camera's pixels": (swap(r'(<camera name="view".* resolution=")[^"]+', r"\g<1>9 9"), "sensors"),
    "another order": (swap(r"(<gyro name=[^>]*/>)\s*(<[^>]*/>)", r"\g<2>\g<1>"), "sensors"),
    "a site on another link": (
        lambda text: re.sub(
            r'(<body name="base".*?)(<body )', r'\g<1><site name="pad"/>\g<2>',
            re.sub(r'<site name="pad"[^>]*/>', "", text), count=1, flags=re.DOTALL,
        ),
        "places of sensors",
    ),
}  # fmt: skip


@pytest.mark.parametrize("fault", FAULTS)
def test_a_planted_fault_fails_the_check(fault: str, tmp_path: Path) -> None:
    robot = chain()
    found = write(robot, tmp_path, plan_of(**KEYS))
    change, name = FAULTS[fault]
    before = (tmp_path / "robot.xml").read_text()
    after = change(before)
    assert after != before
    (tmp_path / "robot.xml").write_text(after)
    checks = checked(robot, tmp_path, found)
    assert not checks[f"robot.xml: {name}"]
