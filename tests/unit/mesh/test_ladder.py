"""The ladder: the cheapest collider within the tolerance, and what happens where there is none."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import trimesh

from linkwright.stages.formats.meshes.surface import Surface, moved
from linkwright.stages.mesh.collide import cut_pieces
from linkwright.stages.mesh.collide.acceptance import miss
from linkwright.stages.mesh.collide.collision import Collision
from linkwright.stages.mesh.colliders import ladder
from linkwright.stages.mesh.configuration.collider_settings import LadderSettings
from linkwright.stages.mesh.surfaces.pieces import half_spaces, signed_distance
from linkwright.stages.robot.model.poses import from_parts, rotation_from_rpy
from linkwright.stages.robot.model.robot import Primitive

SETTINGS = LadderSettings()
ASKEW = from_parts(rotation_from_rpy((0.4, -0.7, 1.1)), np.array([0.1, -0.2, 0.05]))


def surface_of(mesh: trimesh.Trimesh) -> Surface:
    return Surface(np.asarray(mesh.vertices, dtype=float), np.asarray(mesh.faces, dtype=np.int64))


def box(
    lengths: tuple[float, float, float], middle: tuple[float, float, float] = (0, 0, 0)
) -> trimesh.Trimesh:
    return trimesh.creation.box(lengths, trimesh.transformations.translation_matrix(middle))


def union(*meshes: trimesh.Trimesh) -> Surface:
    return surface_of(trimesh.boolean.union(meshes, engine="manifold"))


def less(whole: trimesh.Trimesh, *cut: trimesh.Trimesh) -> Surface:
    return surface_of(trimesh.boolean.difference([whole, *cut], engine="manifold"))


def bracket() -> Surface:
    return union(box((0.1, 0.02, 0.005), (0, 0, 0.0025)), box((0.005, 0.02, 0.08), (-0.0475, 0, 0.04)))


def climbed(surface: Surface, settings: LadderSettings = SETTINGS) -> Collision:
    made = ladder.make([surface], settings)
    return made if made.meets else ladder.improve([surface], settings, made)


def kinds(made: Collision) -> list[str]:
    return sorted(one.kind if isinstance(one, Primitive) else "hull" for one in made.pieces)


WHOLE: list[tuple[str, trimesh.Trimesh, str]] = [
    ("thin plate", box((0.12, 0.08, 0.002)), "box"),
    ("ball", trimesh.creation.icosphere(3, 0.03), "sphere"),
    ("pin", trimesh.creation.capsule(0.08, 0.01), "capsule"),
    ("shaft", trimesh.creation.cylinder(0.02, 0.05, sections=48), "cylinder"),
    ("wedge", trimesh.convex.convex_hull([[0, 0, 0], [0.1, 0, 0], [0, 0.06, 0], [0, 0, 0.08]]), "hull"),
]


@pytest.mark.parametrize(("mesh", "rung"), [row[1:] for row in WHOLE], ids=[row[0] for row in WHOLE])
@pytest.mark.parametrize("pose", [np.eye(4), ASKEW], ids=["straight", "askew"])
def test_a_plain_part_is_one_piece(mesh: trimesh.Trimesh, rung: str, pose: np.ndarray) -> None:
    made = ladder.make([moved(surface_of(mesh), pose)], SETTINGS)
    assert (made.rung, len(made.pieces), made.meets) == (rung, 1, True)
    assert made.measures is not None
    assert made.tolerance is not None
    assert miss(made.measures, made.tolerance) <= 1


def test_a_gear_is_one_piece_with_its_error() -> None:
    turns = np.arange(160) * 2 * np.pi / 160
    radii = 0.02 + 0.0008 * np.sign(np.sin(16 * turns))
    ring = np.stack([radii * np.cos(turns), radii * np.sin(turns)], axis=1)
    points = [[x, y, z] for z in (0.0, 0.01) for x, y in (*ring.tolist(), (0.0, 0.0))]
    here, there = np.arange(160), (np.arange(160) + 1) % 160
    low, high = np.full(160, 160), np.full(160, 321)
    faces = [(low, there, here), (high, 161 + here, 161 + there)]
    faces += [(here, there, 161 + there), (here, 161 + there, 161 + here)]
    gear = Surface(np.array(points), np.concatenate([np.stack(one, axis=1) for one in faces]))
    assert gear.closed()
    made = ladder.make([gear], SETTINGS)
    assert made.rung in ("cylinder", "hull")
    assert made.meets
    assert made.measures is not None
    assert made.measures.protrusion_max > 1e-4


def test_a_bracket_is_two_boxes() -> None:
    surface = bracket()
    made = climbed(surface)
    assert (made.rung, made.meets) == ("pieces", True)
    assert kinds(made) == ["box", "box"]
    # Measured another way: a point of the part is in a box, or as near as the tolerance.
    points, _ = trimesh.sample.sample_surface(
        trimesh.Trimesh(surface.vertices, surface.triangles), 2000, seed=1
    )
    boxes = [one for one in made.pieces if isinstance(one, Primitive)]
    assert np.min([signed_distance(one, points) for one in boxes], axis=0).max() <= made.tolerance


@pytest.mark.slow
def test_what_is_hollow_is_decomposed_and_stays_hollow() -> None:
    tube = trimesh.creation.annulus(0.02, 0.03, 0.04, sections=48)
    made = climbed(surface_of(tube))
    assert (made.rung, made.meets) == ("pieces", True)
    assert len(made.pieces) <= 16
    # A ball of 34 mm goes through the hole of 40 mm.
    for height in np.linspace(-0.03, 0.03, 7):
        for one in made.pieces:
            if isinstance(one, Primitive):
                assert signed_distance(one, np.array([[0, 0, height]]))[0] > 0.017
            else:
                normals, heights = half_spaces(one)
                assert (normals @ [0, 0, height] - heights).max() > 0.017


@pytest.mark.slow
@pytest.mark.parametrize(("most", "rung"), [(2, "hull"), (6, "pieces")])
def test_pieces_that_miss_are_taken_where_they_are_much_nearer_than_the_hull(
    monkeypatch: pytest.MonkeyPatch, most: int, rung: str
) -> None:
    """Halves of a tube leave nothing of its hole open; sixths leave most of it."""
    monkeypatch.setattr(cut_pieces, "MOST_PIECES", most)
    tube = surface_of(trimesh.creation.annulus(0.02, 0.03, 0.04, sections=48))
    made = climbed(tube)
    assert (made.rung, made.meets) == (rung, False)
    assert ("convex pieces" in made.note) == (rung == "hull")
    assert len(made.pieces) == (1 if rung == "hull" else most)


def test_a_larger_tolerance_takes_a_cheaper_rung() -> None:
    assert not ladder.make([bracket()], replace(SETTINGS, extra_volume=100)).meets
    assert ladder.make([bracket()], replace(SETTINGS, tolerance=0.04, extra_volume=100)).meets


def test_extra_volume_bounds_what_one_piece_may_add() -> None:
    plate = less(box((0.1, 0.1, 0.004)), box((0.002, 0.09, 0.01)), box((0.002, 0.09, 0.01), (0.02, 0, 0)))
    assert ladder.make([plate], replace(SETTINGS, tolerance=0.003)).rung == "box"
    strict = ladder.make([plate], replace(SETTINGS, tolerance=0.003, extra_volume=0.001))
    assert (strict.rung, strict.meets) == ("hull", False)


def test_no_piece_has_more_vertices_than_it_may() -> None:
    dome = surface_of(trimesh.creation.icosphere(3, 0.03)).vertices * [1, 0.7, 0.5]
    made = ladder.make([Surface(dome, surface_of(trimesh.creation.icosphere(3, 1)).triangles)], SETTINGS)
    assert made.rung == "hull"
    for limit in (64, 20):
        settings = replace(SETTINGS, max_vertices=limit, tolerance=0.005)
        one = ladder.make([Surface(dome, surface_of(trimesh.creation.icosphere(3, 1)).triangles)], settings)
        assert all(len(piece.vertices) <= limit for piece in one.pieces if isinstance(piece, Surface))


def test_mjx_gets_no_cylinder() -> None:
    shaft = surface_of(trimesh.creation.cylinder(0.02, 0.05, sections=48))
    assert ladder.make([shaft], replace(SETTINGS, target="mjx")).rung == "hull"


def test_several_parts_have_one_collider_where_it_is_as_near() -> None:
    halves = [surface_of(box((0.05, 0.04, 0.03), (x, 0, 0))) for x in (-0.025, 0.025)]
    assert kinds(ladder.together(halves, SETTINGS)) == ["box"]
    apart = [surface_of(box((0.05, 0.04, 0.03), (x, 0, 0))) for x in (-0.06, 0.06)]
    assert not ladder.together(apart, SETTINGS).pieces


@pytest.mark.parametrize(
    "surface",
    [
        Surface(np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64)),
        Surface(np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2]])),
        Surface(np.full((4, 3), np.nan), np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])),
    ],
    ids=["empty", "one triangle", "NaN"],
)
def test_what_has_no_inside_has_no_collider_and_says_why(surface: Surface) -> None:
    made = ladder.make([surface], SETTINGS)
    assert made.pieces == ()
    assert made.note


def test_cavities_that_nothing_reaches_do_not_count() -> None:
    made = ladder.make([less(box((0.1, 0.08, 0.06)), box((0.08, 0.06, 0.04)))], SETTINGS)
    assert (made.rung, made.meets) == ("box", True)


@pytest.mark.slow
def test_the_order_and_place_of_triangles_change_no_figure() -> None:
    surface: Any = bracket()
    turned = Surface(surface.vertices, np.random.default_rng(2).permutation(surface.triangles)[:, [1, 2, 0]])
    one, other = climbed(surface), climbed(turned)
    assert kinds(one) == kinds(other)
    assert one.measures == other.measures
