"""Cutting a surface, near boxes, and what can be reached from outside, against closed forms."""

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

from linkwright.stages.formats.meshes.surface import Surface
from linkwright.stages.mesh.by_contact.ends import fitted_end
from linkwright.stages.mesh.by_contact.poses import near_pairs, relative
from linkwright.stages.mesh.configuration.collider_settings import ContactSettings
from linkwright.stages.mesh.cut.cutting import cut
from linkwright.stages.mesh.cut.outside import Outside
from linkwright.stages.mesh.cut.piece import hulled, rough
from linkwright.stages.mesh.cut.planes import crossing, flat_faces, through
from linkwright.stages.robot.contact.clearance import engine
from tests.support.robots import pose
from tests.support.solids import of_mesh

SEEDS = st.integers(0, 10_000)


@given(SEEDS)
def test_a_cut_loses_no_area_and_puts_each_triangle_on_its_side(seed):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(120, 3)).round(1)  # some lie in the plane
    whole = Surface(points, np.arange(120).reshape(-1, 3))
    normal = np.eye(3)[seed % 3] if seed % 2 else rng.normal(size=3)
    normal /= np.linalg.norm(normal)
    height = float(np.round(rng.normal() / 2, 1))
    below, above = cut(whole, normal, height)
    assert below.area() + above.area() == pytest.approx(whole.area(), rel=1e-12)
    assert (below.vertices @ normal).max(initial=-9) <= height + 1e-12
    assert (above.vertices @ normal).min(initial=9) >= height - 1e-12


@given(SEEDS)
def test_the_hulls_of_both_sides_hold_the_whole_surface(seed):
    """Of a sphere that is cut through, whose halves are known."""
    ball = trimesh.creation.icosphere(2, 0.05)
    rng = np.random.default_rng(seed)
    normal = rng.normal(size=3)
    normal /= np.linalg.norm(normal)
    height = rng.uniform(-0.03, 0.03)
    halves = [hulled(side, 1000, 0) for side in cut(of_mesh(ball), normal, height)]
    assert sum(half.volume for half in halves) == pytest.approx(ConvexHull(ball.vertices).volume, rel=1e-4)


@settings(max_examples=20)
@given(SEEDS)
def test_near_pairs_are_those_whose_boxes_meet(seed):
    rng = np.random.default_rng(seed)
    links, poses = int(rng.integers(1, 8)), int(rng.integers(1, 6))
    places = [np.stack([pose(rng) for _ in range(poses)]) for _ in range(links)]
    low = rng.uniform(-0.2, 0, (links, 3))
    bounds = low, low + rng.uniform(0, 0.2, (links, 3))
    apart = {(0, 1)} if links > 1 and seed % 2 else set()
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    wanted = set()
    for row in range(poses):
        boxes = []
        for link in range(links):
            points = bounds[0][link] + corners * (bounds[1][link] - bounds[0][link])
            moved = points @ places[link][row][:3, :3].T + places[link][row][:3, 3]
            boxes.append((moved.min(axis=0) - 0.005, moved.max(axis=0) + 0.005))
        for one in range(links):
            for other in range(one + 1, links):
                meets = (boxes[one][0] <= boxes[other][1]).all() and (boxes[other][0] <= boxes[one][1]).all()
                if meets and (one, other) not in apart:
                    wanted.add((one, other, row))
    found = near_pairs(places, bounds, 0.01, apart)
    assert {(near.one, near.other, int(row)) for near in found for row in near.rows} == wanted
    assert [(near.one, near.other) for near in found] == sorted((near.one, near.other) for near in found)


@given(SEEDS)
def test_relative_poses_are_products(seed):
    rng = np.random.default_rng(seed)
    one, other = (np.stack([pose(rng) for _ in range(3)]) for _ in range(2))
    np.testing.assert_allclose(one @ relative(one, other), other, atol=1e-12)


def shell(mouth: float) -> Surface:
    """An open sheet: a box of 100 mm without its lid, but for a rim that leaves a mouth of this width [m]."""
    box = trimesh.creation.box((0.1, 0.1, 0.1))
    walls = box.triangles[np.abs(box.triangles_center[:, 2] - 0.05) > 1e-9]
    half = mouth / 2
    strips = []
    if mouth < 0.1:
        for sign in (-1, 1):
            for a, b in (
                ((sign * half, -0.05), (sign * 0.05, 0.05)),
                ((-half, sign * half), (half, sign * 0.05)),
            ):
                corners = [(a[0], a[1], 0.05), (b[0], a[1], 0.05), (b[0], b[1], 0.05), (a[0], b[1], 0.05)]
                strips += [[corners[0], corners[1], corners[2]], [corners[0], corners[2], corners[3]]]
    corners = np.concatenate([walls, np.array(strips).reshape(-1, 3, 3)])
    return Surface(corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3))


@pytest.mark.parametrize(("mouth", "expected"), [(0.1, 0.05), (0.06, 0.05), (0.006, 0.0)])
def test_a_hollow_counts_where_a_ball_gets_in(mouth, expected):
    outside = Outside.of(shell(mouth), 0.005)
    middle, away = outside.distances(np.array([[0, 0, 0.0], [0, 0, 0.25]]))
    assert middle == pytest.approx(expected, abs=1e-4)
    assert away == pytest.approx(0.2 if mouth < 0.05 else np.hypot(0.2, mouth / 2), abs=1e-3)


def test_the_inside_of_a_solid_counts_for_nothing():
    outside = Outside.of(of_mesh(trimesh.creation.box((0.1, 0.1, 0.1))), 0.003)
    points = np.random.default_rng(0).uniform(-0.045, 0.045, (100, 3))
    assert not outside.distances(points).any()
    assert outside.distances(np.array([[0.08, 0, 0]])) == pytest.approx([0.03], abs=1e-5)


def test_how_far_a_hull_stands_out_of_a_corner():
    """The hull of an L of 100 by 100 by 20 mm, walls of 20 mm: its slanted face is at most √2·40 mm out."""
    parts = [trimesh.creation.box(bounds=[(0, 0, 0), (a, b, 0.02)]) for a, b in ((0.1, 0.02), (0.02, 0.1))]
    ell = of_mesh(trimesh.boolean.union(parts, engine="manifold"))
    outside = Outside.of(ell, 0.002)
    whole = hulled(ell, 64, 0)
    out = outside.standing_out([outside.sampled(whole.piece)])
    assert out.most == pytest.approx(0.04, abs=2e-3)  # the nearest wall is 40 mm from the middle of the slant
    halves = [hulled(side, 64, 0) for side in cut(ell, np.array([1.0, 0, 0]), 0.02)]
    assert outside.standing_out([outside.sampled(half.piece) for half in halves]).most < 1e-5


def test_planes_lie_beside_the_faces_and_across_the_axes():
    box = of_mesh(trimesh.creation.box((0.1, 0.06, 0.02)))
    heights = {round(abs(height), 4) for normal, height in flat_faces(box) if abs(normal[2]) > 0.99}
    assert heights == {0.0098, 0.0102}
    planes = crossing(through(np.eye(3), box.vertices), box.vertices)
    assert all(-0.05 < height < 0.05 for _, height in planes)


def test_what_pieces_of_an_end_lack_is_measured():
    """A box of 80 mm by its upper and lower quarter: half is missing, and 20 mm are bare at most."""
    box = of_mesh(trimesh.creation.box(extents=[0.04, 0.04, 0.08]))
    upper = cut(box, np.array([0.0, 0, 1]), 0.02)[1]
    lower = cut(box, np.array([0.0, 0, 1]), -0.02)[0]
    pieces = [hulled(side, 64, 0) for side in (upper, lower)]
    assert None not in pieces
    _, end = fitted_end(box, [pieces], ContactSettings())
    assert end.meets
    assert end.measures.extra == pytest.approx(0.0, abs=1e-4)
    assert end.measures.missing == pytest.approx(0.5, abs=1e-4)
    assert end.measures.bareness_max == pytest.approx(0.02, abs=2e-4)


@pytest.mark.parametrize("corners", [254, 255, 1500])
def test_a_corner_may_have_any_number_of_neighbours(corners):
    """A cone and a cylinder, by how deep a cube is in them from below."""
    cone = trimesh.creation.cone(0.05, 0.08, sections=corners)
    cylinder = trimesh.creation.cylinder(0.05, 0.08, sections=corners)
    cylinder.apply_translation((0, 0, 0.04))
    cube, _ = rough(trimesh.creation.box((0.2, 0.2, 0.2)).vertices)
    (pose_below,) = engine().poses(np.array([[[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, -0.09], [0, 0, 0, 1.0]]]))
    for mesh in (cone, cylinder):
        convex, volume = rough(mesh.vertices)
        assert volume == pytest.approx(mesh.volume, rel=1e-9)
        assert engine().depth(convex, cube, pose_below) == pytest.approx(0.01, abs=2e-5)
    assert hulled(of_mesh(cone), 2000, 0).volume == pytest.approx(cone.volume, rel=1e-5)
