"""Merging and moving inertias, against solids cut in pieces and against point masses."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from stages.robot.inertia import is_physical, merged, moved
from stages.robot.model import Inertial, frozen

quats = st.tuples(*[st.floats(-1, 1)] * 4).filter(lambda q: sum(v * v for v in q) > 1e-3)
positions = st.tuples(*[st.floats(-2, 2)] * 3)


def box(mass: float, size: tuple[float, float, float], com: tuple[float, float, float]) -> Inertial:
    x, y, z = size
    moments = mass / 12 * np.array([y * y + z * z, x * x + z * z, x * x + y * y])
    return Inertial(mass, frozen(com), frozen(np.diag(moments)))


def pose(quat: tuple[float, ...], position: tuple[float, ...]) -> np.ndarray:
    out = np.eye(4)
    out[:3, :3] = Rotation.from_quat(np.array(quat)).as_matrix()
    out[:3, 3] = position
    return out


def test_two_halves_of_a_box_are_the_box() -> None:
    halves = [box(0.5, (1, 2, 3), (-0.5, 0, 0)), box(0.5, (1, 2, 3), (0.5, 0, 0))]
    whole = merged(halves)
    expected = box(1.0, (2, 2, 3), (0, 0, 0))
    assert whole.mass == 1.0
    assert np.allclose(whole.com, 0, atol=1e-15)
    assert np.allclose(whole.inertia, expected.inertia, rtol=1e-14)


@given(st.lists(st.tuples(st.floats(0.01, 5), positions, quats), min_size=1, max_size=6))
def test_kinetic_energy_of_the_merged_body_is_the_sum(bodies: list) -> None:
    placed = [moved(box(m, (0.1, 0.2, 0.3), (0.1, 0, 0)), pose(q, p)) for m, p, q in bodies]
    whole = merged(placed)
    omega, velocity = np.array([0.3, -1.2, 0.7]), np.array([1.0, 0.4, -0.2])

    def energy(body: Inertial) -> float:
        at_com = velocity + np.cross(omega, body.com)
        return 0.5 * (body.mass * at_com @ at_com + omega @ body.inertia @ omega)

    assert abs(energy(whole) - sum(map(energy, placed))) < 1e-12 * max(1.0, energy(whole))
    assert is_physical(whole)


@given(quats, positions)
def test_moving_keeps_the_principal_moments(quat: tuple[float, ...], position: tuple[float, ...]) -> None:
    body = box(2.0, (0.1, 0.2, 0.4), (0.3, 0, 0))
    there = moved(body, pose(quat, position))
    assert np.allclose(np.linalg.eigvalsh(there.inertia), np.linalg.eigvalsh(body.inertia), rtol=1e-12)


def test_a_reflection_mirrors_products_of_inertia() -> None:
    body = Inertial(1.0, frozen([0.1, 0.2, 0.3]), frozen([[2, 0.1, 0.2], [0.1, 3, 0.3], [0.2, 0.3, 4]]))
    there = moved(body, np.diag([-1.0, 1.0, 1.0, 1.0]))
    assert np.allclose(there.com, [-0.1, 0.2, 0.3])
    assert np.allclose(there.inertia, [[2, -0.1, -0.2], [-0.1, 3, 0.3], [-0.2, 0.3, 4]])


def test_massless_parts_change_nothing() -> None:
    body = box(1.0, (1, 2, 3), (0.5, 0, 0))
    ghost = Inertial(0.0, frozen([9, 9, 9]), frozen(np.zeros((3, 3))))
    assert np.array_equal(merged([body, ghost]).inertia, merged([body]).inertia)
    assert merged([ghost]).mass == 0.0
