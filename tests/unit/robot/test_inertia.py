"""Inertias moved, merged and of solids, against cut solids, point masses, closed forms and trimesh."""

import math

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from linkwright.stages.robot.dynamics.inertia import (
    is_physical,
    merged,
    moved,
    primitive_inertial,
    primitive_volume,
    principal_axes,
    solid_inertia,
)
from linkwright.stages.robot.model.robot import Inertial, frozen

quats = st.tuples(*[st.floats(-1, 1)] * 4).filter(lambda q: sum(v * v for v in q) > 1e-3)
positions = st.tuples(*[st.floats(-2, 2)] * 3)


def box(mass, size, com):
    x, y, z = size
    moments = mass / 12 * np.array([y * y + z * z, x * x + z * z, x * x + y * y])
    return Inertial(mass, frozen(com), frozen(np.diag(moments)))


def pose(quat, position):
    out = np.eye(4)
    out[:3, :3] = Rotation.from_quat(np.array(quat)).as_matrix()
    out[:3, 3] = position
    return out


def test_two_halves_of_a_box_are_the_box():
    whole = merged([box(0.5, (1, 2, 3), (-0.5, 0, 0)), box(0.5, (1, 2, 3), (0.5, 0, 0))])
    same(whole, box(1.0, (2, 2, 3), (0, 0, 0)), 3.0, rel=1e-14)


@given(st.lists(st.tuples(st.floats(0.01, 5), positions, quats), min_size=1, max_size=6))
def test_kinetic_energy_of_the_merged_body_is_the_sum(bodies):
    placed = [moved(box(m, (0.1, 0.2, 0.3), (0.1, 0, 0)), pose(q, p)) for m, p, q in bodies]
    whole = merged(placed)
    omega, velocity = np.array([0.3, -1.2, 0.7]), np.array([1.0, 0.4, -0.2])

    def energy(body):
        at_com = velocity + np.cross(omega, body.com)
        return 0.5 * (body.mass * at_com @ at_com + omega @ body.inertia @ omega)

    assert abs(energy(whole) - sum(map(energy, placed))) < 1e-12 * max(1.0, energy(whole))
    assert is_physical(whole)


@given(quats, positions)
def test_moving_keeps_the_principal_moments(quat, position):
    body = box(2.0, (0.1, 0.2, 0.4), (0.3, 0, 0))
    there = moved(body, pose(quat, position))
    assert np.allclose(np.linalg.eigvalsh(there.inertia), np.linalg.eigvalsh(body.inertia), rtol=1e-12)


def test_reflection_mirrors_products_of_inertia():
    body = Inertial(1.0, frozen([0.1, 0.2, 0.3]), frozen([[2, 0.1, 0.2], [0.1, 3, 0.3], [0.2, 0.3, 4]]))
    there = moved(body, np.diag([-1.0, 1.0, 1.0, 1.0]))
    assert np.allclose(there.com, [-0.1, 0.2, 0.3])
    assert np.allclose(there.inertia, [[2, -0.1, -0.2], [-0.1, 3, 0.3], [-0.2, 0.3, 4]])


def test_massless_parts_change_nothing():
    body = box(1.0, (1, 2, 3), (0.5, 0, 0))
    ghost = Inertial(0.0, frozen([9, 9, 9]), frozen(np.zeros((3, 3))))
    assert np.array_equal(merged([body, ghost]).inertia, merged([body]).inertia)
    assert merged([ghost]).mass == 0.0


def same(first, other, scale, rel=1e-12):
    assert first.mass == pytest.approx(other.mass, rel=rel)
    assert np.abs(first.com - other.com).max() < rel * scale
    assert np.abs(first.inertia - other.inertia).max() < rel * other.mass * scale**2


def test_solid_box_anywhere_has_the_closed_form():
    mesh = trimesh.creation.box((0.1, 0.2, 0.4))
    placed = pose((0.3, -0.5, 0.1, 0.8), (3.0, -2.0, 1.0))
    vertices = mesh.vertices @ placed[:3, :3].T + placed[:3, 3]
    expected = moved(box(0.1 * 0.2 * 0.4 * 700, (0.1, 0.2, 0.4), (0, 0, 0)), placed)
    same(solid_inertia(vertices, mesh.faces, 700), expected, 0.4, rel=1e-11)
    same(solid_inertia(vertices, mesh.faces[:, ::-1], 700), expected, 0.4, rel=1e-11)


def test_solid_corner_tetrahedron_has_the_closed_form():
    # Corners 0, e_x, e_y, e_z: V = 1/6, c = 1/4, ∫x² = 1/60, ∫xy = 1/120.
    vertices = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    triangles = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    spread = np.full((3, 3), 1 / 120 - 1 / 96) + np.eye(3) / 120
    expected = Inertial(1.0, frozen([0.25] * 3), frozen(6 * (np.trace(spread) * np.eye(3) - spread)))
    same(solid_inertia(vertices, triangles, 6), expected, 1.0, rel=1e-14)


def test_hollow_solid_of_curved_faces_is_what_trimesh_says():
    outer = trimesh.creation.capsule(height=0.3, radius=0.1, count=[12, 12])
    hole = trimesh.creation.icosphere(subdivisions=1, radius=0.05)
    hole.apply_translation([0.01, 0.02, 0.1])
    hole.invert()
    mesh = outer + hole
    there = trimesh.triangles.mass_properties(mesh.triangles, density=900.0)
    expected = Inertial(there["mass"], frozen(there["center_mass"]), frozen(there["inertia"]))
    assert abs(expected.inertia[0, 1]) > 1e-7
    same(solid_inertia(mesh.vertices, mesh.faces, 900), expected, 0.3)


@pytest.mark.parametrize("triangles", [np.zeros((0, 3), dtype=int), np.array([[0, 1, 2], [0, 2, 1]])])
def test_surface_that_encloses_nothing_is_refused(triangles):
    with pytest.raises(ValueError, match="encloses nothing"):
        solid_inertia(np.eye(3), triangles, 1000)


@pytest.mark.parametrize(("kind", "size", "moments", "volume"), [
    ("box", (0.1, 0.2, 0.4), np.array([0.2, 0.17, 0.05]) / 12, 0.008),
    ("sphere", (0.2,), [2 / 5 * 0.04] * 3, 4 / 3 * math.pi * 0.008),
    ("cylinder", (0.2, 0.6), [(3 * 0.04 + 0.36) / 12] * 2 + [0.04 / 2], math.pi * 0.04 * 0.6),
    ("capsule", (0.2, 0.0), [2 / 5 * 0.04] * 3, 4 / 3 * math.pi * 0.008),
])  # fmt: skip
def test_primitives_have_the_textbook_moments(kind, size, moments, volume):
    solid = primitive_inertial(kind, size, 5)
    same(solid, Inertial(5, frozen([0, 0, 0]), frozen(5 * np.diag(moments))), 0.4)
    assert primitive_volume(kind, size) == pytest.approx(volume)


def test_capsule_is_the_limit_of_its_meshes():
    mass, radius, length = 2.0, 0.1, 0.3
    capsule = primitive_inertial("capsule", (radius, length), mass)
    errors = []
    for count in (32, 64):
        mesh = trimesh.creation.capsule(height=length, radius=radius, count=[count, count])
        mesh.apply_translation(-mesh.bounds.mean(axis=0))
        solid = solid_inertia(mesh.vertices, mesh.faces, mass / mesh.volume)
        volume = abs(mesh.volume - primitive_volume("capsule", (radius, length)))
        errors.append([np.abs(solid.inertia - capsule.inertia).max(), volume])
    # The error of an inscribed mesh goes with the square of its step: what is left is none.
    assert np.divide(*errors) == pytest.approx([4, 4], abs=0.3)
    assert errors[1][0] < 1e-2 * capsule.inertia.max()
    assert is_physical(capsule)


moments = st.floats(0.1, 10)


@given(moments, moments, moments, quats, st.sampled_from([1e-14, 1e-8, 1.0, 1e6]))
def test_principal_axes_are_a_rotation_and_give_the_tensor_again(a, b, c, quat, size):
    turned = Rotation.from_quat(np.array(quat)).as_matrix()
    tensor = size * turned @ np.diag([a, b, c]) @ turned.T
    tensor = (tensor + tensor.T) / 2
    principal, axes = principal_axes(tensor)
    back = axes @ np.diag(principal) @ axes.T
    assert np.allclose(back, tensor, rtol=0, atol=1e-13 * np.abs(tensor).max())
    assert np.allclose(axes.T @ axes, np.eye(3), rtol=0, atol=1e-14)
    assert np.linalg.det(axes) > 0
    assert np.allclose(sorted(principal), size * np.array(sorted([a, b, c])), rtol=1e-12)


@pytest.mark.parametrize("diagonal", [(1.0, 1.0, 1.0), (3.0, 1.0, 2.0), (2.0, 2.0, 1.0), (0.0, 0.0, 0.0)])
def test_diagonal_tensor_keeps_its_axes(diagonal):
    noise = 1e-17 * max(diagonal) * (np.ones((3, 3)) - np.eye(3))
    principal, axes = principal_axes(np.diag(diagonal) + noise)
    assert (principal == diagonal).all()
    assert (axes == np.eye(3)).all()


def test_equal_moments_leave_no_axis_to_chance():
    """A rod that lies askew: what differs in the last digit leads to the same axes."""
    along = np.array([1.0, 2.0, -1.5]) / np.linalg.norm([1.0, 2.0, -1.5])
    rod = np.eye(3) - 0.9 * np.outer(along, along)
    _, axes = principal_axes(rod)
    _, nearly = principal_axes(rod * (1 + 2e-16))
    assert np.allclose(axes, nearly, rtol=0, atol=1e-14)
