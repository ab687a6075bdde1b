"""What the files say, read back by the engines that will use them, without the noise of arithmetic."""

import json
import math
import re
from types import SimpleNamespace

import mujoco
import numpy as np
import pytest

from linkwright.stages.export import export
from linkwright.stages.export.section import FORMATS, expected_paths
from linkwright.stages.export.writer import FormatFiles
from linkwright.stages.export.writers import WRITERS
from linkwright.stages.formats.xml import parse
from linkwright.stages.robot.model.poses import rotation_from_rpy
from linkwright.stages.robot.model.robot import Dynamics, Frame, Inertial, Limits, Relation, frozen
from linkwright.stages.robot.motion.kinematics import saved_configuration
from linkwright.stages.robot.motion.start_pose import starting_point
from linkwright.stages.validate.dynamics.mujoco_features import reads_mimic
from tests.fake_onshape.frames import frame, turn
from tests.support.building import NO_MESHES, plan_of, robot_of, write
from tests.support.engines import Mujoco, Pinocchio
from tests.support.exports import exported
from tests.support.kit import SIDE, TOP
from tests.support.places import PROJECT
from tests.support.robots import from_parts, joint, robot_with
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


def test_files_are_those_of_the_chosen_formats(kit):
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


NOISE = 1e-13
"""m, rad: what is written and is smaller, and not zero."""


SCALED = ("mass", "inertia", "diaginertia", "solref", "solimp")
"""What may be small: measured by its own scale, or given."""


def noisy(rng):
    """A transform by quarter turns and lengths of a millimetre, with the noise of much arithmetic."""
    quarters = rng.integers(0, 4, 3) * np.pi / 2
    place = from_parts(
        rotation_from_rpy(tuple(quarters)), np.round(rng.uniform(-0.1, 0.1, 3), 3) * rng.integers(0, 2, 3)
    )
    place[:3] += rng.uniform(-8e-14, 8e-14, (3, 4))
    return place


def noisy_robot(seed):
    rng = np.random.default_rng(seed)
    few = 7e-14
    ends = {"arm_joint": (-few, 1.5), "hand_joint": (-0.2, few), "finger_joint": (0.0, 0.05)}
    limits = {name: Limits(*both) for name, both in ends.items()}
    strong = Dynamics(effort=3.0)
    rows = [
        joint("revolute", "base", "arm", (few,), place=noisy(rng), limits=limits),
        joint("prismatic", "arm", "hand", (-few,), place=noisy(rng), limits=limits, dynamics=strong),
        joint("fixed", "hand", "plate", place=noisy(rng)),
        joint("prismatic", "plate", "finger", (0.01,), place=noisy(rng), limits=limits),
        joint("revolute", "arm", "wheel", place=noisy(rng)),
    ]
    frames = [Frame("tool", "hand", frozen(noisy(rng)), ""), Frame("eye", "plate", frozen(noisy(rng)), "")]
    tensor = np.diag([2e-3, 3e-3, 4e-3]) + rng.uniform(-1e-18, 1e-18, (3, 3))
    body = Inertial(0.7, frozen(np.array([0.0, few, 0.02])), frozen((tensor + tensor.T) / 2))
    relation = Relation("gears", "wheel_joint", "arm_joint", 0.5, few)
    return robot_with(
        rows, relations=[relation], frames=frames, fixed=bool(seed % 2),
        inertials={"hand": body, "plate": body},
    )  # fmt: skip


def leaves(value, key=""):
    if isinstance(value, dict):
        for name, inside in value.items():
            yield from leaves(inside, name)
    elif isinstance(value, list) and not all(isinstance(item, int | float) for item in value):
        for inside in value:
            yield from leaves(inside, key)
    else:
        yield key, value


def numbers_of(node):
    """The numbers of the attributes of an element, as text."""
    texts = [text for key, text in node.attrib.items() if key not in SCALED]
    return [word for text in texts if re.fullmatch(r"[-+0-9.e ]+", text) for word in text.split()]


@pytest.mark.parametrize("seed", range(6))
def test_no_file_has_noise_or_a_negative_zero(tmp_path, seed):
    plan = plan_of(actuators={"*": "position"}, scene__cameras={"view": {"frame": "eye"}})
    files = write(noisy_robot(seed), tmp_path, plan).files
    for name in ("robot.urdf", "robot.xml", "scene.xml"):
        words = [word for node in parse(files[name]).iter() for word in numbers_of(node)]
        assert len(words) > 40 or name == "scene.xml"
        assert not [word for word in words if word == "-0" or 0 < abs(float(word)) < NOISE], name
    for key, value in leaves(json.loads(files["robot.json"])):
        numbers = value if isinstance(value, list) else [value]
        small = [number for number in numbers if isinstance(number, float) and 0 < abs(number) < NOISE]
        assert not small or key in ("mass", "inertia"), (key, value)
