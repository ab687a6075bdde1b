"""Joints in the user's own terms: a zero and a direction of each joint change no physics.

The untouched robot is the oracle. `robot.json` has the map from each new value to the mate's own; through it
poses, inertia, gravity, limits, followers and loops of both files are those of the untouched robot's.
"""

import json
import tempfile
from pathlib import Path

import mujoco
import numpy as np
import pytest
from hypothesis import strategies as st
from lxml import etree

from linkwright.stages.robot.motion.start_pose import starting_point
from tests.support.building import plan_of, robot_of, write
from tests.support.drawn import any_document, each
from tests.support.engines import Mujoco, Pinocchio
from tests.support.parity import same
from tests.support.robots import some_values

pytestmark = pytest.mark.e2e

Counts = dict[str, tuple[int, float]]


def counts_of(robot_json):
    """By dof, the sign and zero that robot.json gives: mate = zero + sign · value."""
    table = json.loads(robot_json)
    dofs = [dof for joint in (*table["joints"], *table["loops"]) for dof in joint["dofs"]]
    mates = {dof["name"]: dof["mate"] for dof in dofs if dof["kind"] in ("turn", "slide")}
    return {name: (mate["sign"], mate["zero"]) for name, mate in mates.items()}


def chosen(robot, seed):
    """A zero, a direction, both or neither for each turn and slide, those of loops too."""
    random = np.random.default_rng(seed)
    dofs = [*robot.dofs, *(dof for loop in robot.loops for dof in loop.dofs)]
    keys = {}
    for dof in dofs:
        if dof.kind in ("turn", "slide"):
            both = {"zero": float(random.uniform(-1, 1)), "invert": bool(random.integers(2))}
            keys[dof.name] = {key: value for key, value in both.items() if random.random() < 0.7}
    return {name: values for name, values in keys.items() if values}


def alike(document, seed, zero):
    plain = robot_of(document, plan_of(zero=zero))
    wanted = chosen(plain, seed)
    plan = plan_of(zero=zero, joints=wanted)
    counted = robot_of(document, plan)
    names = [dof.name for dof in plain.dofs]
    assert [dof.name for dof in counted.dofs] == names
    with tempfile.TemporaryDirectory() as first_folder, tempfile.TemporaryDirectory() as other:
        old = write(plain, Path(first_folder))
        new = write(counted, Path(other), plan)
        engines = [
            (Pinocchio(old.files["robot.urdf"]), Pinocchio(new.files["robot.urdf"])),
            (
                Mujoco(Path(first_folder) / "robot.xml", balls(plain)),
                Mujoco(Path(other) / "robot.xml", balls(counted)),
            ),
        ]
    before, after = counts_of(old.files["robot.json"]), counts_of(new.files["robot.json"])
    for name, keys in wanted.items():
        # A pose is told by the mate's own value, whatever `zero` says of the others.
        assert after[name] == pytest.approx(
            (-1 if keys.get("invert") else 1, keys.get("zero", before[name][1])), abs=1e-12
        )
    random = np.random.default_rng(seed)
    signs = np.concatenate([[after[n][0]] if n in after else np.ones(3) for n in names] or [[]])
    for _ in range(2):
        q = some_values(plain, random)
        moved = {n: after[n][0] * (before[n][1] + v - after[n][1]) if n in after else v for n, v in q.items()}
        for left, right in engines:
            poses, moved_poses = left.poses(q), right.poses(moved)
            for link in plain.links:
                same(moved_poses[link.name], poses[link.name])
            if not names:
                continue
            same(right.mass_matrix(moved, names), left.mass_matrix(q, names) * np.outer(signs, signs))
            same(right.gravity(moved, names), left.gravity(q, names) * signs)
        left, right = engines[1]
        if names:
            # A loop's own joint stands in the MJCF where no equality can replace it, with a value of its own.
            carried = {n: float(random.uniform(-1, 1)) for n in after if n not in q and has_joint(left, n)}
            there = {n: after[n][0] * (before[n][1] + v - after[n][1]) for n, v in carried.items()}
            held(left, right, q | carried, moved | there)
        mimicked(old.files["robot.urdf"], new.files["robot.urdf"], q, before, after)
    limited(plain, counted, before, after)


def has_joint(engine, name):
    return mujoco.mj_name2id(engine.model, mujoco.mjtObj.mjOBJ_JOINT, name) >= 0


def balls(robot):
    """The pose in which the MJCF's bodies stand, which a ball's value there counts from."""
    return {name: value for name, value in starting_point(robot).items() if isinstance(value, tuple)}


def held(left, right, q, moved):
    """Every equality is off by as much, whichever values count it."""

    def off(engine, values):
        model, data = engine.model, engine.data
        engine._set(values)
        mujoco.mj_makeConstraint(model, data)
        rows = data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY
        gaps = {}
        for number, value in zip(data.efc_id[rows], data.efc_pos[rows], strict=True):
            name = f"{model.equality(int(number)).name}/{number}"
            gaps[name] = float(np.hypot(gaps.get(name, 0.0), value))
        return gaps

    before, after = off(left, q), off(right, moved)
    assert after.keys() == before.keys()
    for name, value in before.items():
        assert abs(after[name] - value) < 1e-9 * max(1.0, value)


def mimicked(old, new, q, before, after):
    """A follower's value, by the URDF's own <mimic>, is the same value of its mate."""

    def followed(urdf, counts):
        by_key = {}
        for joint in etree.fromstring(urdf).iterfind("joint"):
            mimic = joint.find("mimic")
            if mimic is None or joint.get("name") not in counts:
                continue
            sign, zero = counts[mimic.get("joint")]
            mate = before[mimic.get("joint")]
            driver = sign * (mate[1] + q[mimic.get("joint")] - zero)
            value = float(mimic.get("multiplier", 1)) * driver + float(mimic.get("offset", 0))
            sign, zero = counts[joint.get("name")]
            by_key[joint.get("name")] = zero + sign * value
        return by_key

    expected, other = followed(old, before), followed(new, after)
    assert other == pytest.approx(expected, rel=1e-9, abs=1e-9)


def limited(plain, counted, before, after):
    """The same range of the mate's own value, and the same saved pose."""
    for first, other in zip(plain.dofs, counted.dofs, strict=True):
        if first.name not in after:
            continue
        ranges = []
        for dof, (sign, zero) in ((first, before[first.name]), (other, after[first.name])):
            low, high = dof.limits.interval
            ranges.append([*sorted((zero + sign * low, zero + sign * high)), zero + sign * dof.saved])
        assert ranges[1] == pytest.approx(ranges[0], abs=1e-9)


@pytest.mark.parametrize(("loops", "count"), [(False, 8), pytest.param(True, 25, marks=pytest.mark.slow)])
def test_a_zero_and_a_direction_change_no_physics(loops, count):
    zeros = st.sampled_from(["mate", "saved"])
    each(alike, count, any_document(loops=loops), st.integers(0, 1000), zeros)
