"""What the files say, read back by the engines that will use them."""

import math
from types import SimpleNamespace

import mujoco
import numpy as np
import pytest

from linkwright.stages.export import export
from linkwright.stages.export.section import FORMATS, expected_paths
from linkwright.stages.export.writer import FormatFiles
from linkwright.stages.export.writers import WRITERS
from linkwright.stages.formats.xml import parse
from linkwright.stages.robot.motion.kinematics import saved_configuration
from linkwright.stages.robot.motion.start_pose import starting_point
from linkwright.stages.validate.dynamics.mujoco_features import reads_mimic
from tests.fake_onshape.frames import frame, turn
from tests.support.building import NO_MESHES, plan_of, robot_of, write
from tests.support.engines import Mujoco, Pinocchio
from tests.support.kit import SIDE, TOP
from tests.support.places import PROJECT


def two_links(kit, **more):
    base, arm = kit.place("Base", fixed=True), kit.place("Arm")
    kit.root.revolute("Elbow", (arm, TOP), (base, SIDE), value=0.3, **more)


def test_limits_effort_and_damping_arrive_in_both_files(kit, tmp_path):
    two_links(kit, limits=(-0.5, 1.5))
    joints = {"elbow": {"effort": 12, "velocity": 6, "damping": 0.1, "friction": 0.02, "armature": 0.01}}
    exported = write(robot_of(kit.document, plan_of(joints=joints)), tmp_path)
    assert [d.code for d in exported.diagnostics] == ["I-URDF-ARMATURE"]
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "robot.xml"))
    elbow = model.joint("elbow")
    assert (list(elbow.range), list(model.jnt_actfrcrange[elbow.id])) == ([-0.5, 1.5], [-12, 12])
    assert (elbow.damping[0], elbow.frictionloss[0], elbow.armature[0]) == (0.1, 0.02, 0.01)
    limit = parse(exported.files["robot.urdf"]).find("joint/limit")
    assert dict(limit.attrib) == {"lower": "-0.5", "upper": "1.5", "effort": "12", "velocity": "6"}
    dynamics = parse(exported.files["robot.urdf"]).find("joint/dynamics")
    assert dict(dynamics.attrib) == {"damping": "0.1", "friction": "0.02"}


def test_joint_without_limits_is_continuous(kit, tmp_path):
    two_links(kit)
    exported = write(robot_of(kit.document), tmp_path)
    joint = parse(exported.files["robot.urdf"]).find("joint")
    assert joint.get("type") == "continuous"
    assert dict(joint.find("limit").attrib) == {"effort": "100", "velocity": "10"}
    assert [d.code for d in exported.diagnostics] == ["I-URDF-UNSET"]
    assert not mujoco.MjModel.from_xml_path(str(tmp_path / "robot.xml")).jnt_limited[0]


def test_open_side_of_a_limit_stays_open_in_mujoco(kit, tmp_path):
    two_links(kit, limits=(0.2, None))
    exported = write(robot_of(kit.document), tmp_path)
    low, high = mujoco.MjModel.from_xml_path(str(tmp_path / "robot.xml")).joint("elbow").range
    assert (low, high) == (0.2, 1e6)
    limit = parse(exported.files["robot.urdf"]).find("joint/limit")
    assert float(limit.get("lower")) == 0.2
    assert float(limit.get("upper")) == pytest.approx(0.2 + 2 * math.pi)


def test_qpos0_is_the_saved_pose_if_loops_are_open_at_zero(kit, tmp_path):
    crooked_bar(kit)
    robot = robot_of(kit.document)
    start = starting_point(robot)
    assert {dof.name: start[dof.name] for dof in robot.dofs} == saved_configuration(robot)
    assert residual_at_start(robot, tmp_path) < 1e-9
    model = Mujoco(tmp_path / "robot.xml")
    for dof in robot.dofs:
        assert model.model.joint(dof.name).qpos0[0] == pytest.approx(dof.saved, abs=1e-11)
    # The numbers keep their meaning: the same q is the same pose in both files.
    pinocchio = Pinocchio((tmp_path / "robot.urdf").read_bytes())
    q = {joint.name: 0.1 * n for n, joint in enumerate(robot.joints)}
    there, here = pinocchio.poses(q), model.poses(q)
    assert all(np.abs(here[name] - there[name]).max() < 1e-9 for name in there)


def crooked_bar(kit):
    """A four-bar whose mate zeros (frames turned by odd angles) are no closed configuration."""
    base, crank, rocker, coupler = (kit.place(n) for n in ("Base", "Crank", "Rocker", "Coupler"))
    kit.root.instances[0].fixed = True
    far, odd = frame((0.1, 0, 0)), turn((0, 0, 1), 0.4)
    kit.root.revolute("Drive", (crank, np.eye(4)), (base, odd), value=0.5, limits=(-1, 1))
    kit.root.revolute("Pin", (coupler, np.eye(4)), (crank, far @ odd), value=-1.3)
    kit.root.revolute("Swing", (rocker, np.eye(4)), (base, far), value=0.9)
    kit.root.revolute("Close", (coupler, far), (rocker, far), closing=True)


def residual_at_start(robot, folder):
    write(robot, folder)
    model = mujoco.MjModel.from_xml_path(str(folder / "robot.xml"))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return float(np.abs(data.efc_pos[data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY]).max())


def test_a_gear_is_a_mimic_and_an_equality_with_the_same_numbers(kit, tmp_path):
    base, part_a, part_b = kit.place("Base", fixed=True), kit.place("One"), kit.place("Two")
    first = kit.root.revolute("First", (part_a, TOP), (base, SIDE), value=0.2, limits=(-1, 1))
    second = kit.root.revolute("Second", (part_b, TOP), (base, TOP), value=0.5, limits=(-2, 2))
    kit.root.gear("Gear", first, second, 1.5)
    robot = robot_of(kit.document)
    assert residual_at_start(robot, tmp_path) < 1e-9
    mimic = parse((tmp_path / "robot.urdf").read_bytes()).find("joint/mimic")
    assert dict(mimic.attrib) == {"joint": "first", "multiplier": "-1.5", "offset": "0.8"}
    if reads_mimic():  # MuJoCo's own reading of it is the same constraint.
        model = mujoco.MjModel.from_xml_path(str(tmp_path / "robot.urdf"))
        assert np.allclose(model.eq_data[0][:2], [0.8, -1.5])


def test_frames_are_sites_and_links_on_fixed_joints(kit, tmp_path):
    base, arm = kit.place("Base", fixed=True), kit.place("Arm")
    kit.root.revolute("Elbow", (arm, TOP), (base, SIDE), value=0.3, limits=(0, 1))
    kit.root.connector("Tool", arm, SIDE)
    write(robot_of(kit.document), tmp_path)
    expected = kit.document.truth.poses({"Elbow": 0.8})[arm.path] @ SIDE
    model = Mujoco(tmp_path / "robot.xml")
    model.poses({"elbow": 0.8})
    assert np.abs(model.data.site("tool").xpos - expected[:3, 3]).max() < 1e-9
    tool = Pinocchio((tmp_path / "robot.urdf").read_bytes()).poses({"elbow": 0.8})["tool"]
    assert np.abs(tool - expected).max() < 1e-9


def test_one_format_alone_is_written_alone(kit, tmp_path):
    two_links(kit)
    robot = robot_of(kit.document)
    exported = write(robot, tmp_path / "u", plan_of(export={"urdf": {}}))
    assert sorted(exported.files) == ["robot.json", "robot.srdf", "robot.urdf"]
    exported = write(robot, tmp_path / "m", plan_of(export={"mjcf": {}}))
    assert sorted(exported.files) == ["robot.json", "robot.xml", "scene.xml"]


def test_writer_has_a_folder_an_option_and_reads_earlier_writers():
    before = []
    for name in WRITERS:
        assert (PROJECT / "stages/export" / name / "section.py").is_file()
        assert (PROJECT / "conf/export" / f"{name}.yaml").is_file()
        assert set(WRITERS[name].reads) <= set(before)
        before.append(name)
    assert before == list(FORMATS)


def test_writer_reads_files_of_formats_that_are_not_chosen(kit, monkeypatch):
    def write(inputs):
        return FormatFiles({"seen.txt": " ".join(inputs.files).encode()})

    reader = SimpleNamespace(reads=("urdf",), write=write)
    monkeypatch.setattr("linkwright.stages.export.build.WRITERS", {**WRITERS, "reader": reader})
    two_links(kit)
    robot, plan = robot_of(kit.document), plan_of()
    for chosen in (("reader",), ("urdf", "reader")):
        exported = export(
            robot,
            NO_MESHES,
            plan.model_copy(
                update={"export": SimpleNamespace(chosen=chosen, urdf=plan.export.urdf, mjcf=None)}
            ),
        )
        assert exported.files["seen.txt"] == b"robot.urdf robot.srdf"
        assert ("robot.urdf" in exported.files) == ("urdf" in chosen)


def test_every_file_that_is_written_is_expected(kit, tmp_path):
    two_links(kit)
    plan = plan_of()
    exported = write(robot_of(kit.document), tmp_path, plan)
    expected = expected_paths(plan, "robot")
    assert sorted(exported.files) == sorted(path for path in expected if path != "assets/*")
