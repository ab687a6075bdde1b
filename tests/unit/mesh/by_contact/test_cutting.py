"""Cutting a surface, near boxes, and what can be reached from outside, against closed forms."""

from itertools import combinations, product

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

from linkwright.stages.formats.meshes.surface import Surface
from linkwright.stages.mesh.by_contact.ends import fit_end
from linkwright.stages.mesh.by_contact.poses import near_pairs, relative
from linkwright.stages.mesh.configuration.collider_settings import ContactSettings
from linkwright.stages.mesh.cut.chunk import engine_hull, hull_chunk
from linkwright.stages.mesh.cut.cutting import cut_by_plane
from linkwright.stages.mesh.cut.outside import ReachableSurface
from linkwright.stages.mesh.cut.planes import crossing, flat_faces, through
from linkwright.stages.robot.contact.clearance import engine
from tests.support.robots import at, pose
from tests.support.solids import box, of_mesh

SEEDS = st.integers(0, 10_000)


@given(SEEDS)
def test_cut_loses_no_area_and_puts_each_triangle_on_its_side(seed):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(120, 3)).round(1)  # some lie in the plane
    whole = Surface(points, np.arange(120).reshape(-1, 3))
    normal = np.eye(3)[seed % 3] if seed % 2 else rng.normal(size=3)
    normal /= np.linalg.norm(normal)
    height = float(np.round(rng.normal() / 2, 1))
    below, above = cut_by_plane(whole, normal, height)
    assert below.area() + above.area() == pytest.approx(whole.area(), rel=1e-12)
    assert (below.vertices @ normal).max(initial=-9) <= height + 1e-12
    assert (above.vertices @ normal).min(initial=9) >= height - 1e-12


@settings(max_examples=40)
@given(SEEDS)
def test_hulls_of_both_sides_hold_the_whole_surface(seed):
    """The surface is a sphere that is cut through, whose halves are known."""
    ball = trimesh.creation.icosphere(2, 0.05)
    rng = np.random.default_rng(seed)
    normal = rng.normal(size=3)
    halves = cut_by_plane(of_mesh(ball), normal / np.linalg.norm(normal), rng.uniform(-0.03, 0.03))
    volume = sum(hull_chunk(side, 1000, 0).volume for side in halves)
    assert volume == pytest.approx(ConvexHull(ball.vertices).volume, rel=1e-4)


@settings(max_examples=20)
@given(SEEDS)
def test_near_pairs_are_those_whose_boxes_meet(seed):
    rng = np.random.default_rng(seed)
    links, poses = int(rng.integers(1, 8)), int(rng.integers(1, 6))
    places = [np.stack([pose(rng) for _ in range(poses)]) for _ in range(links)]
    low = rng.uniform(-0.2, 0, (links, 3))
    high = low + rng.uniform(0, 0.2, (links, 3))
    apart = {(0, 1)} if links > 1 and seed % 2 else set()
    expected = set()
    for row in range(poses):
        corners = low[:, None] + np.array([*product((0, 1), repeat=3)]) * (high - low)[:, None]
        there = np.array([place[row] for place in places])
        corners = np.einsum("lij,lkj->lki", there[:, :3, :3], corners) + there[:, None, :3, 3]
        least, most = corners.min(axis=1) - 0.005, corners.max(axis=1) + 0.005
        for a, b in combinations(range(links), 2):
            if (a, b) not in apart and (least[a] <= most[b]).all() and (least[b] <= most[a]).all():
                expected.add((a, b, row))
    near = near_pairs(places, (low, high), 0.01, apart)
    assert {(pair.first_link, pair.second_link, int(row)) for pair in near for row in pair.rows} == expected
    assert [(pair.first_link, pair.second_link) for pair in near] == sorted(
        (pair.first_link, pair.second_link) for pair in near
    )


@given(SEEDS)
def test_relative_poses_are_products(seed):
    rng = np.random.default_rng(seed)
    first, second = (np.stack([pose(rng) for _ in range(3)]) for _ in range(2))
    np.testing.assert_allclose(first @ relative(first, second), second, atol=1e-12)


def shell(mouth):
    """An open sheet: a box of 100 mm without its lid, but for a rim that leaves a mouth of this width [m]."""
    cube = trimesh.creation.box((0.1, 0.1, 0.1))
    walls = cube.triangles[np.abs(cube.triangles_center[:, 2] - 0.05) > 1e-9]
    half, strips = mouth / 2, []
    for sign in (-1, 1) if mouth < 0.1 else ():
        for a, b in (
            ((sign * half, -0.05), (sign * 0.05, 0.05)),
            ((-half, sign * half), (half, sign * 0.05)),
        ):
            corners = [(a[0], a[1], 0.05), (b[0], a[1], 0.05), (b[0], b[1], 0.05), (a[0], b[1], 0.05)]
            strips += [corners[:3], [corners[0], corners[2], corners[3]]]
    corners = np.concatenate([walls, np.array(strips).reshape(-1, 3, 3)])
    return Surface(corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3))


@pytest.mark.parametrize(("mouth", "expected"), [(0.1, 0.05), (0.06, 0.05), (0.006, 0.0)])
def test_hollow_counts_where_a_ball_gets_in(mouth, expected):
    middle, away = ReachableSurface.of(shell(mouth), 0.005).distances(np.array([[0, 0, 0.0], [0, 0, 0.25]]))
    assert middle == pytest.approx(expected, abs=1e-4)
    assert away == pytest.approx(0.2 if mouth < 0.05 else np.hypot(0.2, mouth / 2), abs=1e-3)


def test_inside_of_a_solid_counts_for_nothing():
    outside = ReachableSurface.of(box(0.1, 0.1, 0.1), 0.003)
    assert not outside.distances(np.random.default_rng(0).uniform(-0.045, 0.045, (100, 3))).any()
    assert outside.distances(np.array([[0.08, 0, 0]])) == pytest.approx([0.03], abs=1e-5)


def test_hull_of_a_corner_stands_out_by_its_slant():
    """The hull of an L of 100 by 100 by 20 mm, walls of 20 mm: its slanted face is at most √2·40 mm out."""
    parts = [trimesh.creation.box(bounds=[(0, 0, 0), (a, b, 0.02)]) for a, b in ((0.1, 0.02), (0.02, 0.1))]
    ell = of_mesh(trimesh.boolean.union(parts, engine="manifold"))
    outside = ReachableSurface.of(ell, 0.002)

    def most(*sides):
        return outside.protrusion([outside.sampled(hull_chunk(side, 64, 0).piece) for side in sides]).most

    assert most(ell) == pytest.approx(0.04, abs=2e-3)  # from the middle of the slant to the nearest wall
    assert most(*cut_by_plane(ell, np.array([1.0, 0, 0]), 0.02)) < 1e-5


def test_planes_are_beside_the_faces_and_across_the_axes():
    plate = box(0.1, 0.06, 0.02)
    heights = {round(abs(height), 4) for normal, height in flat_faces(plate) if abs(normal[2]) > 0.99}
    assert heights == {0.0098, 0.0102}
    planes = crossing(through(np.eye(3), plate.vertices), plate.vertices)
    assert all(-0.05 < height < 0.05 for _, height in planes)


def test_bareness_of_an_end_is_measured():
    """A box of 80 mm by its upper and lower quarter: half is missing, and 20 mm are bare at most."""
    whole, up = box(0.04, 0.04, 0.08), np.array([0.0, 0, 1])
    upper, lower = cut_by_plane(whole, up, 0.02)[1], cut_by_plane(whole, up, -0.02)[0]
    pieces = [hull_chunk(side, 64, 0) for side in (upper, lower)]
    _, end = fit_end(whole, [pieces], ContactSettings())
    assert end.meets
    assert (end.measures.extra, end.measures.missing) == pytest.approx((0.0, 0.5), abs=1e-4)
    assert end.measures.bareness_max == pytest.approx(0.02, abs=2e-4)


@pytest.mark.parametrize("corners", [254, 255, 1500])
def test_corner_may_have_any_number_of_neighbours(corners):
    cone = trimesh.creation.cone(0.05, 0.08, sections=corners)
    cylinder = trimesh.creation.cylinder(0.05, 0.08, sections=corners)
    cylinder.apply_translation((0, 0, 0.04))
    cube, _ = engine_hull(trimesh.creation.box((0.2, 0.2, 0.2)).vertices)
    (below,) = engine().poses(at(0, 0, -0.09)[None])
    for mesh in (cone, cylinder):
        convex, volume = engine_hull(mesh.vertices)
        assert volume == pytest.approx(mesh.volume, rel=1e-9)
        assert engine().depth(convex, cube, below) == pytest.approx(0.01, abs=2e-5)
    assert hull_chunk(of_mesh(cone), 2000, 0).volume == pytest.approx(cone.volume, rel=1e-5)
