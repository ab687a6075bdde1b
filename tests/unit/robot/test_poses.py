"""Rotations and poses against scipy and themselves; limits of values that are counted in another way."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from linkwright.stages.robot.model.dofs import LimitOrigin, Limits
from linkwright.stages.robot.model.poses import (
    from_parts,
    inverse,
    motion,
    quat_from_rotation,
    rotation_from_quat,
    rotation_from_rpy,
    rpy_from_rotation,
    turn,
)

angles = st.floats(-math.pi, math.pi)
quats = st.tuples(*[st.floats(-1, 1)] * 4).filter(lambda q: sum(v * v for v in q) > 1e-3)


def rotation(quat):
    return Rotation.from_quat(np.array(quat), scalar_first=True).as_matrix()


@given(quats)
def test_rpy_and_quaternion_give_the_rotation_back(quat):
    r = rotation(quat)
    assert np.abs(rotation_from_rpy(rpy_from_rotation(r)) - r).max() < 1e-14
    q = quat_from_rotation(r)
    assert q[0] >= 0
    assert abs(np.linalg.norm(q) - 1) < 1e-15
    assert np.abs(rotation_from_quat(q) - r).max() < 5e-15


@given(angles, st.sampled_from([math.pi / 2, -math.pi / 2]), st.floats(-1e-5, 1e-5), angles)
def test_rpy_is_exact_at_and_near_a_right_angle(roll, pitch, off, yaw):
    r = rotation_from_rpy((roll, pitch + off, yaw))
    assert np.abs(rotation_from_rpy(rpy_from_rotation(r)) - r).max() < 1e-12


@given(angles, angles, angles)
def test_rpy_is_extrinsic_xyz(roll, pitch, yaw):
    expected = Rotation.from_euler("xyz", [roll, pitch, yaw]).as_matrix()
    assert np.abs(rotation_from_rpy((roll, pitch, yaw)) - expected).max() < 1e-14


@pytest.mark.parametrize("axis", range(3))
def test_half_turns_have_a_quaternion(axis):
    r = turn(np.eye(3)[axis], math.pi)
    assert np.abs(rotation_from_quat(quat_from_rotation(r)) - r).max() < 1e-15


@given(quats, angles)
def test_turn_is_scipys_rotation_vector(quat, angle):
    axis = rotation(quat)[:, 0]
    assert np.abs(turn(axis, angle) - Rotation.from_rotvec(axis * angle).as_matrix()).max() < 1e-14


@given(quats, st.tuples(*[st.floats(-3, 3)] * 3))
def test_inverse_cancels(quat, position):
    pose = from_parts(rotation(quat), np.array(position))
    assert np.abs(inverse(pose) @ pose - np.eye(4)).max() < 1e-14


def test_backwards_motion_is_motion_of_the_negated_value():
    axis = np.array([0.0, 0.6, 0.8])
    for kind in ("revolute", "prismatic"):
        assert np.allclose(inverse(motion(kind, axis, 0.3)), motion(kind, axis, -0.3), atol=1e-15)
        assert np.allclose(motion(kind, axis, -0.3), motion(kind, -axis, 0.3), atol=1e-15)


# Multiples of 1/8: sums of them are exact.
EIGHTHS = st.integers(-80, 80).map(lambda number: number / 8)


ENDS = st.none() | EIGHTHS


RANGES = st.tuples(ENDS, ENDS).filter(lambda ends: None in ends or ends[0] <= ends[1])


SIGNS = st.sampled_from([-1, 1])


@given(RANGES, SIGNS, EIGHTHS)
def test_mapped_and_mapped_back_limits_are_themselves(ends, sign, shift):
    limits = Limits(*ends)
    assert limits.mapped(sign, shift).mapped(sign, -sign * shift) == limits


@given(RANGES, st.sampled_from([-4.0, -1.0, -0.5, 0.5, 1.0, 2.0]), EIGHTHS, EIGHTHS)
def test_mapped_limits_contain_the_mapped_values(ends, factor, shift, value):
    limits = Limits(*ends)
    assert limits.mapped(factor, shift).contains(factor * value + shift) == limits.contains(value)


@given(RANGES, EIGHTHS)
def test_factor_of_zero_leaves_one_value(ends, shift):
    assert Limits(*ends).mapped(0, shift) == Limits(shift, shift)


def test_mapped_limits_keep_their_origin():
    origin = LimitOrigin(doubts=("typed twice",))
    assert Limits(0.0, None, origin=origin).mapped(-1).origin == origin
