"""The check of sensors finds what is changed in a file."""

import numpy as np
import pytest

from linkwright.stages.robot.model.robot import Frame, Limits, frozen
from linkwright.stages.validate import validate
from tests.support.building import plan_of, write
from tests.support.faults.checks import SENSING
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


def chain(root="base"):
    """The root – turn – arm – fixed – hand – turn – eye, and a frame on the root."""
    joints = [
        joint("revolute", root, "arm", place=PLACES[0], limits={"arm_joint": Limits(-1, 1)}),
        joint("fixed", "arm", "hand", place=PLACES[1]),
        joint("revolute", "hand", "eye", place=PLACES[2]),
    ]
    return robot_with(joints, root=root, frames=[Frame("mount", root, frozen(PLACES[3]), "")])


def checked(robot, folder, outcome):
    checks = validate(folder, outcome.written, plan_of(**KEYS))
    return {check.name: check.passed for check in checks}


@pytest.mark.parametrize("root", ["base", "world"])
def test_what_was_written_passes(root, tmp_path):
    robot = chain(root)
    placed = {"pose": {"xyz": [1, 2, 3], "rpy": [0.1, 0.2, 0.3]}}
    checks = checked(robot, tmp_path, write(robot, tmp_path, plan_of(**KEYS, scene=placed)))
    assert checks["robot.xml: sensors"]
    assert checks["robot.xml: places of sensors"]
    assert all(checks.values())


@pytest.mark.parametrize("fault", SENSING, ids=lambda fault: fault.kind)
def test_planted_fault_fails_the_check(fault, tmp_path):
    robot = chain()
    outcome = write(robot, tmp_path, plan_of(**KEYS))
    fault.change(tmp_path, "robot")
    assert not checked(robot, tmp_path, outcome)[f"robot.xml: {fault.expects}"]
