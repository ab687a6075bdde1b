"""Cleaning: poisoned meshes end in solids that face outwards, or in nothing."""

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from linkwright.stages.formats.meshes.surface import Surface, weld
from linkwright.stages.mesh.surfaces.clean import clean
from tests.support.solids import box, joined, of_mesh

PART = box(0.1, 0.1, 0.1)
TRIANGLE = Surface(np.array([[1.0, 1, 1], [1.1, 1, 1], [1, 1.1, 1]]), np.array([[0, 1, 2]]))
NOTHING = Surface(np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64))


def welded(surface):
    return weld(surface.vertices, surface.triangles)[0]


def content(surface):
    return welded(surface).vertices.tolist(), welded(surface).triangles.tolist()


def hollow():
    return joined(box(0.2, 0.2, 0.2), box(0.1, 0.1, 0.1).flipped(), box(0.05, 0.05, 0.05))


@pytest.mark.parametrize(
    ("part", "volumes"),
    [
        (joined(PART, box(0.2, 0.2, 0.2, at=(1, 0, 0))), [0.008, 0.001]),  # the larger first
        (hollow(), [0.008, 0.000125]),
        (hollow().flipped(), [0.008, 0.000125]),
        (joined(box(0.2, 0.2, 0.2), PART), [0.008, 0.001]),
        (joined(box(0.2, 0.2, 0.2), box(0.1, 0.1, 0.1, at=(0.1, 0, 0)).flipped()), [0.008, 0.001]),
        (box(0.1, 0.2, 0.3).flipped(), [0.006]),
        (welded(joined(PART, box(0.1, 0.1, 0.1, at=(0.1, 0.1, 0)))), [0.001, 0.001]),
        (joined(PART, box(0.0009, 0.0009, 0.0009, at=(1, 0, 0))), [0.001]),
        (joined(PART, box(0.0011, 0.0011, 0.0011, at=(1, 0, 0))), [0.001, 0.0011**3]),
        (welded(joined(PART, TRIANGLE)), [0.001]),
    ],
    ids=["beside", "cavity", "cavity inside out", "in the material of another", "crossing", "inside out",
         "edge shared", "crumb", "larger than a crumb", "flat piece beside"],
)  # fmt: skip
def test_shells_become_solids_that_face_outwards(part, volumes):
    cleaned = clean(part)
    assert [solid.volume() for solid in cleaned.solids] == pytest.approx(volumes)
    assert all(solid.is_closed() for solid in cleaned.solids)
    assert cleaned.bodies() == cleaned.solids


def test_sound_mesh_stays_as_it_is():
    part = of_mesh(trimesh.creation.annulus(0.02, 0.05, 0.03))
    cleaned = clean(part)
    assert (len(cleaned.solids), cleaned.loose) == (1, None)
    assert content(cleaned.solids[0]) == content(part)


@settings(max_examples=40)
@given(st.integers(0, 10_000))
def test_any_faces_turned_are_turned_back(seed):
    random = np.random.default_rng(seed)
    shapes = [trimesh.creation.torus(0.1, 0.03, 12, 8), trimesh.creation.box((0.1, 0.2, 0.3))]
    shape = of_mesh(shapes[random.integers(2)])
    part = joined(shape, box(0.05, 0.05, 0.05, at=(1, 1, 1)))
    turned = random.random(len(part.triangles)) < random.uniform(0, 1)
    triangles = np.where(turned[:, None], part.triangles[:, ::-1], part.triangles)
    cleaned = clean(Surface(part.vertices, triangles))
    assert [solid.volume() for solid in cleaned.solids] == pytest.approx([shape.volume(), 0.000125])
    assert all(solid.is_closed() for solid in cleaned.solids)


def test_faces_twice_back_to_back_or_of_bad_corners_are_removed():
    twice = np.concatenate([PART.triangles, PART.triangles[:3], np.roll(PART.triangles[:1], 1)])
    assert content(clean(Surface(PART.vertices, twice)).solids[0]) == content(PART)
    # Two cubes with a wall between them, given by both.
    image = Surface(PART.vertices * [-1, 1, 1] + [0.1, 0, 0], PART.triangles[:, ::-1])
    (both,) = clean(welded(joined(PART, image))).solids
    assert both.volume() == pytest.approx(0.002)
    points = np.concatenate([PART.vertices, [[np.nan, 0, 0], [0, np.inf, 0]]])
    bad = np.array([[0, 1, 8], [9, 2, 3], [0, 1, 99], [-1, 0, 1]])
    assert content(clean(Surface(points, np.concatenate([PART.triangles, bad]))).solids[0]) == content(PART)


@pytest.mark.parametrize(
    "surface",
    [
        NOTHING,
        Surface(np.full((3, 3), np.nan), np.array([[0, 1, 2]])),
        Surface(np.zeros((3, 3)), np.array([[0, 1, 2]])),
        TRIANGLE,
        box(0.1, 0.1, 1e-7),
        welded(joined(TRIANGLE, TRIANGLE.flipped())),
    ],
    ids=["nothing", "not finite", "a point", "triangle", "paper", "sheet"],
)
def test_flat_and_empty_meshes_leave_nothing(surface):
    cleaned = clean(surface)
    assert (cleaned.solids, cleaned.loose) == ((), None)


def moebius():
    """A strip with one side."""
    points = [
        [(1 + w * np.cos(t / 2)) * np.cos(t), (1 + w * np.cos(t / 2)) * np.sin(t), w * np.sin(t / 2)]
        for t in np.linspace(0, 2 * np.pi, 24, endpoint=False)
        for w in (-0.3, 0.3)
    ]
    faces = []
    for k in range(24):
        a, b = 2 * k, 2 * k + 1
        c, d = (a + 2, b + 2) if k < 23 else (1, 0)
        faces += [[a, c, b], [b, c, d]]
    return Surface(np.array(points), np.array(faces))


def sides():
    """Flat pieces by themselves: each side of a box with an edge that no other has."""
    pieces = []
    for axis in range(3):
        for end in (-0.05, 0.05):
            corners = [(-0.05, -0.05), (0.05, -0.05), (0.05, 0.05), (-0.05, 0.05), (0.0, 0.05)]
            points = np.roll(np.array([[end, *corner] for corner in corners]), axis, axis=1)
            pieces.append(Surface(points, np.array([[0, 1, 4], [1, 2, 4], [0, 4, 3]])))
    return joined(*pieces)


@pytest.mark.parametrize(
    ("surface", "faces"),
    [(Surface(PART.vertices, PART.triangles[2:]), 10), (sides(), 18), (moebius(), 48)],
    ids=["open box", "sides that share corners", "one side"],
)
def test_surfaces_that_do_not_close_are_loose(surface, faces):
    cleaned = clean(welded(surface))
    assert cleaned.solids == ()
    assert len(cleaned.loose.triangles) == faces
    assert cleaned.bodies() == (cleaned.loose,)


def test_narrow_cracks_are_closed():
    part = of_mesh(trimesh.creation.icosphere(2, radius=0.1))
    corners = part.corners.reshape(-1, 3)
    corners = corners + np.random.default_rng(1).uniform(-2e-7, 2e-7, corners.shape)
    cracked, _ = weld(corners, np.arange(len(corners)).reshape(-1, 3))
    assert not cracked.is_closed()
    assert clean(cracked).solids[0].volume() == pytest.approx(part.volume(), rel=1e-4)


@settings(max_examples=100)
@given(st.integers(0, 100_000))
def test_any_soup_ends_in_closed_solids_that_face_outwards(seed):
    random = np.random.default_rng(seed)
    points = random.integers(0, 4, (random.integers(1, 20), 3)) * 0.1
    triangles = random.integers(0, len(points), (random.integers(0, 60), 3))
    surface = weld(points, triangles)[0] if len(triangles) else Surface(points, triangles)
    cleaned = clean(surface)
    assert all(solid.is_closed() and solid.volume() > 0 for solid in cleaned.solids)
    assert sum(len(body.triangles) for body in cleaned.bodies()) <= len(surface.triangles)
    order = random.permutation(len(surface.triangles))
    other = clean(welded(Surface(surface.vertices, surface.triangles[order]))) if len(order) else cleaned
    first, second = ([solid.vertices.tobytes() for solid in each.solids] for each in (cleaned, other))
    assert first == second


@pytest.mark.slow
def test_million_faces_are_cleaned():
    part = of_mesh(trimesh.creation.icosphere(8, radius=0.1))
    assert len(part.triangles) > 1_000_000
    assert clean(part.flipped()).solids[0].volume() == pytest.approx(part.volume())
