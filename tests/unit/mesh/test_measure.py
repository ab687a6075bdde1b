"""Measures: against closed forms, and against dense sampling by trimesh."""

import itertools
import math

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from linkwright.stages.formats.meshes.surface import Surface, moved, weld
from linkwright.stages.mesh.measure import Target, hopeless, measure, near
from linkwright.stages.mesh.surfaces.convex_hull import convex_hull
from linkwright.stages.mesh.surfaces.pieces import placed, surface_of
from linkwright.stages.robot.model.robot import Primitive, frozen
from tests.support.solids import box, joined, of_mesh
from tests.unit.mesh.test_inside import winding

WITHIN = 1.5e-3
"""Of the diagonal: the precision that is promised of a maximum."""

NOTHING = 5e-5
"""A distance [m] on parts of a metre or so that is only rounding."""


def at(x=0.0, y=0.0, z=0.0):
    pose = np.eye(4)
    pose[:3, 3] = x, y, z
    return frozen(pose)


def judged(part, *pieces):
    return measure(Target.of(part), pieces)


def test_a_box_of_itself_has_no_error():
    part = box(0.1, 0.2, 0.05)
    for piece in (part, Primitive("box", (0.1, 0.2, 0.05), at())):
        found = judged(part, piece)
        assert found.by == "boolean"
        assert (found.extra, found.missing) == pytest.approx((0, 0), abs=1e-6)
        distances = found.protrusion_p95, found.protrusion_max, found.bareness_p95, found.bareness_max
        assert distances == pytest.approx((0, 0, 0, 0), abs=NOTHING)


@pytest.mark.parametrize("primitive", [False, True])
def test_a_box_around_a_box(primitive):
    """At its corners it protrudes √3 times as far as at its faces, which have 95 % of its area and more."""
    far, part = 0.01, box(1.0, 1.0, 1.0)
    size = 1 + 2 * far
    around = Primitive("box", (size,) * 3, at()) if primitive else box(size, size, size)
    found = judged(part, around)
    assert found.extra == pytest.approx(size**3 - 1, abs=2e-6)
    assert found.missing == 0
    assert found.protrusion_p95 == pytest.approx(far, rel=1e-3)
    assert found.protrusion_max == pytest.approx(math.sqrt(3) * far, rel=1e-3)
    assert found.bareness_max == 0
    turned = judged(around if not primitive else surface_of(around), part)
    assert turned.missing == pytest.approx(1 - 1 / size**3, abs=2e-6)
    assert turned.extra == 0
    assert turned.bareness_p95 == pytest.approx(far, rel=1e-3)
    assert turned.bareness_max == pytest.approx(math.sqrt(3) * far, rel=1e-3)
    assert turned.protrusion_max == 0


def test_a_ball_around_a_cube():
    radius = math.sqrt(3) / 2
    found = judged(box(1, 1, 1), Primitive("sphere", (radius,), at()))
    assert found.extra == pytest.approx(4 / 3 * math.pi * radius**3 - 1, abs=2e-3)
    assert found.protrusion_max == pytest.approx(radius - 0.5, abs=WITHIN * math.sqrt(3))
    assert found.bareness_max == pytest.approx(0, abs=0.002 * radius)
    assert found.missing == pytest.approx(0, abs=1e-3)


@pytest.mark.parametrize("kind", ["cylinder", "capsule", "sphere"])
def test_a_curved_primitive_is_no_further_than_facets_from_its_mesh(kind):
    one = Primitive(kind, (0.05, 0.2)[: 1 if kind == "sphere" else 2], at(0.3, -0.2, 0.1))
    found = judged(surface_of(one), one)
    assert (found.extra, found.missing) == pytest.approx((0, 0), abs=1e-6)
    assert found.protrusion_max < 0.003 * 0.05
    assert found.bareness_max < 0.003 * 0.05


def test_a_disc_over_the_hole_of_a_ring_protrudes_by_the_radius_of_the_hole():
    ring = of_mesh(trimesh.creation.annulus(0.04, 0.1, 0.03, sections=96))
    found = judged(ring, Primitive("cylinder", (0.1, 0.03), at()))
    assert found.protrusion_max == pytest.approx(0.04 * math.cos(math.pi / 96), rel=0.02)
    assert found.extra == pytest.approx(0.16 / 0.84, rel=5e-3)
    assert found.bareness_max < 1e-4


def test_a_cube_in_eight_has_no_error_at_the_seams():
    eighths = [box(0.5, 0.5, 0.5, at=(x, y, z)) for x in (0, 0.5) for y in (0, 0.5) for z in (0, 0.5)]
    found = judged(box(1, 1, 1, at=(0.25, 0.25, 0.25)), *eighths)
    assert (found.extra, found.missing) == pytest.approx((0, 0), abs=1e-6)
    assert (found.protrusion_max, found.bareness_max) == pytest.approx((0, 0), abs=NOTHING)


def test_seams_through_a_cavity_are_no_outer_surface():
    hollow = joined(box(1, 1, 1), box(0.8, 0.8, 0.8).flipped())
    halves = box(0.5, 1, 1, at=(-0.25, 0, 0)), box(0.5, 1, 1, at=(0.25, 0, 0))
    found = judged(hollow, *halves)
    assert found.extra == pytest.approx(0, abs=1e-6)
    assert found.protrusion_max == pytest.approx(0, abs=NOTHING)
    assert found.bareness_max == pytest.approx(0, abs=NOTHING)
    overlapping = box(0.6, 1, 1, at=(-0.2, 0, 0)), box(0.6, 1, 1, at=(0.2, 0, 0))
    assert judged(hollow, *overlapping).protrusion_max == pytest.approx(0, abs=NOTHING)


def test_a_gap_between_pieces_is_bare_in_its_middle():
    gap = 0.1
    pieces = box(0.45, 1, 1, at=(-0.275, 0, 0)), box(0.45, 1, 1, at=(0.275, 0, 0))
    found = judged(box(1, 1, 1), *pieces)
    assert found.missing == pytest.approx(gap, abs=1e-6)
    assert found.bareness_max == pytest.approx(gap / 2, abs=WITHIN * math.sqrt(3))
    assert found.protrusion_max == pytest.approx(0, abs=NOTHING)


def test_the_order_and_the_number_of_looks_do_not_matter():
    part = of_mesh(trimesh.creation.torus(0.1, 0.03))
    target = Target.of(part)
    pieces = [
        Primitive("capsule", (0.03, 0.05), at(0.1)),
        Primitive("sphere", (0.04,), at(-0.1)),
        box(0.1, 0.05, 0.05, at=(0, 0.1, 0)),
        box(0.1, 0.05, 0.05, at=(0, -0.1, 0)),
    ]
    first = measure(target, pieces)
    assert measure(target, pieces[::-1]) == first
    assert measure(Target.of(part), pieces) == first


def test_a_larger_collider_protrudes_more_and_bares_less():
    target = Target.of(box(0.2, 0.1, 0.05))
    ladder = [measure(target, [box(0.2 + g, 0.1 + g, 0.05 + g)]) for g in np.linspace(-0.02, 0.02, 9)]
    for small, large in itertools.pairwise(ladder):
        assert small.extra <= large.extra
        assert small.missing >= large.missing
        for name in ("bareness_p95", "bareness_max"):
            assert getattr(small, name) >= getattr(large, name), name
        for name in ("protrusion_p95", "protrusion_max"):
            assert getattr(small, name) <= getattr(large, name), name


def brute(part, pieces, count=40_000):
    """Protrusion and bareness, p95 and max, by many random points; of convex surfaces alone."""
    mesh = trimesh.Trimesh(part.vertices, part.triangles, process=False)
    hulls = [trimesh.Trimesh(piece.vertices, piece.triangles, process=False) for piece in pieces]
    areas = np.array([hull.area for hull in hulls])
    outer = []
    for number, hull in enumerate(hulls):
        points = np.concatenate(
            [hull.vertices, hull.sample(int(count * areas[number] / areas.sum()), seed=1)]
        )
        within = np.zeros(len(points), dtype=bool)
        for other, one in enumerate(hulls):
            if other != number:
                heights = points @ one.face_normals.T - (one.triangles[:, 0] * one.face_normals).sum(axis=1)
                within |= heights.max(axis=1) < 1e-9
        outer.append(points[~within])
    outer = np.concatenate(outer)
    protrusion = np.where(winding(part, outer) > 0.5, 0.0, distances(mesh, outer))
    points = np.concatenate([mesh.vertices, mesh.sample(count, seed=2)])
    bareness = np.full(len(points), np.inf)
    for hull in hulls:
        heights = points @ hull.face_normals.T - (hull.triangles[:, 0] * hull.face_normals).sum(axis=1)
        bareness = np.minimum(bareness, np.where(heights.max(axis=1) <= 0, 0.0, distances(hull, points)))
    return [value for one in (protrusion, bareness) for value in (np.quantile(one, 0.95), one.max())]


def distances(mesh, points):
    best = np.full(len(points), np.inf)
    for triangle in mesh.triangles:
        nearest = trimesh.triangles.closest_point(np.repeat(triangle[None], len(points), axis=0), points)
        best = np.minimum(best, np.linalg.norm(points - nearest, axis=1))
    return best


def check_against_many_points(part, pieces, count):
    diagonal = float(np.linalg.norm(np.ptp(part.vertices, axis=0)))
    found = judged(part, *pieces)
    wanted = brute(part, pieces, count)
    slack = WITHIN * diagonal + found.protrusion_max / 50
    assert found.protrusion_p95 == pytest.approx(wanted[0], abs=3 * slack)
    assert found.bareness_p95 == pytest.approx(wanted[2], abs=3 * slack)
    # Many points never reach the maximum quite.
    assert wanted[1] - slack <= found.protrusion_max <= wanted[1] + 0.02 * diagonal
    assert wanted[3] - slack <= found.bareness_max <= wanted[3] + 0.02 * diagonal


def a_part(random):
    box_or_ring = trimesh.creation.box((1, 0.6, 0.3)), trimesh.creation.annulus(0.2, 0.5, 0.4, sections=12)
    return of_mesh(box_or_ring[random.integers(2)])


def hulls_of(random, count):
    return [
        convex_hull(random.normal(size=(8, 3)) * random.uniform(0.1, 0.5, 3) + random.uniform(-0.5, 0.5, 3))
        for _ in range(count)
    ]


@settings(max_examples=4)
@given(st.integers(0, 10_000), st.integers(1, 4))
def test_any_part_and_pieces_are_judged_as_by_many_points(seed, count):
    random = np.random.default_rng(seed)
    check_against_many_points(a_part(random), hulls_of(random, count), 2500)


@pytest.mark.slow
@settings(max_examples=3)
@given(st.integers(0, 10_000), st.integers(1, 6))
def test_many_parts_and_pieces_are_judged_as_by_many_points(seed, count):
    random = np.random.default_rng(seed)
    check_against_many_points(a_part(random), hulls_of(random, count), 30_000)


@pytest.mark.slow
@settings(max_examples=5)
@given(st.integers(0, 10_000), st.floats(1e-3, 50.0))
def test_place_and_size_do_not_matter(seed, scale):
    random = np.random.default_rng(seed)
    part = of_mesh(trimesh.creation.annulus(0.2, 0.5, 0.4, sections=24))
    pieces = [box(0.6, 0.5, 0.4, at=(0.2, 0, 0)), box(0.4, 0.9, 0.2)]
    pose = trimesh.transformations.random_rotation_matrix(random.uniform(size=3))
    pose[:3, 3] = random.uniform(-1, 1, 3)
    one = judged(part, *pieces)
    stretch = np.diag([scale, scale, scale, 1.0])
    other = judged(moved(moved(part, stretch), pose), *(placed(moved(p, stretch), pose) for p in pieces))
    slack = 3 * WITHIN
    assert (other.extra, other.missing) == pytest.approx((one.extra, one.missing), abs=1e-5)
    for name in ("protrusion_p95", "protrusion_max", "bareness_p95", "bareness_max"):
        assert getattr(other, name) / scale == pytest.approx(getattr(one, name), abs=slack, rel=0.03), name


@pytest.mark.parametrize("far", [-0.02, -0.011, -0.005, 0.0, 0.009, 0.011, 0.02])
def test_what_is_hopeless_misses_the_tolerance_and_what_misses_it_by_far_is_hopeless(far):
    target = Target.of(box(1, 1, 1))
    piece = box(1 + 2 * far, 1 + 2 * far, 1 + 2 * far)
    assert hopeless(target, [piece], 0.01) == (abs(far) > 0.01)


@pytest.mark.slow
@settings(max_examples=20)
@given(st.integers(0, 10_000), st.integers(1, 4), st.floats(0.001, 0.5))
def test_nothing_within_the_tolerance_is_hopeless(seed, count, tolerance):
    random = np.random.default_rng(seed)
    target, pieces = Target.of(a_part(random)), hulls_of(random, count)
    if hopeless(target, pieces, tolerance):
        found = measure(target, pieces)
        worst = max(found.bareness_max, found.protrusion_p95, found.protrusion_max / 3)
        assert worst > 0.98 * tolerance


@settings(max_examples=15)
@given(st.integers(0, 10_000), st.integers(1, 4), st.booleans())
def test_what_is_near_is_what_measures_say(seed, count, three_times):
    """A tolerance on either side of what is measured, by the precision of a maximum."""
    random = np.random.default_rng(seed)
    target, pieces = Target.of(a_part(random)), hulls_of(random, count)
    times = 3.0 if three_times else 1.0
    found = measure(target, pieces)
    worst = max(found.bareness_max, found.protrusion_p95, found.protrusion_max / times)
    spare = 2 * WITHIN * target.diagonal
    above, below = 1.05 * worst + spare, 0.95 * worst - spare
    assert near(target, pieces, above, times * above)
    if below > 0:
        assert not near(target, pieces, below, times * below)


@pytest.mark.parametrize(
    ("off", "kept"), [((0.0, 0.0), True), ((0.02, 0.0), False), ((0.0, 0.02), False), ((0.009, 0.009), True)]
)
def test_what_reaches_too_far_or_leaves_too_much_bare_is_not_near(off, kept):
    target = Target.of(box(1, 1, 1))
    beyond, bare = off
    piece = box(1 + beyond - bare, 1, 1, at=((beyond + bare) / 2, 0, 0))
    assert near(target, [piece], 0.01, 0.01) is kept


def test_an_open_part_is_judged_by_sampling_and_hardly_differently():
    whole = of_mesh(trimesh.creation.box((0.2, 0.1, 0.1)).subdivide().subdivide().subdivide())
    holed = Surface(whole.vertices, whole.triangles[1:])
    around = box(0.21, 0.11, 0.11)
    one, other = judged(whole, around), judged(holed, around)
    assert other.by == "sampling"
    assert other.extra == pytest.approx(one.extra, abs=0.05)
    assert other.missing == pytest.approx(0, abs=0.02)
    assert other.protrusion_max == pytest.approx(one.protrusion_max, rel=0.1)
    assert other.protrusion_p95 == pytest.approx(one.protrusion_p95, rel=0.1)


def test_solids_of_a_part_that_overlap_count_once():
    part = joined(box(0.1, 0.1, 0.1), box(0.1, 0.1, 0.1, at=(0.05, 0, 0)))
    target = Target.of(part)
    assert target.volume == pytest.approx(0.0015)
    found = measure(target, [box(0.15, 0.1, 0.1, at=(0.025, 0, 0))])
    assert found.by == "boolean"
    assert (found.extra, found.missing) == pytest.approx((0, 0), abs=1e-6)
    # The walls within the part are of its surface, and covered.
    assert (found.protrusion_max, found.bareness_max) == pytest.approx((0, 0), abs=NOTHING)


def test_solids_that_share_an_edge_are_judged_by_booleans():
    pair, _ = weld(
        *(lambda one: (one.vertices, one.triangles))(joined(box(1, 1, 1), box(1, 1, 1, at=(1, 1, 0))))
    )
    found = judged(pair, box(2, 2, 1, at=(0.5, 0.5, 0)))
    assert found.by == "boolean"
    assert found.extra == pytest.approx(1, abs=1e-6)
    assert found.protrusion_max == pytest.approx(1, rel=0.02)


def test_sampled_shares_are_those_of_booleans():
    part = of_mesh(trimesh.creation.annulus(0.04, 0.1, 0.05))
    solid = Target.of(part)
    pieces = [box(0.15, 0.15, 0.06), Primitive("cylinder", (0.03, 0.3), at(0.08, 0, 0))]
    exact = measure(solid, pieces)
    sampled = measure(Target.of(Surface(part.vertices, part.triangles[1:])), pieces)
    assert (exact.by, sampled.by) == ("boolean", "sampling")
    assert sampled.extra == pytest.approx(exact.extra, abs=0.03)
    assert sampled.missing == pytest.approx(exact.missing, abs=0.03)


def test_a_sheet_has_no_inside():
    sheet = Surface(
        np.array([[0, 0, 0], [0.1, 0, 0], [0.1, 0.1, 0], [0, 0.1, 0.0]]), np.array([[0, 1, 2], [0, 2, 3]])
    )
    found = judged(sheet, box(0.1, 0.1, 0.02, at=(0.05, 0.05, 0)))
    assert found.extra is None
    assert found.missing == 0
    assert found.protrusion_max == pytest.approx(0.01, rel=1e-3)
    assert found.bareness_max == pytest.approx(0, abs=NOTHING)


@pytest.mark.slow
def test_a_tangle_is_an_error_and_not_a_wait():
    random = np.random.default_rng(1)
    corners = random.uniform(size=(150_000, 3))
    with pytest.raises(ValueError, match="a tangle"):
        Target.of(Surface(corners, np.arange(150_000).reshape(-1, 3)))
    few = Target.of(Surface(corners[:300], np.arange(300).reshape(-1, 3)))
    assert measure(few, [box(1, 1, 1, at=(0.5, 0.5, 0.5))]).bareness_max == 0


def test_what_cannot_be_measured_is_an_error():
    part = box(1, 1, 1)
    with pytest.raises(ValueError, match="without pieces"):
        judged(part)
    for bad in (
        Surface(np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64)),
        Surface(np.full((3, 3), np.nan), np.array([[0, 1, 2]])),
        Surface(np.zeros((3, 3)), np.array([[0, 1, 2]])),
    ):
        with pytest.raises(ValueError, match="nothing to measure"):
            Target.of(bad)
