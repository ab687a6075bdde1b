"""The SRDF of random documents and of random trees of boxes and balls: its rules, its poses, and that what
never touches does not."""

import os
import subprocess
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import strategies as st

from linkwright.stages.export.urdf.srdf.convex import bodies_of, distance_bounds
from linkwright.stages.robot.model.poses import inverse
from linkwright.stages.robot.model.robot import Limits, frozen
from linkwright.stages.robot.motion.start_pose import home
from tests.property.test_self_contact import random_robot
from tests.support.building import NO_MESHES, plan_of, robot_of, write
from tests.support.drawn import any_document, each
from tests.support.places import PROJECT
from tests.support.robots import joint, pose, robot_with
from tests.support.ros2 import moveit_of, packed
from tests.support.srdf import InPinocchio, Srdf
from tests.support.touching import apart, ball, box, geometry_of
from tests.unit.export.test_moveit import check

pytestmark = pytest.mark.e2e

SEEDS = [*range(3), *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(3, 15))]


def agree(robot, folder, geometry=NO_MESHES):
    """Writes a robot, and holds its SRDF against its URDF and its home."""
    files = write(robot, folder, plan_of(export={"urdf": {}}), geometry).files
    semantics = Srdf(files["robot.srdf"], files["robot.urdf"])
    # A pose that no loop allows within the limits is reported elsewhere.
    assert [problem for problem in semantics.problems() if "outside its limits" not in problem] == []
    at = home(robot)
    for group in semantics.groups:
        for name, value in semantics.states(group)["home"].items():
            if name in at:
                assert value == pytest.approx(at[name], abs=1e-9)
    return semantics


@pytest.mark.parametrize(("loops", "count"), [(False, 8), (True, 4)])
def test_the_srdf_of_a_document_keeps_the_rules(loops, count):
    def keeps(document, free):
        robot = robot_of(document)
        if not loops and robot.root.name != "world":
            robot = robot_of(document, plan_of(root={"base": "free" if free else "fixed"}))
        with tempfile.TemporaryDirectory() as folder:
            agree(robot, Path(folder))

    each(keeps, count, any_document(loops=loops), st.booleans())


def test_names_in_moveits_package_of_a_document_mean_something():
    def means(document, driven):
        keys = {"actuators": {"*": "position" if driven else "motor"}}
        plan = plan_of(export={"ros2": {}, "urdf": {}}, **keys)
        with tempfile.TemporaryDirectory() as folder:
            package = packed(write(robot_of(document, plan), Path(folder), plan).files, Path(folder))
            if moveit_of(package) is not None:
                check(package)

    each(means, 5, any_document(loops=True), st.booleans())


def arm(seed):
    """A chain of links with long boxes, whose ends come near each other in some poses, and a few branches."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(4, 9))
    names = [f"l{n}" for n in range(count)]
    rows, shapes = [], {}
    for index, name in enumerate(names):
        length = rng.uniform(0.05, 0.25)
        shapes[name] = (box(length, 0.04, 0.04, pose(rng, 0.1)),)
        if rng.random() < 0.3:
            shapes[name] += (ball(rng.uniform(0.02, 0.05), pose(rng, 0.1)),)
        if index:
            above = names[index - 1] if rng.random() < 0.8 else names[int(rng.integers(index))]
            reach = rng.uniform(0.3, 3.0)
            limits = {f"{name}_joint": Limits(-reach, reach * rng.uniform(0.2, 1.0))}
            kind = "prismatic" if rng.random() < 0.15 else "revolute"
            rows.append(joint(kind, above, name, place=pose(rng, 0.25), limits=limits))
    return robot_with(rows, shapes=shapes, root=names[0])


@pytest.mark.parametrize("make", [random_robot, arm])
@pytest.mark.parametrize("seed", SEEDS)
def test_links_that_never_touch_do_so_in_no_fresh_pose(seed, make, tmp_path):
    robot = make(seed)
    semantics = agree(robot, tmp_path, geometry_of(robot))
    never = {pair for pair, reason in semantics.disabled.items() if reason == "Never"}
    assert InPinocchio(tmp_path).touching(never, 1000, seed) == set()
    assert make is not arm or seed > 2 or len(never) > 4


CODE = """import sys; from pathlib import Path; from tests.property.test_srdf import agree, arm, geometry_of
robot = arm(1); agree(robot, Path(sys.argv[1]), geometry_of(robot))"""


def test_a_process_with_another_hash_seed_writes_the_same_bytes(tmp_path):
    robot = arm(1)
    agree(robot, tmp_path, geometry_of(robot))
    (tmp_path / "other").mkdir()
    environ = os.environ | {"PYTHONHASHSEED": "77", "PYTHONPATH": str(PROJECT)}
    command = [sys.executable, "-c", CODE, str(tmp_path / "other")]
    subprocess.run(command, env=environ, check=True, capture_output=True, timeout=300)
    first, second = ((tmp_path / folder / "robot.srdf").read_bytes() for folder in ("", "other"))
    assert first == second
    assert b"Never" in first


@pytest.mark.parametrize("seed", range(5))
def test_a_bound_is_below_the_distance_and_near_it(seed):
    """Two links of a box and a ball each, held against a closed form and, of balls, the exact distance."""
    rng = np.random.default_rng(seed)
    base = (box(*rng.uniform(0.05, 0.3, 3), pose(rng, 0.1)), ball(0.05, pose(rng, 0.1)))
    far = (ball(0.04, pose(rng, 0.1)), ball(0.07, pose(rng, 0.1)))
    count, row = 30, joint("free", "base", "far")
    robot = robot_with([row], shapes={"base": base, "far": far})
    bodies = bodies_of(geometry_of(robot), {link: [(link, np.eye(4))] for link in ("base", "far")})
    places = np.stack([pose(rng, 0.6) for _ in range(count)])
    bounds = distance_bounds(bodies["base"], bodies["far"], places, -np.inf)
    back = distance_bounds(
        bodies["far"], bodies["base"], np.stack([inverse(place) for place in places]), -np.inf
    )
    near = 0
    for place, bound, other in zip(places, bounds, back, strict=True):
        fixed = replace(robot, joints=(replace(row, dofs=(), type="fixed", parent_from_joint=frozen(place)),))
        true = apart(fixed, {})["base", "far"]
        # Of links that overlap no more is said than that they are not known to be apart.
        assert max(bound, other) <= max(true, 0.0) + 1e-9
        near += true > 0.01 and bound > 0.9 * true
    assert near > count / 3
