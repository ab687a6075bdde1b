"""The parity of files with the robot: what the check says, and the dynamics that it compares with."""

import re
from dataclasses import replace

import numpy as np
import pytest

from linkwright.stages.robot.dynamics.mass_matrix import mass_matrix
from linkwright.stages.robot.dynamics.statics import holding_forces
from linkwright.stages.robot.model.robot import Limits, frozen
from linkwright.stages.validate.dynamics.random_poses import POSES, poses_and_speeds
from linkwright.stages.validate.dynamics.tree_dynamics import dynamics
from tests.support.building import plan_of, write
from tests.support.checked import checked
from tests.support.robots import joint, pose, robot_with

PLACES = [pose(np.random.default_rng(seed)) for seed in range(3)]


def arm():
    """A turn, then a slide and a turn of one joint."""
    joints = [
        joint("revolute", "base", "arm", place=PLACES[0], limits={"arm_joint": Limits(-1, 1)}),
        joint("cylindrical", "arm", "hand", [0.0, 0.0], place=PLACES[1]),
    ]
    return robot_with(joints)


def checks_in(folder):
    robot = arm()
    checks = checked(folder, robot, plan_of())
    return [check for check in checks if check.code == "C-PARITY"]


def heavier(file, before, share):
    """Makes the number in a file that follows the first match of `before` larger by this share."""
    changed = re.sub(
        f'({before})([^"]+)',
        lambda m: f"{m[1]}{float(m[2]) * (1 + share)!r}",
        file.read_text(),
        count=1,
        flags=re.S,
    )
    file.write_text(changed)


def test_each_file_is_compared_in_each_engine(tmp_path):
    pytest.importorskip("pinocchio")
    write(arm(), tmp_path)
    checks = checks_in(tmp_path)
    assert [check.name for check in checks] == [
        "robot.xml: parity in MuJoCo",
        "robot.urdf: parity in MuJoCo",
        "robot.urdf: parity in Pinocchio",
    ]
    assert all(check.passed and check.value < 1e-10 for check in checks)


def test_links_between_dofs_of_a_urdf_joint_count_nowhere(tmp_path):
    """A robot of milligrams, whose forces are as small as those of the links of 1e-12 kg that lower it."""
    joints = [
        joint("cylindrical", f"link_{number}", f"link_{number + 1}", [0.0, 0.0], place=PLACES[number % 3])
        for number in range(12)
    ]
    heavy = robot_with(joints, root="link_0")
    light = {
        link.name: replace(
            link.inertial, mass=1e-6 * link.inertial.mass, inertia=frozen(1e-6 * link.inertial.inertia)
        )
        for link in heavy.links
    }
    robot = robot_with(joints, root="link_0", inertials=light)
    write(robot, tmp_path)
    checks = [check for check in checked(tmp_path, robot, plan_of()) if check.code == "C-PARITY"]
    assert len(checks) >= 2
    assert [check.detail for check in checks if not check.passed] == []


def test_without_pinocchio_the_check_says_so(tmp_path, monkeypatch):
    monkeypatch.setattr(
        "linkwright.stages.validate.checks.mechanism.parity.is_pinocchio_installed", lambda: False
    )
    write(arm(), tmp_path)
    mjcf, urdf = checks_in(tmp_path)
    assert "not installed" not in mjcf.detail
    assert "Pinocchio is not installed (pip install 'pin" in urdf.detail


def test_tensor_a_little_off_is_found_in_the_mass_matrix(tmp_path):
    write(arm(), tmp_path)
    file = tmp_path / "robot.xml"
    heavier(file, '<body name="hand".*?mass="', 1e-7)
    parity = checks_in(tmp_path)[0]
    assert not parity.passed
    assert {finding.attribute for finding in parity.findings} == {"inertial"}
    joints = {f'joint "{name}"' for name in ("arm_joint", "hand_joint_slide", "hand_joint_turn")}
    assert {finding.element for finding in parity.findings} <= joints


def test_samples_are_within_limits_and_the_same_every_time():
    values, speeds = poses_and_speeds(arm())
    again, _ = poses_and_speeds(arm())
    assert speeds.shape == (POSES, 3)
    assert np.abs(values["arm_joint"]).max() <= 1
    assert all((values[name] == again[name]).all() for name in values)


def test_dynamics_are_those_of_mass_matrix_and_statics():
    """The bias is that of Lagrange's equations: Ṁ q̇ − ∂T/∂q, by differences."""
    robot = arm()
    values, speeds = poses_and_speeds(robot)
    up = np.tile([0.0, 0.0, 9.81], (POSES, 1))
    moving = dynamics(robot, values, speeds, up)
    forces = holding_forces(robot, values, up[0])
    names = [dof.name for dof in robot.dofs]
    for at, name in enumerate(names):
        assert np.abs(forces[name][:, 0] - moving.gravity[:, at]).max() < 1e-9
    for index in (0, 7, 42):
        q = np.array([values[name][index] for name in names])

        def mass(q):
            return mass_matrix(robot, dict(zip(names, map(float, q), strict=True)))

        assert np.abs(mass(q) - moving.mass[index]).max() < 1e-9
        v, step = speeds[index], 1e-5
        rates = [(mass(q + step * unit) - mass(q - step * unit)) / (2 * step) for unit in np.eye(len(names))]
        change = sum(speed * rate for speed, rate in zip(v, rates, strict=True))
        expected = change @ v - 0.5 * np.array([v @ rate @ v for rate in rates])
        assert np.abs(expected - moving.bias[index]).max() < 1e-7
