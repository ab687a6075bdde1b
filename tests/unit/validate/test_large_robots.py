"""Checks of robots of many links: they take work of their links, not of pairs of them, and find as much."""

import json
import subprocess
import sys
from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

from linkwright.stages.formats.described import read_robot_json
from linkwright.stages.formats.urdf.contacts import excluded_pairs
from linkwright.stages.formats.written import Written
from linkwright.stages.robot.dynamics.mass_matrix import mass_matrix
from linkwright.stages.robot.model.robot import Dynamics, Limits
from linkwright.stages.validate.checks.contact import contact_filter, reach
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.contact_errors import never_collide
from linkwright.stages.validate.dynamics.mass_probes import MAX_WHOLE_DOFS, PROBE_COUNT, probe_vectors
from linkwright.stages.validate.dynamics.random_poses import MIN_POSES, POSES, poses_and_speeds
from linkwright.stages.validate.dynamics.tree_dynamics import PosedRobot
from tests.support.building import plan_of, write
from tests.support.checked import checked
from tests.support.exports import compiled, exported
from tests.support.robots import at, joint, robot_with
from tests.support.touching import ball, geometry_of
from tests.unit.validate.test_parity_check import heavier

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("no_score")]

MANY = MAX_WHOLE_DOFS + 20


def chain(links):
    return _robot(links, lambda number: number - 1)


def tree(links):
    return _robot(links, lambda number: (number - 1) // 2)


def _robot(links, above):
    names = ["base", *(f"l{number}" for number in range(1, links))]
    rows = []
    for number, name in enumerate(names[1:], start=1):
        place, limits = at(0.02 * (-1) ** number, 0.0, 0.05), {f"{name}_joint": Limits(-0.5, 0.5)}
        mate = {"place": place, "limits": limits, "dynamics": Dynamics(0.1, 0.1, 0.01, 10, 2)}
        row = joint("revolute", names[above(number)], name, **mate)
        (dof,) = row.dofs
        rows.append(replace(row, dofs=(replace(dof, axis=np.eye(3)[(number - 1) % 3]),)))
    return robot_with(rows)


def test_more_links_the_fewer_poses():
    assert {len(poses_and_speeds(robot)[1]) for robot in (chain(3), tree(150))} == {POSES}
    assert len(poses_and_speeds(tree(1000))[1]) == 20
    assert len(poses_and_speeds(tree(3000))[1]) == MIN_POSES


def test_products_are_those_of_the_whole_matrix():
    robot = tree(MANY + 2)
    values, speeds = poses_and_speeds(robot)
    few = {name: value[:3] for name, value in values.items()}
    mechanism = PosedRobot(robot, few)
    own = mechanism.diagonal()
    vectors = probe_vectors(own)
    assert vectors is not None
    assert vectors.shape == (MANY + 1, PROBE_COUNT)
    up = np.tile([0.0, 0.0, 9.81], (3, 1))
    whole = mechanism.dynamics(speeds[:3], up).mass
    products = mechanism.dynamics(speeds[:3], up, vectors).mass
    np.testing.assert_allclose(products, whole @ vectors, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(own, np.einsum("nii->ni", whole), rtol=1e-12)
    first = {name: float(value[0]) for name, value in few.items()}
    np.testing.assert_allclose(whole[0], mass_matrix(robot, first), rtol=1e-8, atol=1e-10)


def test_small_robot_is_compared_as_a_whole():
    assert probe_vectors(np.ones((2, MAX_WHOLE_DOFS))) is None


@pytest.mark.parametrize("ending", ["xml", "urdf"])
def test_mass_a_little_off_is_found_in_a_large_robot(tmp_path, ending):
    robot = tree(MANY)
    write(robot, tmp_path)
    file = tmp_path / f"robot.{ending}"
    assert {check.name: check.passed for check in _parity(tmp_path, robot)}[f"{file.name}: parity in MuJoCo"]
    tag, key = ("body", 'mass="') if ending == "xml" else ("link", '<mass value="')
    heavier(file, f'<{tag} name="l{MANY // 2}".*?{key}', 1e-5)
    parity = {check.name: check for check in _parity(tmp_path, robot)}[f"{file.name}: parity in MuJoCo"]
    assert not parity.passed
    assert f'joint "l{MANY // 2}_joint"' in {finding.element for finding in parity.findings}
    assert "mass matrix" in parity.detail


def _parity(folder, robot):
    return [problem for problem in checked(folder, robot, plan_of()) if problem.code == "C-PARITY"]


def test_second_engine_is_not_asked_of_too_many_dofs(tmp_path):
    pytest.importorskip("pinocchio")
    robot = tree(MANY)
    write(robot, tmp_path)
    checks = _parity(tmp_path, robot)
    assert [check.name for check in checks] == ["robot.xml: parity in MuJoCo", "robot.urdf: parity in MuJoCo"]
    assert "Pinocchio is skipped beyond 100 dofs" in checks[1].detail


def test_few_joints_are_swept_in_full_and_many_in_fewer_steps():
    assert reach._joints_and_steps(list(range(400)), 401) == (list(range(400)), reach.STEPS)
    joints, steps = reach._joints_and_steps(list(range(999)), 1000)
    assert (len(joints), steps) == (999, reach.MIN_STEPS)
    joints, steps = reach._joints_and_steps(list(range(4999)), 5000)
    assert len(joints) * steps * 5000 <= reach.MAX_BODY_POSES
    assert (joints[0], joints[-1] > 4900, steps) == (0, True, reach.MIN_STEPS)


def _spheres(robot):
    """Each link a ball that touches few of the others."""
    return replace(robot, links=tuple(replace(link, shapes=(ball(0.01),)) for link in robot.links))


@pytest.mark.parametrize("changed", [False, True])
def test_pairs_that_are_looked_at_are_those_that_matter(tmp_path, changed):
    robot = _spheres(tree(12))
    geometry = geometry_of(robot, exclude=[["l5", "l9"], ["l1", "l11"]])
    model = compiled(exported(robot, geometry))
    if changed:
        model.geom_contype[3], model.geom_conaffinity[3] = 0, 2
        model.geom_conaffinity[7] = 4
    built = CompiledModel(tmp_path / "robot.xml", model, Written(robot, geometry=geometry))
    (check,) = contact_filter.check(built)
    colliders = contact_filter._colliders(built, geometry)
    outside = {int(number) for number in model.exclude_signature}
    excluded = {(exclude.link_a, exclude.link_b) for exclude in geometry.excludes}
    wrong, pairs = [], 0
    for (first, own), (second, theirs) in combinations(colliders, 2):
        if never_collide(model, *(int(model.geom_bodyid[geoms[0]]) for geoms in (own, theirs))):
            continue
        pairs += 1
        wanted = geometry.self_contact and (first, second) not in excluded
        if (contact_filter._may_collide(model, own, theirs, outside) != wanted).any():
            wrong.append(f'exclude "{first}" "{second}"')
    assert check.detail.startswith(f"which shapes may collide, for {pairs} pair")
    assert check.value == len(wrong)
    assert bool(wrong) == changed
    assert [finding.element for finding in check.findings] == wrong[: len(check.findings)]


def test_pairs_of_a_urdf_are_in_the_order_of_its_links():
    robot = _spheres(tree(12))
    geometry = geometry_of(robot, exclude=[["l5", "l9"], ["l1", "l11"]])
    pairs, _ = excluded_pairs(Written(robot, geometry=geometry))
    place = {link.name: number for number, link in enumerate(robot.links)}
    order = [(place[a], place[b]) for a, b in pairs]
    assert order == sorted(order)
    joined = {frozenset((joint.parent, joint.child)) for joint in robot.joints}
    assert joined <= {frozenset(pair) for pair in pairs}


@pytest.mark.slow
@pytest.mark.parametrize("make", [chain, tree])
def test_thousand_links_take_seconds_and_little_memory(tmp_path, make):
    for name, links in (("warm", 3), ("large", 1000)):
        robot = make(links)
        write(robot, tmp_path / name)
        assert read_robot_json((tmp_path / name / "robot.json").read_bytes()).written.robot.name == robot.name
    places = [str(tmp_path / folder) for folder in ("large", "warm")]
    command = [sys.executable, "-m", "tests.support.measured_checks", *places]
    # What else the machine does is in the processor's time too: of three runs one must be quick enough.
    runs = (_run(command) for _ in range(3))
    figures = next((run for run in runs if _is_quick(run, make)), None) or _run(command)
    # MuJoCo reads no MJCF of bodies in bodies 1,000 deep; the URDF is compared whole.
    assert all(text.endswith(("XML", "compiles")) for text in figures["failed"]), figures
    # On a fast, quiet machine it is 3 s for both; of the chain's, MuJoCo's own compiler takes more than two.
    # Twice as much is a slow machine; pairs of links would take minutes.
    assert _is_quick(figures, make), figures
    assert figures["memory"] < 0.5e9


def _is_quick(figures, make):
    own = figures["seconds"] - figures["compiles"]
    return bool(own < (3.0 if make is chain else 6.0) and figures["seconds"] < 8.0)


def _run(command):
    here = Path(__file__).parents[3]
    done = subprocess.run(command, capture_output=True, text=True, check=True, cwd=here)
    return json.loads(done.stdout.splitlines()[-1])
