"""The ladder: the cheapest collider within the tolerance, and what happens where there is none."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh

from linkwright.stages.formats.meshes.surface import Surface, transform_surface
from linkwright.stages.mesh.collide import cut_pieces
from linkwright.stages.mesh.collide.acceptance import miss
from linkwright.stages.mesh.collide.merge_across_parts import merge_across_parts
from linkwright.stages.mesh.colliders import ladder
from linkwright.stages.mesh.configuration.collider_settings import LadderSettings
from linkwright.stages.mesh.surfaces.pieces import half_spaces, signed_distance, volume
from linkwright.stages.robot.model.poses import from_parts, rotation_from_rpy
from linkwright.stages.robot.model.robot import Primitive, frozen
from linkwright.stages.targets.engines import shape_limits
from tests.support.cases import mostly_slow
from tests.support.fidelity import Hull, fidelity
from tests.support.solids import box, joined, of_mesh
from tests.unit.mesh.test_fit import GEAR

SETTINGS = LadderSettings()
ASKEW = from_parts(rotation_from_rpy((0.4, -0.7, 1.1)), np.array([0.1, -0.2, 0.05]))


def solid(x, y, z, at=(0, 0, 0)):
    return trimesh.creation.box((x, y, z), trimesh.transformations.translation_matrix(at))


def less(whole, *cut):
    return of_mesh(trimesh.boolean.difference([whole, *cut], engine="manifold"))


LEGS = [solid(0.1, 0.02, 0.005, (0, 0, 0.0025)), solid(0.005, 0.02, 0.08, (-0.0475, 0, 0.04))]
BRACKET = of_mesh(trimesh.boolean.union(LEGS, engine="manifold"))
TUBE = of_mesh(trimesh.creation.annulus(0.02, 0.03, 0.04, sections=48))
SHAFT = trimesh.creation.cylinder(0.02, 0.05, sections=24)
BALL = trimesh.creation.icosphere(2, 0.03)


def make(surface, **settings):
    return ladder.make([surface], replace(SETTINGS, **settings))


def climbed(surface):
    made = make(surface)
    return made if made.meets else ladder.improve([surface], SETTINGS, made)


def kinds(made):
    return sorted(piece.kind if isinstance(piece, Primitive) else "hull" for piece in made.pieces)


@pytest.mark.parametrize(
    ("mesh", "rung"),
    [
        (solid(0.12, 0.08, 0.002), "box"),
        (BALL, "sphere"),
        (trimesh.creation.capsule(0.08, 0.01, count=[16, 16]), "capsule"),
        (SHAFT, "cylinder"),
        (trimesh.convex.convex_hull([[0, 0, 0], [0.1, 0, 0], [0, 0.06, 0], [0, 0, 0.08]]), "hull"),
    ],
    ids=["thin plate", "ball", "pin", "shaft", "wedge"],
)
@pytest.mark.parametrize("pose", mostly_slow([np.eye(4), ASKEW], 1), ids=["straight", "askew"])
def test_plain_part_is_one_piece(mesh, rung, pose):
    made = make(transform_surface(of_mesh(mesh), pose))
    assert (made.rung, len(made.pieces), made.meets) == (rung, 1, True)
    assert miss(made.measures, made.tolerance) <= 1


def test_gear_is_one_piece_with_its_error():
    made = make(GEAR)
    assert (made.rung in ("cylinder", "hull"), made.meets) == (True, True)
    assert made.measures.protrusion_max > 1e-4


def test_bracket_is_two_boxes():
    made = climbed(BRACKET)
    assert (made.rung, made.meets, kinds(made)) == ("pieces", True, ["box", "box"])
    # Measured another way: a point of the part is in a box, or as near as the tolerance.
    mesh = trimesh.Trimesh(BRACKET.vertices, BRACKET.triangles)
    points, _ = trimesh.sample.sample_surface(mesh, 2000, seed=1)
    assert np.min([signed_distance(box, points) for box in made.pieces], axis=0).max() <= made.tolerance


@pytest.mark.slow
def test_hollow_part_is_decomposed_and_stays_hollow():
    made = climbed(TUBE)
    assert (made.rung, made.meets) == ("pieces", True)
    assert len(made.pieces) <= 16
    # A ball of 34 mm goes through the hole of 40 mm.
    places = np.array([[0, 0, height] for height in np.linspace(-0.03, 0.03, 7)])
    for piece in made.pieces:
        if isinstance(piece, Primitive):
            assert signed_distance(piece, places).min() > 0.017
        else:
            normals, heights = half_spaces(piece)
            assert (places @ normals.T - heights).max(axis=1).min() > 0.017


@pytest.mark.slow
@pytest.mark.parametrize(("most", "rung"), [(2, "hull"), (6, "pieces")])
def test_pieces_that_miss_are_taken_where_they_are_much_nearer(monkeypatch, most, rung):
    """Halves of a tube leave nothing of its hole open; sixths leave most of it."""
    monkeypatch.setattr(cut_pieces, "MAX_PIECES", most)
    made = climbed(TUBE)
    assert (made.rung, made.meets) == (rung, False)
    assert ("convex pieces" in made.note) == (rung == "hull")
    assert len(made.pieces) == (1 if rung == "hull" else most)


def test_larger_tolerance_takes_a_cheaper_rung():
    assert not make(BRACKET, extra_volume=100).meets
    assert make(BRACKET, tolerance=0.04, extra_volume=100).meets


def test_extra_volume_bounds_the_volume_of_one_piece():
    plate = less(solid(0.1, 0.1, 0.004), solid(0.002, 0.09, 0.01), solid(0.002, 0.09, 0.01, (0.02, 0, 0)))
    assert make(plate, tolerance=0.003).rung == "box"
    strict = make(plate, tolerance=0.003, extra_volume=0.001)
    assert (strict.rung, strict.meets) == ("hull", False)


def test_piece_has_no_more_vertices_than_allowed():
    dome = Surface(of_mesh(BALL).vertices * [1, 0.7, 0.5], of_mesh(BALL).triangles)
    assert make(dome).rung == "hull"
    for limit in (64, 20):
        (piece,) = make(dome, max_vertices=limit, tolerance=0.005).pieces
        assert not isinstance(piece, Surface) or len(piece.vertices) <= limit
    assert make(of_mesh(SHAFT), limits=shape_limits(["mjx"])).rung == "hull"


@pytest.mark.parametrize(("x", "pieces"), [(0.025, ["box"]), (0.06, [])])
def test_several_parts_have_one_collider_where_it_is_as_near(x, pieces):
    halves = [of_mesh(solid(0.05, 0.04, 0.03, (side * x, 0, 0))) for side in (-1, 1)]
    assert kinds(ladder.together(halves, SETTINGS)) == pieces


@pytest.mark.parametrize(
    ("points", "triangles"),
    [
        (np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64)),
        (np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2]])),
        (np.full((4, 3), np.nan), np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])),
    ],
    ids=["empty", "one triangle", "NaN"],
)
def test_part_without_an_inside_has_no_collider_and_a_reason(points, triangles):
    made = make(Surface(points, triangles))
    assert made.pieces == ()
    assert made.note


def test_cavities_that_nothing_reaches_do_not_count():
    made = make(less(solid(0.1, 0.08, 0.06), solid(0.08, 0.06, 0.04)))
    assert (made.rung, made.meets) == ("box", True)


@pytest.mark.slow
def test_order_and_place_of_triangles_change_no_figure():
    triangles = np.random.default_rng(2).permutation(BRACKET.triangles)[:, [1, 2, 0]]
    original, turned = climbed(BRACKET), climbed(Surface(BRACKET.vertices, triangles))
    assert (kinds(original), original.measures) == (kinds(turned), turned.measures)


FINE = LadderSettings(tolerance=0.001)


def ells(gap=0.0):
    """Two L-shaped parts of two boxes each, together a block of 60 × 40 × 20 mm, or that far apart."""
    lower = [box(0.06, 0.02, 0.02, at=(0, -0.01, 0)), box(0.02, 0.02, 0.02, at=(-0.02, 0.01, 0))]
    upper = [box(0.02, 0.02, 0.02, at=(x + gap, 0.01, 0)) for x in (0, 0.02)]
    return [joined(*lower), joined(*upper)], [*lower, *upper]


def test_pieces_of_two_parts_that_are_one_block_become_one():
    parts, pieces = ells()
    result = merge_across_parts(parts, pieces, FINE)
    assert result.meets
    (piece,) = result.pieces
    assert volume(piece) == pytest.approx(0.06 * 0.04 * 0.02, rel=1e-5)
    measures = result.measures
    assert (measures.protrusion_max, measures.bareness_max) == pytest.approx((0, 0), abs=1e-5)
    # As near as an independent measurement says.
    seen = [trimesh.Trimesh(part.vertices, part.triangles) for part in parts]
    assert fidelity(seen, [Hull(piece.vertices)], [0.001, 0.001], points=2000).miss < 0.3


def test_gap_that_is_wider_than_the_tolerance_allows_stays_open():
    pieces = merge_across_parts(*ells(gap=0.01), FINE).pieces
    # The lower part has two sides of its own; the two boxes of the upper part are joined.
    assert len(pieces) == 3
    for piece in pieces:
        assert Hull(piece.vertices).planes(np.array([[-0.005, 0.01, 0.0]]))[0] > 0.004
    parts, _ = ells(gap=0.1)
    _, touching = ells()
    far = box(0.04, 0.02, 0.02, at=(0.11, 0.01, 0))
    assert not merge_across_parts(parts, [*touching[:2], far], FINE).pieces


@pytest.mark.parametrize(("size", "count"), [(0.4, 1), (0.04, 2)])
def test_every_part_counts_by_its_own_tolerance(size, count):
    """A step of 2 mm between two blocks: within the tolerance of large parts, not of small parts."""
    heights = {0.0: size / 4, size: size / 4 - 0.004}
    blocks = [box(size, size, height, at=(x, 0, 0)) for x, height in heights.items()]
    # Each in two halves, so that there is something to join at all.
    halves = [
        box(size / 2, size, height, at=(x + side * size / 4, 0, 0))
        for x, height in heights.items()
        for side in (-1, 1)
    ]
    assert len(merge_across_parts(blocks, halves, LadderSettings()).pieces) == count


def test_primitives_among_pieces_stay_or_are_within_others():
    ball = Primitive("sphere", (0.01,), frozen(np.eye(4)))
    far = [box(0.02, 0.02, 0.02, at=(x, 0, 0)) for x in (0.1, 0.12)]
    parts = [box(0.0115, 0.0115, 0.0115), joined(*far)]
    pieces = merge_across_parts(parts, [ball, *far], LadderSettings(tolerance=0.006)).pieces
    (kept,) = [piece for piece in pieces if isinstance(piece, Primitive)]
    assert signed_distance(kept, np.zeros((1, 3)))[0] == pytest.approx(-0.01)
    assert len(pieces) == 2
