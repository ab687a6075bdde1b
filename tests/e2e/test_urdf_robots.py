"""Real URDFs through all stages and by the command; and one robot both as a document and as a file."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from linkwright.pipeline.config.plan import Plan
from linkwright.stages.export import export
from linkwright.stages.fetch.urdf.gather import gather
from linkwright.stages.graph import build_robot
from linkwright.stages.mesh import make_geometry
from linkwright.stages.robot.bundle import Bundle
from linkwright.stages.robot.model.geometry import Geometry
from linkwright.stages.robot.model.robot import Robot
from linkwright.stages.robot.motion.kinematics import link_poses
from tests.fake_onshape.document import Document
from tests.fake_onshape.prefixed import prefixed
from tests.fake_onshape.sample import sample_document
from tests.support.building import bundle_of, plan_of
from tests.support.cases import mostly_slow
from tests.support.checked import checked
from tests.support.command import called, linkwright
from tests.support.engines import Mujoco
from tests.support.other_robots import AS_IT_IS
from tests.support.places import SHARED
from tests.support.urdfs import parity, same_bounds

ROBOTS = SHARED / "data" / "robots"
EXACT = 1e-9
FILES = {
    "so101": "so101/Simulation/SO101/so101_new_calib.urdf",
    "open_duck_mini": "open_duck_mini_bdx/mini_bdx/robots/bdx/robot.urdf",
    "reachy2": "reachy2/reachy2_mujoco/description/modified_urdf/reachy2.urdf",
}
SIZES = {"so101": (7, 6, 1), "open_duck_mini": (16, 15, 4), "reachy2": (74, 73, 4)}
"""Links, joints and frames: what is in the file, less the dummies that became frames."""


def made(bundle: Bundle, plan: Plan, folder: Path) -> tuple[Robot, Geometry, dict[str, bytes]]:
    """The robot, its shapes and its files, which lie in `folder`."""
    robot = build_robot(bundle, plan)
    geometry = make_geometry(robot, bundle, plan, lambda kind, key, make: make())
    files = dict(export(robot, geometry, plan).files)
    for name, data in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(data)
    return robot, geometry, files


def from_file(path: Path, folder: Path) -> tuple[Robot, Geometry, dict[str, bytes]]:
    plan = plan_of(source={"kind": "urdf", "path": str(path)}, mesh={"visual": {"max_faces": 2_000_000}})
    bundle, _ = gather(plan.source, {})
    return made(bundle, plan, folder)


@pytest.mark.slow
@pytest.mark.skipif(not ROBOTS.exists(), reason="there are no shared data")
@pytest.mark.parametrize("name", FILES)
def test_a_real_robot_is_its_file_and_valid(name: str, tmp_path: Path) -> None:
    robot, _, files = from_file(ROBOTS / FILES[name], tmp_path)
    assert (len(robot.links), len(robot.joints), len(robot.frames)) == SIZES[name]
    text = (ROBOTS / FILES[name]).read_bytes()
    assert parity(text, robot, files, tmp_path).worst < EXACT
    assert not same_bounds(text, robot, files["robot.urdf"])
    assert not [check for check in checked(tmp_path, robot, plan_of()) if check.fails]


@pytest.mark.slow
@pytest.mark.skipif(not ROBOTS.exists(), reason="there are no shared data")
def test_a_real_robot_by_the_command(tmp_path: Path) -> None:
    path = ROBOTS / FILES["reachy2"]
    done = linkwright(tmp_path, "source=urdf", f"source.path={path}", "mesh=hull", *AS_IT_IS)
    assert done.returncode == 0, done.stderr
    out = tmp_path / "outputs" / "reachy2"
    assert {"reachy2.urdf", "reachy2.xml", "scene.xml", "robot.json"} <= {one.name for one in out.iterdir()}
    written = b"".join(one.read_bytes() for one in out.iterdir() if one.suffix in (".urdf", ".xml", ".json"))
    assert str(ROBOTS).encode() not in written
    again = linkwright(tmp_path, "source=urdf", f"source.path={path}", "mesh=hull", *AS_IT_IS)
    assert again.stderr.count("(cached)") >= 5, again.stderr


def test_a_bad_inertia_is_refused_with_the_way_out(tmp_path: Path) -> None:
    text = (
        '<robot name="r"><link name="a"><inertial><mass value="1"/>'
        '<inertia ixx="1" iyy="1" izz="3" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>'
    )
    (tmp_path / "r.urdf").write_text(text)
    done = called(tmp_path, "source=urdf", "source.path=r.urdf")
    assert done.returncode == 1
    assert "E-INERTIA" in done.stderr
    assert "1, 1, 3 kg m²" in done.stderr
    assert "source.bad_inertia" in done.stderr
    done = called(tmp_path, "source=urdf", "source.path=r.urdf", "source.bad_inertia=project")
    assert done.returncode == 0, done.stderr
    assert "W-INERTIA" in done.stdout + done.stderr


@pytest.mark.parametrize("document", mostly_slow([prefixed, sample_document], keep=1))
def test_one_robot_by_both_ways(document: object, tmp_path: Path) -> None:
    """As a document of the local Onshape, and as the URDF that was made of it: the tree is the same."""
    bundle = bundle_of(drawn(document))
    first, first_shapes, _ = made(bundle, plan_of(), tmp_path / "first")
    second, second_shapes, _ = from_file(tmp_path / "first" / "robot.urdf", tmp_path / "second")
    tree = [joint for joint in second.joints if joint.name in {one.name for one in first.joints}]
    assert [link.name for link in second.links] == [link.name for link in first.links]
    assert [(j.name, j.type, j.parent, j.child) for j in tree] == [
        (j.name, j.type, j.parent, j.child) for j in first.joints
    ]
    assert {frame.name for frame in second.frames} >= {frame.name for frame in first.frames}
    assert [dof.limits for dof in second.dofs] == [dof.limits for dof in first.dofs]
    # A mimic has no name of its own. Those that stand for a loop are more, and hold wherever it is closed.
    by_follower = {one.follower: replace(one, name="") for one in second.relations}
    for one in first.relations:
        assert by_follower.pop(one.follower) == replace(one, name="")
    assert first.loops or not by_follower
    for one, other in zip(second.links, first.links, strict=True):
        assert abs(one.inertial.mass - other.inertial.mass) <= EXACT * other.inertial.mass
        assert np.abs(one.inertial.com - other.inertial.com).max(initial=0) < EXACT
        scale = np.abs(other.inertial.inertia).max() or 1.0
        assert np.abs(one.inertial.inertia - other.inertial.inertia).max() < EXACT * scale
    rng = np.random.default_rng(3)
    q = {dof.name: float(rng.uniform(-1, 1)) for dof in first.dofs}
    poses = link_poses(second, q)
    assert all(np.abs(poses[name] - pose).max() < EXACT for name, pose in link_poses(first, q).items())
    for role in ("visual", "collision"):
        assert volumes(second_shapes, role) == pytest.approx(volumes(first_shapes, role), rel=1e-6)
    names = [dof.name for dof in first.dofs]
    matrices = [Mujoco(tmp_path / way / "robot.xml").mass_matrix(q, names) for way in ("first", "second")]
    assert np.abs(matrices[0] - matrices[1]).max() < EXACT * np.abs(matrices[0]).max()


def drawn(document: object) -> Document:
    assert callable(document)
    return document()


def volumes(geometry: Geometry, role: str) -> dict[str, float]:
    """The volume [m³] of each link's closed shapes of this role."""
    found: dict[str, float] = {}
    for shape in geometry.shapes:
        if shape.role == role:
            found[shape.link] = found.get(shape.link, 0.0) + shape.volume
    return found
