"""Measures: against closed forms, and against dense sampling by trimesh."""

import itertools
import math

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from linkwright.stages.formats.meshes.surface import Surface, transform_surface, weld
from linkwright.stages.mesh.measure import MeasuredPart, is_hopeless, is_near, measure
from linkwright.stages.mesh.surfaces.convex_hull import convex_hull
from linkwright.stages.mesh.surfaces.pieces import placed, surface_of
from linkwright.stages.robot.model.robot import Primitive
from tests.support.robots import at
from tests.support.solids import box, joined, of_mesh
from tests.unit.mesh.test_surface import winding

WITHIN = 1.5e-3
"""The precision that is promised of a maximum, as a share of the diagonal."""

NOTHING = 5e-5
"""A distance [m] on parts of a metre or so that is only rounding."""

DISTANCES = ("protrusion_p95", "protrusion_max", "bareness_p95", "bareness_max")
SEEDS = st.integers(0, 10_000)


def judged(part, *pieces):
    return measure(MeasuredPart.of(part), pieces)


OVERLAPPING = joined(box(0.1, 0.1, 0.1), box(0.1, 0.1, 0.1, at=(0.05, 0, 0)))
HOLLOW = joined(box(1, 1, 1), box(0.8, 0.8, 0.8).flipped())


@pytest.mark.parametrize(
    ("part", "pieces"),
    [
        (box(0.1, 0.2, 0.05), [box(0.1, 0.2, 0.05)]),
        (box(0.1, 0.2, 0.05), [Primitive("box", (0.1, 0.2, 0.05), at(0, 0, 0))]),
        (box(1, 1, 1), [box(0.5, 0.5, 0.5, at=p) for p in itertools.product((-0.25, 0.25), repeat=3)]),
        (HOLLOW, [box(0.5, 1, 1, at=(x, 0, 0)) for x in (-0.25, 0.25)]),
        (HOLLOW, [box(0.6, 1, 1, at=(x, 0, 0)) for x in (-0.2, 0.2)]),
        (OVERLAPPING, [box(0.15, 0.1, 0.1, at=(0.025, 0, 0))]),
    ],
    ids=["itself", "primitive", "eighths", "seam in a cavity", "overlap in a cavity", "overlapping solids"],
)
def test_pieces_that_are_the_part_have_no_error(part, pieces):
    measures = judged(part, *pieces)
    assert measures.by == "boolean"
    assert (measures.extra, measures.missing) == pytest.approx((0, 0), abs=1e-6)
    assert [getattr(measures, name) for name in DISTANCES] == pytest.approx([0] * 4, abs=NOTHING)


@pytest.mark.parametrize("primitive", [False, True])
def test_box_around_a_box(primitive):
    """At its corners it protrudes √3 times as far as at its faces, which have 95 % of its area and more."""
    far, part = 0.01, box(1.0, 1.0, 1.0)
    size = 1 + 2 * far
    around = Primitive("box", (size,) * 3, at(0, 0, 0)) if primitive else box(size, size, size)
    measures = judged(part, around)
    assert (measures.extra, measures.missing) == (pytest.approx(size**3 - 1, abs=2e-6), 0)
    assert (measures.protrusion_p95, measures.protrusion_max) == pytest.approx((far, 3**0.5 * far), rel=1e-3)
    assert measures.bareness_max == 0
    turned = judged(surface_of(around), part)
    assert (turned.extra, turned.missing) == (0, pytest.approx(1 - 1 / size**3, abs=2e-6))
    assert (turned.bareness_p95, turned.bareness_max) == pytest.approx((far, 3**0.5 * far), rel=1e-3)
    assert turned.protrusion_max == 0


def test_ball_around_a_cube():
    radius = math.sqrt(3) / 2
    measures = judged(box(1, 1, 1), Primitive("sphere", (radius,), at(0, 0, 0)))
    assert measures.extra == pytest.approx(4 / 3 * math.pi * radius**3 - 1, abs=2e-3)
    assert measures.protrusion_max == pytest.approx(radius - 0.5, abs=WITHIN * math.sqrt(3))
    assert measures.bareness_max == pytest.approx(0, abs=0.002 * radius)
    assert measures.missing == pytest.approx(0, abs=1e-3)


@pytest.mark.parametrize("kind", ["cylinder", "capsule", "sphere"])
def test_curved_primitive_is_as_near_to_its_mesh_as_facets_are(kind):
    curved = Primitive(kind, (0.05, 0.2)[: 1 if kind == "sphere" else 2], at(0.3, -0.2, 0.1))
    measures = judged(surface_of(curved), curved)
    assert (measures.extra, measures.missing) == pytest.approx((0, 0), abs=1e-6)
    assert max(measures.protrusion_max, measures.bareness_max) < 0.003 * 0.05


def test_disc_over_a_ring_protrudes_by_the_radius_of_the_hole():
    ring = of_mesh(trimesh.creation.annulus(0.04, 0.1, 0.03, sections=96))
    measures = judged(ring, Primitive("cylinder", (0.1, 0.03), at(0, 0, 0)))
    assert measures.protrusion_max == pytest.approx(0.04 * math.cos(math.pi / 96), rel=0.02)
    assert measures.extra == pytest.approx(0.16 / 0.84, rel=5e-3)
    assert measures.bareness_max < 1e-4


def test_gap_between_pieces_is_bare_in_its_middle():
    gap = 0.1
    measures = judged(box(1, 1, 1), *(box(0.45, 1, 1, at=(x, 0, 0)) for x in (-0.275, 0.275)))
    assert measures.missing == pytest.approx(gap, abs=1e-6)
    assert measures.bareness_max == pytest.approx(gap / 2, abs=WITHIN * math.sqrt(3))
    assert measures.protrusion_max == pytest.approx(0, abs=NOTHING)


def test_neither_order_nor_repetition_matters():
    part = of_mesh(trimesh.creation.torus(0.1, 0.03))
    pieces = [Primitive("capsule", (0.03, 0.05), at(0.1, 0, 0)), Primitive("sphere", (0.04,), at(-0.1, 0, 0))]
    pieces += [box(0.1, 0.05, 0.05, at=(0, y, 0)) for y in (0.1, -0.1)]
    target = MeasuredPart.of(part)
    assert measure(target, pieces) == measure(target, pieces[::-1]) == judged(part, *pieces)


def test_larger_collider_protrudes_more_and_bares_less():
    target = MeasuredPart.of(box(0.2, 0.1, 0.05))
    ladder = [measure(target, [box(0.2 + g, 0.1 + g, 0.05 + g)]) for g in (-0.02, 0.0, 0.02)]
    for small, large in itertools.pairwise(ladder):
        for name in ("extra", "protrusion_p95", "protrusion_max"):
            assert getattr(small, name) <= getattr(large, name), name
        for name in ("missing", "bareness_p95", "bareness_max"):
            assert getattr(small, name) >= getattr(large, name), name


def beyond(hull, points):
    """How far points are beyond the planes of a convex mesh."""
    offsets = (hull.triangles[:, 0] * hull.face_normals).sum(axis=1)
    return (points @ hull.face_normals.T - offsets).max(axis=1)


def by_many_points(part, pieces, count):
    """Protrusion and bareness, p95 and max, by many random points; of convex surfaces only."""
    mesh = trimesh.Trimesh(part.vertices, part.triangles, process=False)
    hulls = [trimesh.Trimesh(piece.vertices, piece.triangles, process=False) for piece in pieces]
    area = sum(hull.area for hull in hulls)
    outer = []
    for hull in hulls:
        points = np.concatenate([hull.vertices, hull.sample(int(count * hull.area / area), seed=1)])
        within = [beyond(other, points) < 1e-9 for other in hulls if other is not hull]
        outer.append(points[~np.any([np.zeros(len(points), dtype=bool), *within], axis=0)])
    outer = np.concatenate(outer)
    protrusion = np.where(winding(part, outer) > 0.5, 0.0, distances(mesh, outer))
    points = np.concatenate([mesh.vertices, mesh.sample(count, seed=2)])
    off = [np.where(beyond(hull, points) <= 0, 0.0, distances(hull, points)) for hull in hulls]
    return [
        value for far in (protrusion, np.min(off, axis=0)) for value in (np.quantile(far, 0.95), far.max())
    ]


def distances(mesh, points):
    best = np.full(len(points), np.inf)
    for triangle in mesh.triangles:
        nearest = trimesh.triangles.closest_point(np.repeat(triangle[None], len(points), axis=0), points)
        best = np.minimum(best, np.linalg.norm(points - nearest, axis=1))
    return best


def check_against_many_points(part, pieces, count):
    diagonal = float(np.linalg.norm(np.ptp(part.vertices, axis=0)))
    measures = judged(part, *pieces)
    expected = dict(zip(DISTANCES, by_many_points(part, pieces, count), strict=True))
    slack = WITHIN * diagonal + measures.protrusion_max / 50
    for name, value in expected.items():
        if name.endswith("p95"):
            assert getattr(measures, name) == pytest.approx(value, abs=3 * slack), name
        else:  # many points never reach the maximum quite
            assert value - slack <= getattr(measures, name) <= value + 0.02 * diagonal, name


def random_part(random):
    box_or_ring = trimesh.creation.box((1, 0.6, 0.3)), trimesh.creation.annulus(0.2, 0.5, 0.4, sections=12)
    return of_mesh(box_or_ring[random.integers(2)])


def random_hulls(random, count):
    return [
        convex_hull(random.normal(size=(8, 3)) * random.uniform(0.1, 0.5, 3) + random.uniform(-0.5, 0.5, 3))
        for _ in range(count)
    ]


@settings(max_examples=2)
@given(SEEDS, st.integers(1, 4))
def test_any_part_and_pieces_are_judged_as_by_many_points(seed, count):
    random = np.random.default_rng(seed)
    check_against_many_points(random_part(random), random_hulls(random, count), 2500)


@pytest.mark.slow
@settings(max_examples=3)
@given(SEEDS, st.integers(1, 6))
def test_many_parts_and_pieces_are_judged_as_by_many_points(seed, count):
    random = np.random.default_rng(seed)
    check_against_many_points(random_part(random), random_hulls(random, count), 30_000)


@pytest.mark.slow
@settings(max_examples=5)
@given(SEEDS, st.floats(1e-3, 50.0))
def test_place_and_size_do_not_matter(seed, scale):
    random = np.random.default_rng(seed)
    part = of_mesh(trimesh.creation.annulus(0.2, 0.5, 0.4, sections=24))
    pieces = [box(0.6, 0.5, 0.4, at=(0.2, 0, 0)), box(0.4, 0.9, 0.2)]
    pose = trimesh.transformations.random_rotation_matrix(random.uniform(size=3))
    pose[:3, 3] = random.uniform(-1, 1, 3)
    here = judged(part, *pieces)
    stretch = np.diag([scale, scale, scale, 1.0])
    there = judged(
        transform_surface(transform_surface(part, stretch), pose),
        *(placed(transform_surface(p, stretch), pose) for p in pieces),
    )
    assert (there.extra, there.missing) == pytest.approx((here.extra, here.missing), abs=1e-5)
    for name in DISTANCES:
        expected = pytest.approx(getattr(here, name), abs=3 * WITHIN, rel=0.03)
        assert getattr(there, name) / scale == expected, name


@pytest.mark.parametrize("far", [-0.02, -0.011, -0.005, 0.0, 0.009, 0.011, 0.02])
def test_pieces_are_hopeless_where_they_miss_by_far(far):
    piece = box(1 + 2 * far, 1 + 2 * far, 1 + 2 * far)
    assert is_hopeless(MeasuredPart.of(box(1, 1, 1)), [piece], 0.01) == (abs(far) > 0.01)


@pytest.mark.slow
@settings(max_examples=20)
@given(SEEDS, st.integers(1, 4), st.floats(0.001, 0.5))
def test_nothing_within_the_tolerance_is_hopeless(seed, count, tolerance):
    random = np.random.default_rng(seed)
    target, pieces = MeasuredPart.of(random_part(random)), random_hulls(random, count)
    if is_hopeless(target, pieces, tolerance):
        measures = measure(target, pieces)
        worst = max(measures.bareness_max, measures.protrusion_p95, measures.protrusion_max / 3)
        assert worst > 0.98 * tolerance


@pytest.mark.slow
@settings(max_examples=10)
@given(SEEDS, st.integers(1, 4), st.booleans())
def test_near_agrees_with_measure(seed, count, three_times):
    """A tolerance on either side of what is measured, by the precision of a maximum."""
    random = np.random.default_rng(seed)
    target, pieces = MeasuredPart.of(random_part(random)), random_hulls(random, count)
    times = 3.0 if three_times else 1.0
    measures = measure(target, pieces)
    worst = max(measures.bareness_max, measures.protrusion_p95, measures.protrusion_max / times)
    spare = 2 * WITHIN * target.diagonal
    above, below = 1.05 * worst + spare, 0.95 * worst - spare
    assert is_near(target, pieces, above, times * above)
    if below > 0:
        assert not is_near(target, pieces, below, times * below)


@pytest.mark.parametrize(
    ("beyond", "bare", "expected"), [(0, 0, True), (0.02, 0, False), (0, 0.02, False), (0.009, 0.009, True)]
)
def test_pieces_that_reach_far_or_leave_much_bare_are_not_near(beyond, bare, expected):
    piece = box(1 + beyond - bare, 1, 1, at=((beyond + bare) / 2, 0, 0))
    assert is_near(MeasuredPart.of(box(1, 1, 1)), [piece], 0.01, 0.01) is expected


@pytest.mark.slow
def test_open_part_is_judged_by_sampling_and_hardly_differently():
    whole = of_mesh(trimesh.creation.box((0.2, 0.1, 0.1)).subdivide().subdivide().subdivide())
    around = box(0.21, 0.11, 0.11)
    closed, holed = judged(whole, around), judged(Surface(whole.vertices, whole.triangles[1:]), around)
    assert holed.by == "sampling"
    assert holed.extra == pytest.approx(closed.extra, abs=0.05)
    assert holed.missing == pytest.approx(0, abs=0.02)
    assert holed.protrusion_max == pytest.approx(closed.protrusion_max, rel=0.1)
    assert holed.protrusion_p95 == pytest.approx(closed.protrusion_p95, rel=0.1)
    ring = of_mesh(trimesh.creation.annulus(0.04, 0.1, 0.05))
    pieces = [box(0.15, 0.15, 0.06), Primitive("cylinder", (0.03, 0.3), at(0.08, 0, 0))]
    exact, sampled = judged(ring, *pieces), judged(Surface(ring.vertices, ring.triangles[1:]), *pieces)
    assert (exact.by, sampled.by) == ("boolean", "sampling")
    assert (sampled.extra, sampled.missing) == pytest.approx((exact.extra, exact.missing), abs=0.03)


def test_volume_of_overlapping_solids_counts_once():
    assert MeasuredPart.of(OVERLAPPING).volume == pytest.approx(0.0015)


def test_solids_that_share_an_edge_are_judged_by_booleans():
    both = joined(box(1, 1, 1), box(1, 1, 1, at=(1, 1, 0)))
    pair, _ = weld(both.vertices, both.triangles)
    measures = judged(pair, box(2, 2, 1, at=(0.5, 0.5, 0)))
    assert (measures.by, measures.extra) == ("boolean", pytest.approx(1, abs=1e-6))
    assert measures.protrusion_max == pytest.approx(1, rel=0.02)


def test_sheet_has_no_inside():
    corners = np.array([[0, 0, 0], [0.1, 0, 0], [0.1, 0.1, 0], [0, 0.1, 0.0]])
    sheet = Surface(corners, np.array([[0, 1, 2], [0, 2, 3]]))
    measures = judged(sheet, box(0.1, 0.1, 0.02, at=(0.05, 0.05, 0)))
    assert (measures.extra, measures.missing) == (None, 0)
    assert measures.protrusion_max == pytest.approx(0.01, rel=1e-3)
    assert measures.bareness_max == pytest.approx(0, abs=NOTHING)


@pytest.mark.slow
def test_tangle_is_an_error_and_not_a_wait():
    corners = np.random.default_rng(1).uniform(size=(150_000, 3))
    with pytest.raises(ValueError, match="too many of its faces overlap"):
        MeasuredPart.of(Surface(corners, np.arange(150_000).reshape(-1, 3)))
    few = Surface(corners[:300], np.arange(300).reshape(-1, 3))
    assert judged(few, box(1, 1, 1, at=(0.5, 0.5, 0.5))).bareness_max == 0


def test_nothing_to_measure_is_an_error():
    with pytest.raises(ValueError, match="without pieces"):
        judged(box(1, 1, 1))
    triangle = np.array([[0, 1, 2]])
    for points, triangles in (
        (np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64)),
        (np.full((3, 3), np.nan), triangle),
        (np.zeros((3, 3)), triangle),
    ):
        with pytest.raises(ValueError, match="cannot be measured"):
            MeasuredPart.of(Surface(points, triangles))
