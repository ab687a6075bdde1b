"""Drake reads the URDF and the SDF as the same robot: kinematics and mass matrix, without loops."""

from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
import trimesh
from hypothesis import HealthCheck, assume, given, settings

from linkwright.stages.robot.model.geometry import Geometry, Shape
from linkwright.stages.robot.model.robot import Relation
from tests.fake_onshape.random_document import documents
from tests.fake_onshape.sample import sample_document
from tests.support.building import plan_of, robot_of, write
from tests.support.command import called
from tests.support.drake import drake_python, read, refusal
from tests.support.engines import Pinocchio
from tests.support.other_robots import AS_IT_IS, FILES, is_here, source_of
from tests.support.parity import SdfParity, same
from tests.support.robots import EVERY, at, joint, loop, pose, robot_with, some_values
from tests.support.sdf import Sdf, transform

pytestmark = pytest.mark.slow

PLAN = plan_of(export={"urdf": {}, "mjcf": {}, "sdf": {}})
COUNT = 5
SUFFIXES = ("urdf", "sdf", "xml")


@pytest.fixture(scope="session")
def python(run_folder):
    return drake_python(run_folder)


def every_joint():
    rng = np.random.default_rng(7)
    rows, above = [], "base"
    for kind in (kind for kind in EVERY if kind != "free"):
        rows.append(joint(kind, above, f"{kind}_link", place=pose(rng), backwards=kind == "planar"))
        above = rows[-1].child if kind in ("revolute", "ball", "planar") else above
    return robot_with(rows)


def agrees_by_sdf(python, robot, folder):
    """By the robot's own dofs, against MuJoCo and Pinocchio."""
    three = SdfParity(robot, write(robot, folder, PLAN).files, folder)
    rng = np.random.default_rng(0)
    drawn = [some_values(robot, rng) for _ in range(COUNT)]
    names = [three.joint(name) for name in three.names]
    answers = read(python, folder / "robot.sdf", names, [three.values(q) for q in drawn], None)
    for q, answer in zip(drawn, answers, strict=True):
        expected = three.mujoco.poses(q)
        for link in robot.links:
            same(np.array(answer["poses"][three.link(link.name)]), expected[link.name])
        for engine in (three.mujoco, three.pinocchio) if names else ():
            same(np.array(answer["mass"]), engine.mass_matrix(q, three.names))


def test_the_sdf_of_every_joint_is_the_robot(python, tmp_path):
    agrees_by_sdf(python, every_joint(), tmp_path)


@settings(max_examples=4, suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large])
@given(documents(everything=True, fixed=True))
def test_both_files_of_a_document_are_the_robot(python, document):
    robot = robot_of(document, PLAN)
    assume(robot.base.fixed and not robot.loops)
    with TemporaryDirectory() as folder:
        agrees_by_sdf(python, robot, Path(folder))
        path = Path(folder) / "robot.urdf"
        agrees_by_urdf(python, path, path.read_bytes(), robot.root.name)


def test_the_urdf_of_every_joint_is_the_robot(python, tmp_path):
    robot = every_joint()
    agrees_by_urdf(python, tmp_path / "robot.urdf", write(robot, tmp_path, PLAN).files["robot.urdf"], "base")


def test_the_urdf_of_the_sample_is_the_robot(python, tmp_path):
    robot = robot_of(sample_document(), PLAN)
    files = write(robot, tmp_path, PLAN).files
    agrees_by_urdf(python, tmp_path / "robot.urdf", files["robot.urdf"], robot.root.name)


def boxed(kind):
    """A collider of the link arm, in a file of that kind."""
    box = trimesh.creation.box((0.1, 0.1, 0.1)).export(file_type=kind)
    shape = Shape("arm", "collision", f"arm.{kind}", None, 8, 12, 1.0, 1.0)
    return Geometry((shape,), {f"arm.{kind}": box if isinstance(box, bytes) else box.encode()})


def dropping():
    rows = [joint("revolute", "base", "arm"), joint("revolute", "base", "gear", place=at(0.1, 0, 0))]
    return robot_with(rows, relations=[Relation("Gear", "gear_joint", "arm_joint", 0.5, 0.1)])


def test_table_of_readers_has_what_drake_refuses_or_drops(python, tmp_path):
    """The rows of `stages/targets/readers.py`, as measured again."""
    for kind in ("stl", "obj"):
        folder = tmp_path / kind
        folder.mkdir()
        write(dropping(), folder, PLAN, boxed(kind))
        for suffix in SUFFIXES:
            refused = refusal(python, folder / f"robot.{suffix}")
            assert (".stl" in refused) == (kind == "stl"), refused
    answers = [read(python, tmp_path / "obj" / f"robot.{suffix}", (), ({},), None)[0] for suffix in SUFFIXES]
    assert [entry["constraints"] for entry in answers] == [1, 0, 0]
    # A URDF's root is free.
    assert [entry["positions"] for entry in answers] == [9, 2, 2]
    robot = dropping()
    shut = loop("ball", "arm", "gear", at(0.1, 0, 0), np.eye(4), [(1.0, 0.0, 0.0, 0.0)])
    write(replace(robot, relations=(), loops=(shut,)), tmp_path, PLAN)
    assert "form one or more loops" in refusal(python, tmp_path / "robot.sdf")
    (open_,) = read(python, tmp_path / "robot.xml", (), ({},), None)
    assert open_["constraints"] == 0


@pytest.mark.parametrize("name", FILES)
def test_a_robot_of_others_is_the_same_in_drake(name, python, tmp_path):
    if not is_here(name):
        pytest.skip("needs the robots of others")
    arguments = [*source_of(name), "root=fixed", "mesh=visual", "mesh.assets=none", "validate=quick"]
    called(tmp_path, *arguments, *AS_IT_IS, "export=[urdf,sdf]", "output=out", status=0)
    (path,) = (tmp_path / "out").glob("*.sdf")
    sdf = Sdf(path.read_bytes())
    root = str(sdf.top.get("canonical_link"))
    agrees_by_urdf(python, path.with_suffix(".urdf"), path.with_suffix(".urdf").read_bytes(), root)
    if sdf.loops:
        return
    rng = np.random.default_rng(1)
    names = [name for name in sdf.model.names if name != "universe"]
    drawn = [{name: float(rng.uniform(-1, 1)) for name in names} for _ in range(COUNT)]
    for q, answer in zip(drawn, read(python, path, names, drawn, None), strict=True):
        poses = sdf.poses(q)
        for link, expected in poses.items():
            same(np.array(answer["poses"][link]), sdf_world(sdf) @ expected)
        same(np.array(answer["mass"]), sdf.mass_matrix(q, names))


def sdf_world(sdf):
    """world_from_model (4, 4)."""
    return transform(sdf.top.findtext("pose"))


def agrees_by_urdf(python, path, text, root):
    """By the joints that a URDF has, a ball being three, against Pinocchio."""
    pinocchio = Pinocchio(text)
    names = [name for name in pinocchio.model.names if name != "universe"]
    rng = np.random.default_rng(2)
    drawn = [{name: float(rng.uniform(-1, 1)) for name in names} for _ in range(COUNT)]
    weld = None if root == "world" else root
    for q, answer in zip(drawn, read(python, path, names, drawn, weld), strict=True):
        assert answer["positions"] == len(names)
        poses = pinocchio.poses(q)
        for link, pose_ in answer["poses"].items():
            same(np.array(pose_), poses[link])
        same(np.array(answer["mass"]), pinocchio.mass_matrix(q, names))
