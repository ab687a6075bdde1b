"""Cleaning: poisoned meshes end in solids that face outwards, or in nothing."""

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from linkwright.stages.formats.meshes.surface import Surface, weld
from linkwright.stages.mesh.surfaces.clean import clean
from tests.support.solids import box, joined, of_mesh


def again_welded(surface):
    welded, _ = weld(surface.vertices, surface.triangles)
    return welded


def same(one, other):
    return (
        again_welded(one).vertices.tolist() == again_welded(other).vertices.tolist()
        and again_welded(one).triangles.tolist() == again_welded(other).triangles.tolist()
    )


def test_a_sound_mesh_stays_as_it_is():
    part = of_mesh(trimesh.creation.annulus(0.02, 0.05, 0.03))
    found = clean(part)
    assert (len(found.solids), found.loose) == (1, None)
    assert same(found.solids[0], part)
    assert found.bodies() == found.solids


def test_two_shells_are_two_solids_the_larger_first():
    found = clean(joined(box(0.1, 0.1, 0.1), box(0.2, 0.2, 0.2, at=(1, 0, 0))))
    assert [solid.volume() for solid in found.solids] == pytest.approx([0.008, 0.001])


@pytest.mark.parametrize("whole_inverted", [False, True])
def test_a_cavity_goes_and_what_is_in_it_stays(whole_inverted):
    part = joined(box(0.2, 0.2, 0.2), box(0.1, 0.1, 0.1).flipped(), box(0.05, 0.05, 0.05))
    found = clean(part.flipped() if whole_inverted else part)
    assert [solid.volume() for solid in found.solids] == pytest.approx([0.008, 0.000125])


def test_a_solid_in_the_material_of_another_is_one_of_its_own():
    found = clean(joined(box(0.2, 0.2, 0.2), box(0.1, 0.1, 0.1)))
    assert [solid.volume() for solid in found.solids] == pytest.approx([0.008, 0.001])


def test_shells_beside_each_other_or_crossing_are_in_nothing():
    found = clean(joined(box(0.2, 0.2, 0.2), box(0.1, 0.1, 0.1, at=(0.1, 0.0, 0.0)).flipped()))
    assert [solid.volume() for solid in found.solids] == pytest.approx([0.008, 0.001])


@settings(max_examples=40)
@given(st.integers(0, 10_000))
def test_any_faces_turned_are_turned_back(seed):
    random = np.random.default_rng(seed)
    shape = [trimesh.creation.torus(0.1, 0.03, 12, 8), trimesh.creation.box((0.1, 0.2, 0.3))][
        random.integers(2)
    ]
    part = joined(of_mesh(shape), box(0.05, 0.05, 0.05, at=(1, 1, 1)))
    turned = random.random(len(part.triangles)) < random.uniform(0, 1)
    triangles = np.where(turned[:, None], part.triangles[:, ::-1], part.triangles)
    found = clean(Surface(part.vertices, triangles))
    assert [solid.volume() for solid in found.solids] == pytest.approx([of_mesh(shape).volume(), 0.000125])
    assert all(solid.closed() for solid in found.solids)


def test_inside_out_is_turned():
    found = clean(box(0.1, 0.2, 0.3).flipped())
    assert found.solids[0].volume() == pytest.approx(0.006)


def test_faces_twice_and_faces_back_to_back_go():
    part = box(0.1, 0.1, 0.1)
    twice = Surface(
        part.vertices, np.concatenate([part.triangles, part.triangles[:3], np.roll(part.triangles[:1], 1)])
    )
    found = clean(twice)
    assert same(found.solids[0], part)
    # Two cubes with a wall between them, given by both.
    image = Surface(part.vertices * [-1, 1, 1] + [0.1, 0, 0], part.triangles[:, ::-1])
    found = clean(again_welded(joined(part, image)))
    assert [solid.volume() for solid in found.solids] == pytest.approx([0.002])


def test_cubes_that_share_an_edge_are_two_solids():
    found = clean(again_welded(joined(box(0.1, 0.1, 0.1), box(0.1, 0.1, 0.1, at=(0.1, 0.1, 0)))))
    assert [solid.volume() for solid in found.solids] == pytest.approx([0.001, 0.001])
    assert all(solid.closed() for solid in found.solids)


def test_corners_that_are_not_finite_or_not_there_go():
    part = box(0.1, 0.1, 0.1)
    points = np.concatenate([part.vertices, [[np.nan, 0, 0], [0, np.inf, 0]]])
    bad = np.array([[0, 1, 8], [9, 2, 3], [0, 1, 99], [-1, 0, 1]])
    found = clean(Surface(points, np.concatenate([part.triangles, bad])))
    assert same(found.solids[0], part)


@pytest.mark.parametrize(
    "surface",
    [
        Surface(np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64)),
        Surface(np.full((3, 3), np.nan), np.array([[0, 1, 2]])),
        Surface(np.zeros((3, 3)), np.array([[0, 1, 2]])),
    ],
)
def test_nothing_is_nothing(surface):
    found = clean(surface)
    assert found.solids == ()
    assert found.loose is None


def test_flat_pieces_go():
    triangle = Surface(np.array([[1.0, 1, 1], [1.1, 1, 1], [1, 1.1, 1]]), np.array([[0, 1, 2]]))
    alone = clean(triangle)
    assert (alone.solids, alone.loose) == ((), None)
    beside = clean(again_welded(joined(box(0.1, 0.1, 0.1), triangle)))
    assert len(beside.solids) == 1
    paper = clean(box(0.1, 0.1, 1e-7))
    assert paper.solids == ()
    assert paper.loose is None
    sheet = clean(again_welded(joined(triangle, triangle.flipped())))
    assert (sheet.solids, sheet.loose) == ((), None)


def test_an_open_box_is_loose():
    part = box(0.1, 0.1, 0.1)
    found = clean(Surface(part.vertices, part.triangles[2:]))
    assert found.solids == ()
    assert len(found.loose.triangles) == 10
    assert found.bodies() == (found.loose,)


def test_faces_that_only_share_corners_are_a_box_together():
    """Flat pieces by themselves: each side of a box with an edge that no other has."""
    sides = []
    for axis in range(3):
        for end in (-0.05, 0.05):
            square = np.array(
                [[end, a, b] for a, b in [(-0.05, -0.05), (0.05, -0.05), (0.05, 0.05), (-0.05, 0.05)]]
            )
            middle = [[end, 0.0, 0.05]]
            corners = np.roll(np.concatenate([square, middle]), axis, axis=1)
            sides.append(Surface(corners, np.array([[0, 1, 4], [1, 2, 4], [0, 4, 3]])))
    found = clean(again_welded(joined(*sides)))
    assert found.loose is not None


def test_narrow_cracks_are_closed():
    part = of_mesh(trimesh.creation.icosphere(2, radius=0.1))
    corners = part.corners.reshape(-1, 3) + np.random.default_rng(1).uniform(
        -2e-7, 2e-7, (len(part.triangles) * 3, 3)
    )
    cracked, _ = weld(corners, np.arange(len(corners)).reshape(-1, 3))
    assert not cracked.closed()
    found = clean(cracked)
    assert found.solids[0].volume() == pytest.approx(part.volume(), rel=1e-4)


def test_crumbs_are_dropped():
    crumb = box(0.0009, 0.0009, 0.0009, at=(1, 0, 0))
    found = clean(joined(box(0.1, 0.1, 0.1), crumb))
    assert [solid.volume() for solid in found.solids] == pytest.approx([0.001])
    larger = clean(joined(box(0.1, 0.1, 0.1), box(0.0011, 0.0011, 0.0011, at=(1, 0, 0))))
    assert len(larger.solids) == 2


def test_a_strip_with_one_side_is_loose():
    turns = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    rim = np.array(
        [
            [(1 + w * np.cos(t / 2)) * np.cos(t), (1 + w * np.cos(t / 2)) * np.sin(t), w * np.sin(t / 2)]
            for t in turns
            for w in (-0.3, 0.3)
        ]
    )
    faces = []
    for k in range(24):
        a, b, c, d = 2 * k, 2 * k + 1, (2 * k + 2) % 48, (2 * k + 3) % 48
        if k == 23:
            c, d = d, c
        faces += [[a, c, b], [b, c, d]]
    found = clean(again_welded(Surface(rim, np.array(faces))))
    assert found.solids == ()
    assert len(found.loose.triangles) == 48


@settings(max_examples=100)
@given(st.integers(0, 100_000))
def test_any_soup_ends_in_solids_that_are_closed_and_face_outwards(seed):
    random = np.random.default_rng(seed)
    points = random.integers(0, 4, (random.integers(1, 20), 3)) * 0.1
    triangles = random.integers(0, len(points), (random.integers(0, 60), 3))
    surface, _ = weld(points, triangles) if len(triangles) else (Surface(points, triangles), None)
    found = clean(surface)
    for solid in found.solids:
        assert solid.closed()
        assert solid.volume() > 0
    assert sum(len(one.triangles) for one in found.bodies()) <= len(surface.triangles)
    order = random.permutation(len(surface.triangles))
    other = clean(
        again_welded(Surface(surface.vertices, surface.triangles[order])) if len(order) else surface
    )
    assert [solid.vertices.tobytes() for solid in other.solids] == [
        s.vertices.tobytes() for s in found.solids
    ]


@pytest.mark.slow
def test_a_million_faces_are_cleaned():
    part = of_mesh(trimesh.creation.icosphere(8, radius=0.1))
    found = clean(part.flipped())
    assert len(part.triangles) > 1_000_000
    assert found.solids[0].volume() == pytest.approx(part.volume())
