"""Random documents, hand-made loops and robots of others: the SDF and the USD are the robot of the MJCF and
of the URDF, by three readers (`tests.support.parity`)."""

import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import strategies as st

from linkwright.stages.export import export
from linkwright.stages.robot.model.poses import at_rest
from linkwright.stages.robot.motion.kinematics import link_poses
from linkwright.stages.robot.motion.start_pose import home
from linkwright.stages.validate.read import sdf, usd
from tests.fake_onshape.sample import sample_document
from tests.support import mjcfs
from tests.support.building import NO_MESHES, plan_of, robot_of, write
from tests.support.drawn import DYNAMICS, PLACES, any_document, drawn, each
from tests.support.other_robots import FILES, is_here
from tests.support.parity import SdfParity, UsdParity
from tests.support.robots import LOOPS, joint, loop, pose, robot_with
from tests.support.ros2 import check_control, check_manifest, home_of, packed, same_robot, same_text
from tests.support.urdfs import urdf_robot
from tests.support.usd import pxr

pytestmark = pytest.mark.e2e

FORMATS = {"sdf": SdfParity, "usd": UsdParity}
CHECKS = {"sdf": sdf.check_file, "usd": usd.check_file}


def export_of(kind):
    return {"urdf": {}, "mjcf": {}, kind: {}}


def compare(kind, robot, plan, seed):
    """Compares the files; whether another pose closes the loops."""
    assert kind != "usd" or pxr.Usd
    rng = np.random.default_rng(seed)
    with tempfile.TemporaryDirectory() as folder:
        made = write(robot, Path(folder), plan)
        readers = FORMATS[kind](robot, made.files, Path(folder))
        (file,) = Path(folder).glob("robot.sdf" if kind == "sdf" else "robot.usda")
        checks = list(CHECKS[kind](file, made.written, quick=False))
        assert checks
        assert [check for check in checks if not check.passed] == []
        readers.agree(rng)
        return bool(robot.loops) and readers.close_again(rng)


slow = pytest.mark.slow


@pytest.mark.parametrize(
    ("kind", "loops", "count"),
    [
        ("sdf", False, 4),
        ("sdf", True, 4),
        ("usd", False, 3),
        pytest.param("usd", True, 3, marks=slow),
        pytest.param("sdf", None, 20, marks=slow),
        pytest.param("usd", None, 20, marks=slow),
    ],
)
def test_the_file_is_the_document(kind, loops, count):
    keys = {"export": export_of(kind), "joints": DYNAMICS}

    def agree(document, root, seed):
        compare(kind, *drawn(document, root, seed, **keys), seed)

    each(agree, count, any_document(loops=loops), PLACES, PLACES)


@pytest.mark.parametrize("kind", FORMATS)
def test_the_sample_is_one_robot_in_three_files(kind):
    plan = plan_of(export=export_of(kind), joints=DYNAMICS)
    assert compare(kind, robot_of(sample_document(), plan), plan, 1)


@slow
@pytest.mark.parametrize(
    ("kind", "saved", "onto_root"),
    [*((kind, True, kind in ("ball", "pin_slot")) for kind in LOOPS), ("planar", False, True)],
)
def test_a_loop_of_any_type_is_closed_at_another_pose(kind, saved, onto_root):
    """`saved`: whether zero does not close it, so that the SDF's joints count from elsewhere; `onto_root`:
    whether the mate's first entity is on the root."""
    rng = np.random.default_rng(LOOPS.index(kind))
    chain = (
        ("parallel", "base", "one", [0.2, -0.1, 0.3, 0.4]),
        ("ball", "one", "two", [(0.8, 0.6, 0.0, 0.0)]),
        ("revolute", "two", "three", [0.5]),
        ("prismatic", "three", "four", [0.1]),
    )
    rows = [
        joint(*ends, values if saved else None, place=pose(rng), backwards=ends[0] == "revolute")
        for *ends, values in chain
    ]
    robot = robot_with(rows)
    held = link_poses(robot, {dof.name: dof.saved for dof in robot.dofs})["four"]
    kinds = [dof.kind for dof in joint(kind, "base", "end").dofs]
    values = [(0.6, 0.0, 0.8, 0.0) if of_dof == "ball" else 0.3 for of_dof in kinds]
    end = joint(kind, "base", "end", values if saved else [at_rest(of_dof) for of_dof in kinds])
    own = {dof.name: dof.saved for dof in end.dofs}
    across, near = link_poses(robot_with([end]), own)["end"], pose(rng)
    if onto_root:
        shut = loop(kind, "base", "four", held @ near @ across, near, list(own.values()))
    else:
        shut = loop(kind, "four", "base", near, held @ near @ np.linalg.inv(across), list(own.values()))
    assert compare("sdf", replace(robot, loops=(shut,)), plan_of(export=export_of("sdf")), 3)


@slow
@pytest.mark.parametrize("name", FILES)
def test_a_robot_of_others_is_one_robot_in_three_files(name):
    if not is_here(name):
        pytest.skip("needs the robots of others")
    kind, path = FILES[name]
    plan = plan_of(export=export_of("sdf"))
    robot = urdf_robot(path.read_bytes(), plan) if kind == "urdf" else mjcfs.robot_of(path)
    compare("sdf", replace(robot, name="robot"), plan, 1)


KINDS = ("position", "motor")


def agree(document, seed):
    keys = {"export": {"urdf": {}, "ros2": {}}, "actuators": {"*": KINDS[seed % 2]}}
    free = robot_of(document).root.name != "world" and seed % 3 == 1
    plan = plan_of(root={"base": "free" if free else "fixed"}, **keys)
    robot = robot_of(document, plan)
    files = export(robot, NO_MESHES, plan).files
    urdf = files["robot.urdf"]
    with tempfile.TemporaryDirectory() as folder:
        package = packed(files, Path(folder))
        check_manifest(package)
        for prefix in ("", "arm_"):
            expanded = package.expanded(prefix=prefix)
            same_text(package.plain, expanded, prefix)
            same_robot(urdf, expanded, prefix)
        controllers = package.controllers()
        if controllers:
            check_control(package, package.expanded(), controllers)
            values = home_of(package.expanded())
            at_home = home(robot)
            for name, value in values.items():
                if name in at_home:
                    assert abs(value - at_home[name]) < 1e-9, name


@pytest.mark.parametrize(("loops", "count"), [(True, 2), pytest.param(None, 15, marks=pytest.mark.slow)])
def test_the_package_is_the_document(loops, count):
    each(agree, count, any_document(loops=loops), st.integers(0, 5))
