"""The ladder: the cheapest collider within the tolerance, and what happens where there is none."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh

from linkwright.stages.formats.meshes.surface import Surface, moved
from linkwright.stages.mesh.collide import cut_pieces
from linkwright.stages.mesh.collide.acceptance import miss
from linkwright.stages.mesh.colliders import ladder
from linkwright.stages.mesh.configuration.collider_settings import LadderSettings
from linkwright.stages.mesh.surfaces.pieces import half_spaces, signed_distance
from linkwright.stages.robot.model.poses import from_parts, rotation_from_rpy
from linkwright.stages.robot.model.robot import Primitive
from linkwright.stages.targets.engines import shape_limits
from tests.support.solids import of_mesh
from tests.unit.mesh.test_fit import GEAR

SETTINGS = LadderSettings()
ASKEW = from_parts(rotation_from_rpy((0.4, -0.7, 1.1)), np.array([0.1, -0.2, 0.05]))


def box(x, y, z, at=(0, 0, 0)):
    return trimesh.creation.box((x, y, z), trimesh.transformations.translation_matrix(at))


def less(whole, *cut):
    return of_mesh(trimesh.boolean.difference([whole, *cut], engine="manifold"))


LEGS = [box(0.1, 0.02, 0.005, (0, 0, 0.0025)), box(0.005, 0.02, 0.08, (-0.0475, 0, 0.04))]
BRACKET = of_mesh(trimesh.boolean.union(LEGS, engine="manifold"))
TUBE = of_mesh(trimesh.creation.annulus(0.02, 0.03, 0.04, sections=48))
SHAFT = trimesh.creation.cylinder(0.02, 0.05, sections=48)
BALL = trimesh.creation.icosphere(3, 0.03)


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
        (box(0.12, 0.08, 0.002), "box"),
        (BALL, "sphere"),
        (trimesh.creation.capsule(0.08, 0.01), "capsule"),
        (SHAFT, "cylinder"),
        (trimesh.convex.convex_hull([[0, 0, 0], [0.1, 0, 0], [0, 0.06, 0], [0, 0, 0.08]]), "hull"),
    ],
    ids=["thin plate", "ball", "pin", "shaft", "wedge"],
)
@pytest.mark.parametrize("pose", [np.eye(4), ASKEW], ids=["straight", "askew"])
def test_plain_part_is_one_piece(mesh, rung, pose):
    made = make(moved(of_mesh(mesh), pose))
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
    plate = less(box(0.1, 0.1, 0.004), box(0.002, 0.09, 0.01), box(0.002, 0.09, 0.01, (0.02, 0, 0)))
    assert make(plate, tolerance=0.003).rung == "box"
    strict = make(plate, tolerance=0.003, extra_volume=0.001)
    assert (strict.rung, strict.meets) == ("hull", False)


def test_no_piece_has_more_vertices_than_allowed_and_mjx_gets_no_cylinder():
    dome = Surface(of_mesh(BALL).vertices * [1, 0.7, 0.5], of_mesh(BALL).triangles)
    assert make(dome).rung == "hull"
    for limit in (64, 20):
        (piece,) = make(dome, max_vertices=limit, tolerance=0.005).pieces
        assert not isinstance(piece, Surface) or len(piece.vertices) <= limit
    assert make(of_mesh(SHAFT), limits=shape_limits(["mjx"])).rung == "hull"


@pytest.mark.parametrize(("x", "pieces"), [(0.025, ["box"]), (0.06, [])])
def test_several_parts_have_one_collider_where_it_is_as_near(x, pieces):
    halves = [of_mesh(box(0.05, 0.04, 0.03, (side * x, 0, 0))) for side in (-1, 1)]
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
    made = make(less(box(0.1, 0.08, 0.06), box(0.08, 0.06, 0.04)))
    assert (made.rung, made.meets) == ("box", True)


@pytest.mark.slow
def test_order_and_place_of_triangles_change_no_figure():
    triangles = np.random.default_rng(2).permutation(BRACKET.triangles)[:, [1, 2, 0]]
    original, turned = climbed(BRACKET), climbed(Surface(BRACKET.vertices, triangles))
    assert (kinds(original), original.measures) == (kinds(turned), turned.measures)
