"""Real URDFs through all stages and by the command; and one robot both as a document and as a file."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from linkwright.stages.fetch.urdf.gather import gather
from linkwright.stages.graph import build_robot
from linkwright.stages.mesh import make_geometry
from linkwright.stages.robot.motion.kinematics import link_poses
from tests.fake_onshape.prefixed import prefixed
from tests.fake_onshape.sample import sample_document
from tests.support.building import bundle_of, plan_of, write
from tests.support.cases import mostly_slow
from tests.support.checked import checked
from tests.support.command import called, linkwright, robot_files
from tests.support.engines import Mujoco
from tests.support.other_robots import AS_IT_IS
from tests.support.parity import UsdParity
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


def made(bundle, plan, folder):
    """The robot, its shapes and its export, whose files are put into `folder`."""
    robot = build_robot(bundle, plan)
    geometry = make_geometry(robot, bundle, plan, lambda kind, key, make: make())
    return robot, geometry, write(robot, folder, plan, geometry)


def from_file(path, folder, *formats):
    source, mesh = {"kind": "urdf", "path": str(path)}, {"visual": {"max_faces": 2_000_000}}
    plan = plan_of(source=source, mesh=mesh, export={key: {} for key in ("urdf", "mjcf", *formats)})
    bundle, _ = gather(plan.source, {})
    return made(bundle, plan, folder)


@pytest.mark.slow
@pytest.mark.skipif(not ROBOTS.exists(), reason="there are no shared data")
@pytest.mark.parametrize("name", FILES)
def test_a_real_robot_is_its_file_and_valid(name, tmp_path):
    """And its USD is the same robot."""
    from linkwright.stages.validate.read.usd import check_file

    robot, _, export = from_file(ROBOTS / FILES[name], tmp_path, "usd")
    assert (len(robot.links), len(robot.joints), len(robot.frames)) == SIZES[name]
    text = (ROBOTS / FILES[name]).read_bytes()
    assert parity(text, robot, export.files, tmp_path).worst < EXACT
    assert not same_bounds(text, robot, export.files["robot.urdf"])
    assert not [check for check in checked(tmp_path, robot, plan_of()) if check.fails]
    UsdParity(robot, export.files, tmp_path).agree(np.random.default_rng(0))
    checks = list(check_file(tmp_path / "robot.usda", export.written, quick=False))
    assert len(checks) > 1
    assert not [check for check in checks if check.fails]


@pytest.mark.slow
@pytest.mark.skipif(not ROBOTS.exists(), reason="there are no shared data")
def test_a_real_robot_by_the_command(tmp_path):
    path = ROBOTS / FILES["reachy2"]
    linkwright(tmp_path, "source=urdf", f"source.path={path}", "mesh=hull", *AS_IT_IS, status=0)
    out = robot_files(tmp_path / "outputs" / "reachy2")
    assert {"reachy2.urdf", "reachy2.xml", "scene.xml", "robot.json"} <= set(out)
    assert not [name for name, data in out.items() if str(ROBOTS).encode() in data]
    again = linkwright(tmp_path, "source=urdf", f"source.path={path}", "mesh=hull", *AS_IT_IS)
    assert again.stderr.count("(cached)") >= 5, again.stderr


def test_a_bad_inertia_is_refused_with_the_way_out(tmp_path):
    text = (
        '<robot name="r"><link name="a"><inertial><mass value="1"/>'
        '<inertia ixx="1" iyy="1" izz="3" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>'
    )
    (tmp_path / "r.urdf").write_text(text)
    done = called(tmp_path, "source=urdf", "source.path=r.urdf", status=1)
    words = ("E-INERTIA", "1, 1, 3 kg m²", "source.bad_inertia")
    assert [word for word in words if word not in done.stderr] == []
    done = called(tmp_path, "source=urdf", "source.path=r.urdf", "source.bad_inertia=project", status=0)
    assert "W-INERTIA" in done.stdout + done.stderr


@pytest.mark.parametrize("document", mostly_slow([prefixed, sample_document], keep=1))
def test_one_robot_by_both_ways(document, tmp_path):
    """As a document of the local Onshape, and as the URDF that was made of it: the tree is the same."""
    bundle = bundle_of(document())
    first, first_shapes, _ = made(bundle, plan_of(), tmp_path / "first")
    second, second_shapes, _ = from_file(tmp_path / "first" / "robot.urdf", tmp_path / "second")
    tree = [joint for joint in second.joints if joint.name in {relation.name for relation in first.joints}]
    assert [link.name for link in second.links] == [link.name for link in first.links]
    assert [(j.name, j.type, j.parent, j.child) for j in tree] == [
        (j.name, j.type, j.parent, j.child) for j in first.joints
    ]
    assert {frame.name for frame in second.frames} >= {frame.name for frame in first.frames}
    assert [dof.limits for dof in second.dofs] == [dof.limits for dof in first.dofs]
    # A mimic has no name of its own. Those that stand for a loop are more, and hold wherever it is closed.
    by_follower = {relation.follower: replace(relation, name="") for relation in second.relations}
    for relation in first.relations:
        assert by_follower.pop(relation.follower) == replace(relation, name="")
    assert first.loops or not by_follower
    for link, other in zip(second.links, first.links, strict=True):
        assert abs(link.inertial.mass - other.inertial.mass) <= EXACT * other.inertial.mass
        assert np.abs(link.inertial.com - other.inertial.com).max(initial=0) < EXACT
        scale = np.abs(other.inertial.inertia).max() or 1.0
        assert np.abs(link.inertial.inertia - other.inertial.inertia).max() < EXACT * scale
    rng = np.random.default_rng(3)
    q = {dof.name: float(rng.uniform(-1, 1)) for dof in first.dofs}
    poses = link_poses(second, q)
    assert all(np.abs(poses[name] - pose).max() < EXACT for name, pose in link_poses(first, q).items())
    for role in ("visual", "collision"):
        assert volumes(second_shapes, role) == pytest.approx(volumes(first_shapes, role), rel=1e-6)
    names = [dof.name for dof in first.dofs]
    matrices = [Mujoco(tmp_path / way / "robot.xml").mass_matrix(q, names) for way in ("first", "second")]
    assert np.abs(matrices[0] - matrices[1]).max() < EXACT * np.abs(matrices[0]).max()


def volumes(geometry, role):
    """The volume [m³] of each link's closed shapes of this role."""
    sums = Counter()
    for shape in geometry.shapes:
        sums[shape.link] += shape.volume * (shape.role == role)
    return sums
