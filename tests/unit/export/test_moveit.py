"""MoveIt's package beside the ROS 2 package: every name in it is one of the URDF, SRDF or controllers."""

import math
from pathlib import Path

import pytest
import yaml

from linkwright.stages.robot.model.robot import Dynamics, Frame, Limits, Relation, frozen
from tests.support.building import NO_MESHES
from tests.support.exports import exported
from tests.support.robots import at, joint, robot_with
from tests.support.ros2 import IncludeLaunchDescription, check_manifest, launched, moveit_of, packed
from tests.support.srdf import Srdf
from tests.support.touching import box, geometry_of

MOVING = Dynamics(effort=5.0, velocity=3.0)
POSITION = {"actuators": {"*": "position"}}


def chain(count, *, relations=(), frames=(), names=None, fixed=True, **more):
    """An arm of hinges, 0.2 m apart, each but the last with a box."""
    names = names or [f"l{n}" for n in range(count)]
    rows, shapes = [], {"base": (box(0.05, 0.05, 0.05),)}
    for above, name in zip(["base", *names], names, strict=False):
        dof = f"{name}_joint"
        limits = {dof: Limits(-1.0, 1.0)}
        rows.append(joint("revolute", above, name, place=at(0.2, 0, 0), limits=limits, dynamics=MOVING))
        shapes[name] = (box(0.05, 0.05, 0.05),)
    return robot_with(rows, shapes=shapes, relations=relations, frames=frames, fixed=fixed, **more)


def made(robot, folder, geometry=NO_MESHES, ros2=None, **keys):
    files = exported(robot, geometry, export={"ros2": ros2 or {}}, **keys).files
    return packed(files, folder)


def config(package, name):
    """A file of MoveIt's package, as ROS reads it."""
    return yaml.safe_load((moveit_of(package).folder / "config" / f"{name}.yaml").read_text())


def semantic(package):
    (path,) = (moveit_of(package).folder / "config").glob("*.srdf")
    return Srdf(path.read_bytes(), package.plain)


def check(package):
    """Every name in the package means something."""
    srdf = semantic(package)
    assert srdf.problems() == []
    urdf = srdf.joints
    active = {name for name, value in urdf.items() if srdf.moves(name) and value.find("mimic") is None} - {
        passive_joint.get("name") for passive_joint in srdf.root.findall("passive_joint")
    }
    limits = config(package, "joint_limits")["joint_limits"]
    assert set(limits) == active
    for name, limit in limits.items():
        assert type(limit["max_velocity"]) is float
        assert type(limit["max_acceleration"]) is float
        assert limit["max_velocity"] == pytest.approx(float(urdf[name].find("limit").get("velocity")))
        assert limit["max_acceleration"] > 0
        assert limit["has_velocity_limits"] is limit["has_acceleration_limits"] is True
    assert set(config(package, "kinematics")) <= set(srdf.groups)
    moveit = moveit_of(package)
    needs = check_manifest(moveit)
    assert package.name in needs
    if (moveit.folder / "config" / "moveit_controllers.yaml").exists():
        controllers = config(package, "moveit_controllers")
        manager = controllers["moveit_simple_controller_manager"]
        assert controllers["moveit_controller_manager"].partition("/")[0] in needs
        ros_controllers = package.controllers()
        for name in manager["controller_names"]:
            parameters = ros_controllers[name]["ros__parameters"]
            assert manager[name]["joints"] == parameters["joints"]
            assert set(manager[name]["joints"]) <= active
            assert parameters["allow_partial_joints_goal"] is True
            kind = ros_controllers["controller_manager"]["ros__parameters"][name]["type"]
            assert kind == "joint_trajectory_controller/JointTrajectoryController"


@pytest.mark.parametrize("count", [1, 3, 5, 6, 7])
def test_an_arm_has_kinematics_limits_and_controllers(count, tmp_path):
    robot = chain(count)
    package = made(robot, tmp_path, geometry_of(robot), **POSITION)
    check(package)
    kinematics = config(package, "kinematics")
    if count < 3:
        assert kinematics == {}
    else:
        (solver,) = kinematics.values()
        assert solver["kinematics_solver"] == "kdl_kinematics_plugin/KDLKinematicsPlugin"
        assert solver.get("position_only_ik", False) == (count < 6)
    limits = config(package, "joint_limits")["joint_limits"]
    assert (limits["l0_joint"]["max_velocity"], limits["l0_joint"]["max_acceleration"]) == (3.0, 6.0)


def test_names_that_ros_does_not_take_are_the_same_in_all_files(tmp_path):
    names = ["upper arm", "on", "1st/hand"]
    robot = chain(3, names=names, frames=[Frame("tool.tip", "1st/hand", frozen(at(0, 0, 0.1)), "")])
    robot_names = made(robot, tmp_path, geometry_of(robot), **POSITION)
    check(robot_names)
    srdf = semantic(robot_names)
    assert set(srdf.groups) == {"tool_tip"}
    assert srdf.groups["tool_tip"] == {"upper_arm_joint", "on_joint", "joint_1st_hand_joint"}
    assert set(config(robot_names, "kinematics")) == {"tool_tip"}


def test_followers_have_no_limits_and_passive_joints_no_solver(tmp_path):
    robot = chain(4, relations=[Relation("gear", "l3_joint", "l2_joint", 0.5, 0.0)])
    package = made(robot, tmp_path, geometry_of(robot), **POSITION)
    check(package)
    assert set(config(package, "joint_limits")["joint_limits"]) == {"l0_joint", "l1_joint", "l2_joint"}
    loose = made(chain(4), tmp_path / "loose", actuators={"*": "position", "l1_joint": "none"})
    check(loose)
    assert config(loose, "kinematics") == {}


@pytest.mark.parametrize("fixed", [True, False])
def test_launch_file_starts_move_group_with_its_parameters(fixed, tmp_path, monkeypatch):
    robot = chain(6, fixed=fixed)
    package = made(robot, tmp_path, geometry_of(robot), **POSITION)
    moveit = moveit_of(package)
    group, frame, control, rviz = launched(moveit, "moveit.launch.py", monkeypatch)
    parameters = {key: value for part in group.parameters for key, value in part.items()}
    assert group.executable == "move_group"
    assert parameters["allow_trajectory_execution"] is True
    semantics = Srdf(
        parameters["robot_description_semantic"].encode(), parameters["robot_description"].encode()
    )
    assert semantics.problems() == []
    assert set(parameters["robot_description_kinematics"]) == set(semantics.groups)
    assert frame.arguments == ["--frame-id", "world", "--child-frame-id", "base"]
    assert semantics.root.find("virtual_joint").get("parent_frame") == "world"
    assert isinstance(control, IncludeLaunchDescription)
    assert Path(control.source.path) == package.folder / "launch" / "control.launch.py"
    # What it is given are arguments of that file.
    assert launched(package, "control.launch.py", monkeypatch, **dict(control.launch_arguments))
    view = yaml.safe_load(Path(rviz.arguments[1]).read_text())
    assert view["Visualization Manager"]["Global Options"]["Fixed Frame"] == "world"
    planning = view["Visualization Manager"]["Displays"][1]["Planning Request"]
    assert planning["Planning Group"] in semantics.groups
    quiet = launched(moveit, "moveit.launch.py", monkeypatch, rviz="false", robot="false", stand="false")
    assert [node.executable for node in quiet] == ["move_group"]


def test_without_position_control_moveit_only_plans(tmp_path, monkeypatch):
    robot = chain(3)
    package = made(robot, tmp_path, geometry_of(robot), actuators={"*": "motor"})
    check(package)
    assert not (moveit_of(package).folder / "config" / "moveit_controllers.yaml").exists()
    (group, *_) = launched(moveit_of(package), "moveit.launch.py", monkeypatch)
    assert group.parameters[1]["allow_trajectory_execution"] is False
    diagnostics = exported(robot, export={"ros2": {}}, actuators={"*": "motor"}).diagnostics
    assert "I-ROS2-MOVEIT" in {problem.code for problem in diagnostics}


def test_package_is_left_out_without_moving_joints(tmp_path):
    assert moveit_of(made(chain(3), tmp_path / "a", ros2={"moveit": False})) is None
    still = robot_with([joint("fixed", "base", "top")])
    assert moveit_of(made(still, tmp_path / "b")) is None


def test_it_has_the_name_of_the_package_that_it_is_for(tmp_path):
    named = made(chain(3), tmp_path, ros2={"package": "arm_description"})
    assert moveit_of(named).name == "arm_moveit_config"


@pytest.mark.parametrize(
    ("value", "text"),
    [(3.0, "3.0"), (0.1 + 0.2, "0.3"), (1e-7, "1.0e-07"), (2.5e20, "2.5e+20"), (1e6, "1000000.0")],
)
def test_numbers_are_real_ones_to_yaml(value, text):
    from linkwright.stages.export.ros2.moveit import _real

    assert _real(value) == text
    read = yaml.safe_load(text)
    assert type(read) is float
    assert math.isclose(read, value)
