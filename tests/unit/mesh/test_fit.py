"""Fitted primitives: exact ones are found again, in any pose and any order of their triangles."""

import math

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from linkwright.stages.formats.meshes.surface import Surface, moved, weld
from linkwright.stages.mesh.fit import CHEAPEST, fit_one, fits, fittest
from linkwright.stages.mesh.measure import Target, measure
from linkwright.stages.mesh.surfaces.pieces import placed, signed_distance
from linkwright.stages.robot.model.robot import Primitive, frozen

LENGTHS = st.floats(0.002, 0.5)
SEEDS = st.integers(0, 10_000)


def welded(mesh: trimesh.Trimesh) -> Surface:
    surface, _ = weld(np.asarray(mesh.vertices, dtype=float), np.asarray(mesh.faces, dtype=np.int64))
    return surface


def joined(*meshes: trimesh.Trimesh) -> Surface:
    return welded(trimesh.util.concatenate(meshes))


def some_pose(seed: int, mirrored: bool = False) -> np.ndarray:
    rng = np.random.default_rng(seed)
    pose = np.eye(4)
    pose[:3, :3] = Rotation.random(random_state=seed).as_matrix() @ np.diag([1, 1, -1 if mirrored else 1])
    pose[:3, 3] = rng.uniform(-0.3, 0.3, 3)
    return pose


def gear(teeth: int = 24, root: float = 0.028, tip: float = 0.030, width: float = 0.01) -> trimesh.Trimesh:
    angles = np.arange(4 * teeth) * (2 * math.pi / (4 * teeth))
    radii = np.tile([root, root, tip, tip], teeth)
    ring = np.stack([radii * np.cos(angles), radii * np.sin(angles)], axis=1)
    below, above = np.c_[ring, np.zeros(len(ring))], np.c_[ring, np.full(len(ring), width)]
    count, here = len(ring), np.arange(len(ring))
    there = (here + 1) % count
    faces = [np.c_[here, there, there + count], np.c_[here, there + count, here + count]]
    faces += [np.c_[there, here, np.full(count, 2 * count)]]
    faces += [np.c_[here + count, there + count, np.full(count, 2 * count + 1)]]
    points = np.concatenate([below, above, [[0, 0, 0], [0, 0, width]]])
    return trimesh.Trimesh(points, np.concatenate(faces), process=False)


def bracket() -> trimesh.Trimesh:
    """Two plates at a right angle, and a pin: no symmetry."""
    floor = trimesh.creation.box(bounds=[(0, 0, 0), (0.08, 0.05, 0.004)])
    wall = trimesh.creation.box(bounds=[(0, 0, 0), (0.004, 0.05, 0.03)])
    pin = trimesh.creation.cylinder(0.005, 0.02, sections=24)
    pin.apply_translation([0.06, 0.011, 0.012])
    return trimesh.util.concatenate([floor, wall, pin])


def distance_apart(one: Primitive, other: Primitive, size: float) -> float:
    """The largest difference of the distances from two primitives, at points around them [m]."""
    points = one.link_from_shape[:3, 3] + np.random.default_rng(0).uniform(-size, size, (500, 3))
    return float(np.abs(signed_distance(one, points) - signed_distance(other, points)).max())


@settings(max_examples=8, deadline=None)
@given(LENGTHS, LENGTHS, LENGTHS, SEEDS)
def test_a_box_in_any_pose_is_found_again(x: float, y: float, z: float, seed: int) -> None:
    box = Primitive("box", (x, y, z), frozen(some_pose(seed)))
    surface = welded(trimesh.creation.box((x, y, z), some_pose(seed)))
    found = fit_one("box", surface)
    assert found is not None
    assert sorted(found.size) == pytest.approx(sorted((x, y, z)), rel=1e-9)
    assert distance_apart(found, box, max(x, y, z)) < 1e-9 * max(x, y, z) + 2e-12


@settings(max_examples=6, deadline=None)
@given(LENGTHS, LENGTHS, st.integers(12, 64), SEEDS)
def test_the_radius_of_a_cylinder_is_between_its_polygons_circles(
    radius: float, length: float, sections: int, seed: int
) -> None:
    pose = some_pose(seed)
    surface = welded(trimesh.creation.cylinder(radius, length, sections=sections, transform=pose))
    found = fit_one("cylinder", surface)
    assert found is not None
    assert radius * math.cos(math.pi / sections) - 1e-9 <= found.size[0] <= radius + 1e-9
    assert found.size[1] == pytest.approx(length, rel=1e-9)
    assert abs(found.link_from_shape[:3, 2] @ pose[:3, 2]) == pytest.approx(1, abs=1e-12)
    assert np.linalg.norm(found.link_from_shape[:3, 3] - pose[:3, 3]) < 1e-8 * (radius + length)


@settings(max_examples=4, deadline=None)
@given(LENGTHS, SEEDS)
def test_a_sphere_and_a_capsule_in_any_pose_are_found_again(radius: float, seed: int) -> None:
    pose = some_pose(seed)
    ball = trimesh.creation.icosphere(subdivisions=3, radius=radius).apply_transform(pose)
    sphere = fit_one("sphere", welded(ball))
    assert sphere is not None
    assert 0.985 * radius < sphere.size[0] <= radius * (1 + 1e-9)
    assert np.linalg.norm(sphere.link_from_shape[:3, 3] - pose[:3, 3]) < 1e-6 * radius
    mesh = trimesh.creation.capsule(3 * radius, radius, count=[32, 32]).apply_transform(pose)
    capsule = fit_one("capsule", welded(mesh))
    assert capsule is not None
    middle = np.asarray(mesh.bounds).mean(axis=0)
    assert 0.985 * radius < capsule.size[0] <= radius * (1 + 1e-9)
    assert capsule.size[1] == pytest.approx(3 * radius, rel=0.01)
    assert np.linalg.norm(capsule.link_from_shape[:3, 3] - middle) < 0.01 * radius


@pytest.mark.parametrize(
    ("mesh", "kind"),
    [
        (trimesh.creation.box((0.2, 0.15, 0.003)), "box"),
        (trimesh.creation.box((0.03, 0.03, 0.03)), "box"),
        (trimesh.creation.cylinder(0.02, 0.05), "cylinder"),
        (trimesh.creation.cylinder(0.02, 0.001), "cylinder"),
        (trimesh.creation.icosphere(radius=0.03), "sphere"),
        (trimesh.creation.capsule(0.06, 0.01), "capsule"),
        (gear(), "cylinder"),
    ],
    ids=["plate", "cube", "rod", "disc", "ball", "capsule", "gear"],
)
@pytest.mark.parametrize("seed", [1, 2])
def test_the_fittest_kind_is_the_one_that_it_is(mesh: trimesh.Trimesh, kind: str, seed: int) -> None:
    found = fittest(moved(welded(mesh), some_pose(seed)))
    assert found is not None
    assert found.kind == kind


def test_the_radius_of_a_gear_is_between_its_root_and_its_tip() -> None:
    found = fit_one("cylinder", welded(gear()))
    assert found is not None
    assert 0.028 < found.size[0] < 0.030 + 1e-9
    assert found.size[1] == pytest.approx(0.01, abs=1e-9)


def test_noise_hardly_moves_a_fit() -> None:
    mesh = trimesh.creation.box((0.1, 0.06, 0.03)).subdivide().subdivide().subdivide()
    mesh.vertices += np.random.default_rng(3).normal(scale=1e-4, size=mesh.vertices.shape)
    found = fit_one("box", welded(mesh))
    assert found is not None
    assert found.size == pytest.approx((0.1, 0.06, 0.03), abs=8e-4)
    assert found.link_from_shape[:3, :3].tolist() == np.eye(3).tolist()
    assert found.link_from_shape[:3, 3].tolist() == pytest.approx([0, 0, 0], abs=4e-4)


@pytest.mark.parametrize("angle", [0.4, -0.3])
def test_what_is_within_half_a_degree_of_the_axes_is_along_them(angle: float) -> None:
    turn = np.eye(4)
    turn[:3, :3] = Rotation.from_euler("xyz", [angle, 0, 0], degrees=True).as_matrix()
    box = fit_one("box", moved(welded(trimesh.creation.box((0.1, 0.06, 0.03))), turn))
    rod = fit_one("cylinder", moved(welded(trimesh.creation.cylinder(0.01, 0.1)), turn))
    assert box is not None
    assert rod is not None
    assert box.link_from_shape[:3, :3].tolist() == np.eye(3).tolist()
    assert rod.link_from_shape[:3, 2].tolist() == [0, 0, 1]


@pytest.mark.parametrize(("seed", "mirrored"), [(11, False), (12, True), (13, False)])
@pytest.mark.parametrize(
    ("mesh", "kind"),
    # A gear has as many best boxes as it has symmetries.
    [*((bracket(), kind) for kind in CHEAPEST["mujoco"]), (gear(), "cylinder"), (gear(), "sphere")],
)
def test_a_moved_or_mirrored_part_in_another_order_has_the_moved_fit(
    mesh: trimesh.Trimesh, kind: str, seed: int, mirrored: bool
) -> None:
    # Turned once already, so that no direction is near a coordinate axis.
    surface = moved(welded(mesh), some_pose(100))
    pose = some_pose(seed, mirrored)
    rng = np.random.default_rng(seed)
    order = rng.permutation(len(surface.vertices))
    there = moved(surface, pose)
    triangles = np.argsort(order)[there.triangles][rng.permutation(len(there.triangles))]
    there = Surface(there.vertices[order], np.roll(triangles, 1, axis=1))
    one, other = fit_one(kind, surface), fit_one(kind, there)  # type: ignore[arg-type]
    assert one is not None
    assert other is not None
    expected = placed(one, pose)
    assert isinstance(expected, Primitive)
    assert distance_apart(other, expected, 0.1) < 1e-6


def test_the_cheapest_kinds_come_first_and_mjx_gets_no_cylinder() -> None:
    surface = joined(bracket())
    assert [one.primitive.kind for one in fits(surface)] == ["sphere", "capsule", "box", "cylinder"]
    assert [one.primitive.kind for one in fits(surface, CHEAPEST["mjx"])] == ["sphere", "capsule", "box"]


def test_sizes_that_are_given_are_kept_and_the_others_fitted() -> None:
    surface = welded(trimesh.creation.cylinder(0.02, 0.05))
    ball = fit_one("sphere", surface, (0.02,))
    rod = fit_one("cylinder", surface, (0.01, None))
    box = fit_one("box", surface, (None, 0.1, None))
    assert ball is not None
    assert rod is not None
    assert box is not None
    assert ball.size == (0.02,)
    assert ball.link_from_shape[:3, 3].tolist() == pytest.approx([0, 0, 0], abs=1e-9)
    assert rod.size == pytest.approx((0.01, 0.05))
    assert box.size == pytest.approx((0.04, 0.1, 0.05))


def test_what_is_flat_has_no_fit() -> None:
    flat = Surface(np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0]]), np.array([[0, 1, 2], [2, 1, 0]]))
    assert list(fits(flat)) == []
    assert fittest(flat) is None
    assert fit_one("box", flat) is None


@pytest.mark.parametrize(
    "mesh",
    [bracket(), gear(), trimesh.creation.cylinder(0.02, 0.05), trimesh.creation.box((0.05, 0.04, 0.02))],
    ids=["bracket", "gear", "rod", "block"],
)
def test_the_error_is_about_what_the_measures_say(mesh: trimesh.Trimesh) -> None:
    surface = welded(mesh)
    for fitted in fits(surface):
        measures = measure(Target.of(surface), [fitted.primitive])
        told = max(measures.protrusion_p95, measures.protrusion_max / 3, measures.bareness_max)
        assert fitted.error == pytest.approx(told, rel=0.25, abs=5e-4)


def test_an_inside_out_part_has_the_fits_of_the_part() -> None:
    surface = welded(bracket())
    for one, other in zip(fits(surface), fits(surface.flipped()), strict=True):
        assert one.primitive.size == other.primitive.size
        assert one.error == other.error


@pytest.mark.parametrize("scale", [1e-4, 1.0, 1e3])
def test_an_open_or_doubled_box_of_any_size_is_a_box(scale: float) -> None:
    mesh = trimesh.creation.box((0.1, 0.05, 0.02))
    points, triangles = np.asarray(mesh.vertices) * scale, np.asarray(mesh.faces, dtype=np.int64)
    for some in (triangles[:7], np.concatenate([triangles, triangles])):
        found = fittest(Surface(points, some))
        assert found is not None
        assert found.size == pytest.approx((0.1 * scale, 0.05 * scale, 0.02 * scale), rel=1e-6)
