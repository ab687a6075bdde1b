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
from tests.support.exports import exported
from tests.support.kit import SIDE, TOP
from tests.support.places import PROJECT
from tests.support.states import equality_errors, pose_of, state


def model_in(folder):
    return mujoco.MjModel.from_xml_path(str(folder / "robot.xml"))


def limit_in(outcome):
    return dict(parse(outcome.files["robot.urdf"]).find("joint/limit").attrib)


def test_limits_effort_and_damping_arrive_in_both_files(kit, tmp_path):
    kit.elbow(value=0.3, limits=(-0.5, 1.5))
    joints = {"elbow": {"effort": 12, "velocity": 6, "damping": 0.1, "friction": 0.02, "armature": 0.01}}
    outcome = write(robot_of(kit.document, plan_of(joints=joints)), tmp_path)
    assert [d.code for d in outcome.diagnostics] == ["I-URDF-ARMATURE"]
    model = model_in(tmp_path)
    elbow = model.joint("elbow")
    assert (list(elbow.range), list(model.jnt_actfrcrange[elbow.id])) == ([-0.5, 1.5], [-12, 12])
    assert (elbow.damping[0], elbow.frictionloss[0], elbow.armature[0]) == (0.1, 0.02, 0.01)
    assert limit_in(outcome) == {"lower": "-0.5", "upper": "1.5", "effort": "12", "velocity": "6"}
    dynamics = parse(outcome.files["robot.urdf"]).find("joint/dynamics")
    assert dict(dynamics.attrib) == {"damping": "0.1", "friction": "0.02"}


def test_joint_without_limits_is_continuous(kit, tmp_path):
    kit.elbow(value=0.3)
    outcome = write(robot_of(kit.document), tmp_path)
    assert parse(outcome.files["robot.urdf"]).find("joint").get("type") == "continuous"
    assert limit_in(outcome) == {"effort": "100", "velocity": "10"}
    assert [d.code for d in outcome.diagnostics] == ["I-URDF-UNSET"]
    assert not model_in(tmp_path).jnt_limited[0]


def test_open_side_of_a_limit_stays_open_in_mujoco(kit, tmp_path):
    kit.elbow(value=0.3, limits=(0.2, None))
    limit = limit_in(write(robot_of(kit.document), tmp_path))
    assert list(model_in(tmp_path).joint("elbow").range) == [0.2, 1e6]
    assert [float(limit[end]) for end in ("lower", "upper")] == pytest.approx([0.2, 0.2 + 2 * math.pi])


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
    model = model_in(folder)
    return float(np.abs(equality_errors(model, state(model))).max())


def test_gear_is_a_mimic_and_an_equality_with_the_same_numbers(kit, tmp_path):
    base, part_a, part_b = kit.based("One", "Two")
    first = kit.root.revolute("First", (part_a, TOP), (base, SIDE), value=0.2, limits=(-1, 1))
    second = kit.root.revolute("Second", (part_b, TOP), (base, TOP), value=0.5, limits=(-2, 2))
    kit.root.gear("Gear", first, second, 1.5)
    assert residual_at_start(robot_of(kit.document), tmp_path) < 1e-9
    mimic = parse((tmp_path / "robot.urdf").read_bytes()).find("joint/mimic")
    assert dict(mimic.attrib) == {"joint": "first", "multiplier": "-1.5", "offset": "0.8"}
    if reads_mimic():  # MuJoCo's own reading of it is the same constraint.
        model = mujoco.MjModel.from_xml_path(str(tmp_path / "robot.urdf"))
        assert np.allclose(model.eq_data[0][:2], [0.8, -1.5])


def test_frames_are_sites_and_links_on_fixed_joints(kit, tmp_path):
    _, arm = kit.elbow(value=0.3, limits=(0, 1))
    kit.root.connector("Tool", arm, SIDE)
    outcome = write(robot_of(kit.document), tmp_path)
    expected = kit.document.truth.poses({"Elbow": 0.8})[arm.path] @ SIDE
    tool = Pinocchio(outcome.files["robot.urdf"]).poses({"elbow": 0.8})["tool"]
    assert np.abs(tool - expected).max() < 1e-9
    site = state(model_in(tmp_path), elbow=0.8).site("tool")
    assert np.abs(pose_of(site) - expected).max() < 1e-9


def test_one_format_alone_is_written_alone(kit):
    kit.elbow(value=0.3)
    robot = robot_of(kit.document)
    urdf, mjcf = (exported(robot, export={name: {}}) for name in ("urdf", "mjcf"))
    assert sorted(urdf.files) == ["robot.json", "robot.srdf", "robot.urdf"]
    assert sorted(mjcf.files) == ["robot.json", "robot.xml", "scene.xml"]
    both = [path for path in expected_paths(plan_of(), "robot") if path != "assets/*"]
    assert sorted(exported(robot).files) == sorted(both), "every file that is written is expected"


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
    kit.elbow(value=0.3)
    robot, plan = robot_of(kit.document), plan_of()
    for chosen in (("reader",), ("urdf", "reader")):
        section = SimpleNamespace(chosen=chosen, urdf=plan.export.urdf, mjcf=None)
        outcome = export(robot, NO_MESHES, plan.model_copy(update={"export": section}))
        assert outcome.files["seen.txt"] == b"robot.urdf robot.srdf"
        assert ("robot.urdf" in outcome.files) == ("urdf" in chosen)
