"""Numbers of a URDF that stand for no limit are no limits, unless the configuration gives them."""

import mujoco
import pytest
from lxml import etree

from linkwright.stages.graph.passes.limits.placeholders import without_placeholders
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.robot import Dof, Dynamics, Limits, Robot
from linkwright.stages.validate.simulate.noise import run_with_noise
from tests.support.building import plan_of, write
from tests.support.reported import codes, only
from tests.support.robots import joint, robot_with
from tests.support.urdfs import urdf_robot
from tests.unit.graph.urdf.test_reader import joint as urdf_joint
from tests.unit.graph.urdf.test_reader import link, robot_text


def dof_of(kind: str, limits: Limits, dynamics: Dynamics) -> tuple[Dof, Diagnostics]:
    """The dof of a joint with these properties after the pass, and what that reports."""
    row = joint(kind, "base", "arm", name="j", limits={"j": limits}, dynamics=dynamics)
    log = Diagnostics()
    (dof,) = without_placeholders(robot_with([row]), log).dofs
    return dof, log


OPEN = Limits()
RANGES = [
    ("revolute", Limits(-10, 10), OPEN), ("revolute", Limits(-100, 100), OPEN),
    ("revolute", Limits(-1e16, 1e16), OPEN), ("revolute", Limits(0, 1e16), Limits(0, None)),
    ("revolute", Limits(-1e16, 0.5), Limits(None, 0.5)), ("prismatic", Limits(-1e16, 1e16), OPEN),
    ("revolute", Limits(-6.28318530718, 6.28318530718), None), ("revolute", Limits(-9.42, 9.42), None),
    ("revolute", Limits(-9, 9), None), ("revolute", Limits(-10, 11), None),
    ("revolute", Limits(-10.5, 10.5), None), ("revolute", Limits(0, 10), None),
    ("prismatic", Limits(-10, 10), None), ("prismatic", Limits(-15, 15), None),
]  # fmt: skip


@pytest.mark.parametrize(("kind", "limits", "expected"), RANGES)
def test_a_range_that_no_joint_has_is_open(kind, limits, expected):
    dof, log = dof_of(kind, limits, Dynamics())
    assert dof.limits == (limits if expected is None else expected)
    assert [problem.code for problem in log.found] == ([] if expected is None else ["W-URDF-PLACEHOLDER"])


BOUNDS = [
    ("revolute", Dynamics(effort=1000.0, velocity=1000.0), (None, None)),
    ("revolute", Dynamics(effort=1e6, velocity=1e4), (None, None)),
    ("revolute", Dynamics(effort=1200.0, velocity=1500.0), (1200.0, 1500.0)),
    ("revolute", Dynamics(effort=100.0, velocity=100.0), (100.0, 100.0)),
    ("prismatic", Dynamics(effort=1000.0, velocity=1.0), (1000.0, 1.0)),
    ("prismatic", Dynamics(effort=1e6, velocity=1.0), (None, 1.0)),
]


@pytest.mark.parametrize(("kind", "dynamics", "expected"), BOUNDS)
def test_powers_of_ten_are_no_effort_and_no_velocity(kind, dynamics, expected):
    dof, _ = dof_of(kind, Limits(-1, 1), dynamics)
    assert (dof.dynamics.effort, dof.dynamics.velocity) == expected


PLACEHOLDER = '<limit lower="-10" upper="10" effort="1000" velocity="1000"/>'
TEXT = robot_text(
    *(link(name) for name in ("base", "upper", "lower")),
    urdf_joint("hip", "base", "upper", inside=PLACEHOLDER),
    urdf_joint("knee", "upper", "lower", inside=PLACEHOLDER),
)


def test_placeholders_are_named_together_with_their_joints():
    warning = only(urdf_robot(TEXT), "W-URDF-PLACEHOLDER")
    assert warning.where == "robot.urdf"
    for words in ("range -10 to 10 rad", "effort 1000 N m", "velocity 1000 rad/s"):
        assert f"{words} (hip, knee)" in warning.message
    assert "joints: {hip: {limits: [low, high], effort: N, velocity: N}}" in warning.hint


def test_the_same_numbers_count_where_the_user_gives_them(tmp_path):
    numbers = {"limits": [-10, 10], "effort": 1000, "velocity": 1000}
    robot = urdf_robot(TEXT, plan_of(joints={"*": numbers}))
    assert not {"W-URDF-PLACEHOLDER", "W-LIMIT"} & set(codes(robot))
    write(robot, tmp_path)
    limits = etree.parse(tmp_path / "robot.urdf").getroot().findall("joint/limit")
    written = {"lower": "-10", "upper": "10", "effort": "1000", "velocity": "1000"}
    assert [dict(limit.attrib) for limit in limits] == 2 * [written]


def legged() -> Robot:
    """A light body on four legs of three links, whose limits are those of no joint."""
    inertial = '<inertial><origin xyz="0 0 {z}"/><mass value="{m}"/>'
    inertial += '<inertia ixx="{i}" iyy="{i}" izz="{i}" ixy="0" ixz="0" iyz="0"/></inertial>'
    pieces = [link("base", inertial.format(z=0, m=1.2, i=0.01))]
    for leg, place in enumerate((".2 .1 0", ".2 -.1 0", "-.2 .1 0", "-.2 -.1 0")):
        parent = "base"
        for name, axis, at, mass, moment in (
            ("turn", "1 0 0", place, 0.15, 4e-5),
            ("hip", "0 1 0", "0 .014 0", 0.15, 4e-4),
            ("knee", "0 1 0", "0 .03 -.16", 0.03, 1e-4),
        ):
            child = f"{name}_{leg}"
            pieces.append(link(child, inertial.format(z=-0.08, m=mass, i=moment)))
            ends = f'<parent link="{parent}"/><child link="{child}"/><origin xyz="{at}"/><axis xyz="{axis}"/>'
            pieces.append(f'<joint name="{child}" type="revolute">{ends}{PLACEHOLDER}</joint>')
            parent = child
    return urdf_robot(robot_text(*pieces), plan_of(root={"base": "free"}))


def test_a_robot_with_placeholders_bears_noise_of_its_controls(tmp_path):
    write(legged(), tmp_path, plan_of(actuators={"*": {"type": "position"}}))
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "scene.xml"))
    assert model.nu == 12
    assert run_with_noise(model, 1.0).failed == ""
