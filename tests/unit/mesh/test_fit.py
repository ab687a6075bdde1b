"""Fitted primitives: exact ones are found again, in any pose and any order of their triangles."""

import math

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from linkwright.stages.formats.meshes.surface import Surface, transform_surface
from linkwright.stages.mesh.fit import CHEAPEST, allowed_kinds, best_primitive, fit_kind, fits
from linkwright.stages.mesh.measure import MeasuredPart, measure
from linkwright.stages.mesh.surfaces.pieces import placed, signed_distance
from linkwright.stages.robot.model.robot import Primitive, frozen
from linkwright.stages.targets.engines import shape_limits
from tests.support.cases import mostly_slow
from tests.support.solids import box, of_mesh

LENGTHS = st.floats(0.002, 0.5)
SEEDS = st.integers(0, 10_000)


def some_pose(seed, mirrored=False):
    pose = np.eye(4)
    pose[:3, :3] = Rotation.random(random_state=seed).as_matrix() @ np.diag([1, 1, -1 if mirrored else 1])
    pose[:3, 3] = np.random.default_rng(seed).uniform(-0.3, 0.3, 3)
    return pose


def gear(teeth=24, root=0.028, tip=0.030, width=0.01):
    """A prism about z with teeth."""
    angles = np.arange(4 * teeth) * (2 * math.pi / (4 * teeth))
    radii = np.tile([root, root, tip, tip], teeth)
    x, y, count = radii * np.cos(angles), radii * np.sin(angles), 4 * teeth
    here = np.arange(count)
    there = (here + 1) % count
    low, high = np.zeros(count, dtype=int), np.ones(count, dtype=int)
    points = np.concatenate([np.c_[x, y, low], np.c_[x, y, width * high], [[0, 0, 0], [0, 0, width]]])
    faces = [np.c_[here, there, there + count], np.c_[here, there + count, here + count]]
    faces += [np.c_[there, here, 2 * count * high]]
    faces += [np.c_[here + count, there + count, (2 * count + 1) * high]]
    return of_mesh(trimesh.Trimesh(points, np.concatenate(faces), process=False))


def bracket():
    """Two plates at a right angle, and a pin: no symmetry."""
    corners = (0.08, 0.05, 0.004), (0.004, 0.05, 0.03)
    plates = [trimesh.creation.box(bounds=[(0, 0, 0), corner]) for corner in corners]
    pin = trimesh.creation.cylinder(0.005, 0.02, sections=24)
    return of_mesh(trimesh.util.concatenate([*plates, pin.apply_translation([0.06, 0.011, 0.012])]))


GEAR, BRACKET, ROD = gear(), bracket(), of_mesh(trimesh.creation.cylinder(0.02, 0.05))


def difference(first, second, size):
    """The largest difference of the distances from two primitives, at points around them [m]."""
    points = first.link_from_shape[:3, 3] + np.random.default_rng(0).uniform(-size, size, (500, 3))
    return float(np.abs(signed_distance(first, points) - signed_distance(second, points)).max())


@settings(max_examples=8, deadline=None)
@given(LENGTHS, LENGTHS, LENGTHS, SEEDS)
def test_box_in_any_pose_is_found_again(x, y, z, seed):
    fitted = fit_kind("box", of_mesh(trimesh.creation.box((x, y, z), some_pose(seed))))
    assert sorted(fitted.size) == pytest.approx(sorted((x, y, z)), rel=1e-9)
    exact = Primitive("box", (x, y, z), frozen(some_pose(seed)))
    assert difference(fitted, exact, max(x, y, z)) < 1e-9 * max(x, y, z) + 2e-12


@settings(max_examples=6, deadline=None)
@given(LENGTHS, LENGTHS, st.integers(12, 64), SEEDS)
def test_radius_of_a_cylinder_is_between_its_polygons_circles(radius, length, sections, seed):
    pose = some_pose(seed)
    mesh = trimesh.creation.cylinder(radius, length, sections=sections, transform=pose)
    fitted = fit_kind("cylinder", of_mesh(mesh))
    assert radius * math.cos(math.pi / sections) - 1e-9 <= fitted.size[0] <= radius + 1e-9
    assert fitted.size[1] == pytest.approx(length, rel=1e-9)
    assert abs(fitted.link_from_shape[:3, 2] @ pose[:3, 2]) == pytest.approx(1, abs=1e-12)
    assert np.linalg.norm(fitted.link_from_shape[:3, 3] - pose[:3, 3]) < 1e-8 * (radius + length)


@settings(max_examples=4, deadline=None)
@given(LENGTHS, SEEDS)
def test_sphere_and_capsule_in_any_pose_are_found_again(radius, seed):
    pose = some_pose(seed)
    sphere = fit_kind("sphere", of_mesh(trimesh.creation.icosphere(3, radius).apply_transform(pose)))
    assert 0.985 * radius < sphere.size[0] <= radius * (1 + 1e-9)
    assert np.linalg.norm(sphere.link_from_shape[:3, 3] - pose[:3, 3]) < 1e-6 * radius
    mesh = trimesh.creation.capsule(3 * radius, radius, count=[32, 32]).apply_transform(pose)
    capsule = fit_kind("capsule", of_mesh(mesh))
    assert 0.985 * radius < capsule.size[0] <= radius * (1 + 1e-9)
    assert capsule.size[1] == pytest.approx(3 * radius, rel=0.01)
    assert np.linalg.norm(capsule.link_from_shape[:3, 3] - mesh.bounds.mean(axis=0)) < 0.01 * radius


@pytest.mark.parametrize(
    ("surface", "kind"),
    [
        (box(0.2, 0.15, 0.003), "box"),
        (box(0.03, 0.03, 0.03), "box"),
        (ROD, "cylinder"),
        (of_mesh(trimesh.creation.cylinder(0.02, 0.001)), "cylinder"),
        (of_mesh(trimesh.creation.icosphere(radius=0.03)), "sphere"),
        (of_mesh(trimesh.creation.capsule(0.06, 0.01)), "capsule"),
        (GEAR, "cylinder"),
    ],
    ids=["plate", "cube", "rod", "disc", "ball", "capsule", "gear"],
)
@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_fittest_kind_is_that_of_the_part(surface, kind, seed):
    assert best_primitive(transform_surface(surface, some_pose(seed))).kind == kind


def test_radius_of_a_gear_is_between_its_root_and_its_tip():
    radius, length = fit_kind("cylinder", GEAR).size
    assert 0.028 < radius < 0.030 + 1e-9
    assert length == pytest.approx(0.01, abs=1e-9)


def test_noise_hardly_moves_a_fit():
    mesh = trimesh.creation.box((0.1, 0.06, 0.03)).subdivide().subdivide().subdivide()
    mesh.vertices += np.random.default_rng(3).normal(scale=1e-4, size=mesh.vertices.shape)
    fitted = fit_kind("box", of_mesh(mesh))
    assert fitted.size == pytest.approx((0.1, 0.06, 0.03), abs=8e-4)
    assert fitted.link_from_shape[:3, :3].tolist() == np.eye(3).tolist()
    assert fitted.link_from_shape[:3, 3].tolist() == pytest.approx([0, 0, 0], abs=4e-4)


@pytest.mark.parametrize("angle", [0.4, -0.3])
def test_fits_within_half_a_degree_of_the_axes_are_along_them(angle):
    turn = np.eye(4)
    turn[:3, :3] = Rotation.from_euler("xyz", [angle, 0, 0], degrees=True).as_matrix()
    fitted = fit_kind("box", transform_surface(box(0.1, 0.06, 0.03), turn))
    assert fitted.link_from_shape[:3, :3].tolist() == np.eye(3).tolist()
    rod = fit_kind("cylinder", transform_surface(of_mesh(trimesh.creation.cylinder(0.01, 0.1)), turn))
    assert rod.link_from_shape[:3, 2].tolist() == [0, 0, 1]


@pytest.mark.parametrize(("seed", "mirrored"), [(11, False), (12, True)])
@pytest.mark.parametrize(
    ("surface", "kind"),
    # A gear has as many best boxes as it has symmetries.
    mostly_slow([(GEAR, "cylinder"), *((BRACKET, kind) for kind in CHEAPEST), (GEAR, "sphere")], 3),
)
def test_moved_or_mirrored_part_in_any_order_has_the_moved_fit(surface, kind, seed, mirrored):
    # Turned once already, so that no direction is near a coordinate axis.
    surface = transform_surface(surface, some_pose(100))
    pose = some_pose(seed, mirrored)
    rng = np.random.default_rng(seed)
    order = rng.permutation(len(surface.vertices))
    there = transform_surface(surface, pose)
    triangles = np.argsort(order)[there.triangles][rng.permutation(len(there.triangles))]
    there = Surface(there.vertices[order], np.roll(triangles, 1, axis=1))
    assert difference(fit_kind(kind, there), placed(fit_kind(kind, surface), pose), 0.1) < 1e-6


def test_cheapest_kinds_come_first_and_mjx_gets_no_cylinder():
    assert [fit.primitive.kind for fit in fits(BRACKET)] == ["sphere", "capsule", "box", "cylinder"]
    without = allowed_kinds(shape_limits(["mjx"]))
    assert [fit.primitive.kind for fit in fits(BRACKET, without)] == ["sphere", "capsule", "box"]


def test_lengths_of_the_user_are_kept_and_the_others_fitted():
    ball = fit_kind("sphere", ROD, (0.02,))
    assert ball.size == (0.02,)
    assert ball.link_from_shape[:3, 3].tolist() == pytest.approx([0, 0, 0], abs=1e-9)
    assert fit_kind("cylinder", ROD, (0.01, None)).size == pytest.approx((0.01, 0.05))
    assert fit_kind("box", ROD, (None, 0.1, None)).size == pytest.approx((0.04, 0.1, 0.05))


def test_flat_part_has_no_fit():
    flat = Surface(np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0]]), np.array([[0, 1, 2], [2, 1, 0]]))
    assert (list(fits(flat)), best_primitive(flat), fit_kind("box", flat)) == ([], None, None)


@pytest.mark.parametrize(
    "surface",
    mostly_slow([BRACKET, box(0.05, 0.04, 0.02), GEAR, ROD], 2),
    ids=["bracket", "block", "gear", "rod"],
)
def test_error_is_about_that_of_the_measures(surface):
    target = MeasuredPart.of(surface)
    for fitted in fits(surface):
        measures = measure(target, [fitted.primitive])
        error = max(measures.protrusion_p95, measures.protrusion_max / 3, measures.bareness_max)
        assert fitted.error == pytest.approx(error, rel=0.25, abs=5e-4)


def test_inside_out_part_has_the_fits_of_the_part():
    for fit, other in zip(fits(BRACKET), fits(BRACKET.flipped()), strict=True):
        assert (fit.primitive.size, fit.error) == (other.primitive.size, other.error)


@pytest.mark.parametrize("scale", [1e-4, 1.0, 1e3])
def test_open_or_doubled_box_of_any_size_is_a_box(scale):
    mesh = trimesh.creation.box((0.1, 0.05, 0.02))
    for triangles in (mesh.faces[:7], np.concatenate([mesh.faces, mesh.faces])):
        fitted = best_primitive(Surface(mesh.vertices * scale, np.asarray(triangles, dtype=np.int64)))
        assert fitted.size == pytest.approx((0.1 * scale, 0.05 * scale, 0.02 * scale), rel=1e-6)
