"""Decimation: fewer triangles, one surface, borders between colours closed, the error measured."""

import subprocess
import sys

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from linkwright.stages.formats.meshes.surface import Surface, weld
from linkwright.stages.mesh.files import stl
from linkwright.stages.mesh.measure import even
from linkwright.stages.mesh.section import VisualSection
from linkwright.stages.mesh.surfaces.neighbours import neighbours
from linkwright.stages.mesh.tessellation import PartMesh
from linkwright.stages.mesh.visuals import budget
from linkwright.stages.mesh.visuals.budget import LEAST_BOUND, Decimator, bound
from linkwright.stages.mesh.visuals.error import apart, farthest
from linkwright.stages.mesh.visuals.make import Drawn, visuals
from linkwright.stages.mesh.visuals.walk import WalkedSurface
from linkwright.stages.robot.model.robot import MeshRef
from linkwright.stages.show.decimate import SNAP, Simplifiable, lowest
from tests.support.places import PROJECT

RED, BLUE = (1.0, 0.0, 0.0, 1.0), (0.0, 0.0, 1.0, 1.0)
ONE, TWO = MeshRef("reply", "one"), MeshRef("reply", "two")


def simplified(mesh: PartMesh, tolerance: float) -> PartMesh | None:
    solid = Simplifiable.of(mesh.surface, mesh.colours, len(mesh.palette))
    return budget.simplified(mesh, solid, tolerance)


def part(mesh: trimesh.Trimesh, split: float | None = None) -> PartMesh:
    """A mesh as a part; where `split` is given, faces above that height are blue."""
    surface, _ = weld(np.asarray(mesh.vertices), np.asarray(mesh.faces).astype(np.int64))
    if split is None:
        return PartMesh(surface, (RED,), np.zeros(len(surface.triangles), dtype=np.int64), True, 1.0)
    above = surface.corners[:, :, 2].mean(axis=1) > split
    return PartMesh(surface, (BLUE, RED), np.where(above, 0, 1), True, 1.0)


def ball(radius: float = 0.05, subdivisions: int = 5) -> trimesh.Trimesh:
    return trimesh.creation.icosphere(subdivisions=subdivisions, radius=radius)


def loaded(mesh: PartMesh) -> trimesh.Trimesh:
    return trimesh.Trimesh(mesh.surface.vertices, mesh.surface.triangles, process=False)


def border(mesh: PartMesh, colour: int) -> set[tuple[bytes, ...]]:
    """The edges of one colour that have no other side within it, as sets of exact points."""
    triangles = mesh.surface.triangles[mesh.colours == colour]
    edges = np.sort(
        np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1
    )
    single, count = np.unique(edges, axis=0, return_counts=True)
    points = mesh.surface.vertices
    return {(points[a].tobytes(), points[b].tobytes()) for a, b in single[count == 1]}


def test_a_ball_keeps_its_shape_within_the_tolerance():
    mesh = part(ball())
    made = simplified(mesh, 1e-3)
    assert len(made.surface.triangles) < len(mesh.surface.triangles) / 10
    result = loaded(made)
    assert result.is_watertight
    assert result.volume > 0
    # The distance from a sphere is known in closed form, whatever measures it.
    samples, _ = trimesh.sample.sample_surface(result, 20000, seed=1)
    away = np.abs(np.linalg.norm(samples, axis=1) - 0.05).max()
    assert away < 2.5e-3
    assert away == pytest.approx(apart(mesh, made, 0.0, 1.0), rel=0.15)


@pytest.mark.slow
def test_two_colours_meet_in_one_line_on_a_curved_and_on_a_flat_side():
    angles = np.linspace(-np.pi / 2, np.pi / 2, 65)
    lump = np.stack([0.05 * np.cos(angles), 0.05 * np.sin(angles)], axis=1)
    lump[[0, -1], 0] = 0.0
    heights = np.linspace(-0.05, 0.05, 33)
    drum = [(0.0, -0.05), *((0.03, height) for height in heights), (0.0, 0.05)]
    for profile, split in ((lump, 0.0), (np.array(drum), 0.0)):
        shape = trimesh.creation.revolve(profile, sections=128)
        mesh = part(shape, split)
        assert len(border(mesh, 0)) > 40
        made = simplified(mesh, 3e-4)
        assert loaded(made).is_watertight
        assert border(made, 0) == border(made, 1)
        assert 3 <= len(border(made, 0)) < len(border(mesh, 0))
        assert apart(mesh, made, 0.0, 1.0) < 1e-3


def test_an_open_sheet_keeps_its_edges():
    x, y = np.meshgrid(np.linspace(0, 0.1, 41), np.linspace(0, 0.2, 41), indexing="ij")
    points = np.stack([x, y, 0.01 * np.sin(40 * x)], axis=-1).reshape(-1, 3)
    corner = (np.arange(40)[:, None] * 41 + np.arange(40)).ravel()
    faces = np.concatenate(
        [np.stack([corner, corner + 41, corner + 42], 1), np.stack([corner, corner + 42, corner + 1], 1)]
    )
    mesh = part(trimesh.Trimesh(points, faces, process=False))
    made = simplified(mesh, 2e-4)
    assert len(made.surface.triangles) < 800
    assert made.surface.vertices.min(axis=0).tolist() == pytest.approx(points.min(axis=0).tolist(), abs=2e-4)
    assert loaded(made).bounds[1].tolist() == pytest.approx(points.max(axis=0).tolist(), abs=2e-4)
    assert loaded(made).area == pytest.approx(loaded(mesh).area, rel=2e-3)
    assert apart(mesh, made, 0.0, 1.0) < 6e-4


def test_three_sheets_on_one_edge_and_turned_triangles_stay_where_they_are():
    sheet = trimesh.creation.box((0.1, 0.1, 0.001)).subdivide().subdivide().subdivide()
    upright = sheet.copy().apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, [1, 0, 0]))
    both = trimesh.util.concatenate([sheet, upright])
    surface, _ = weld(np.asarray(both.vertices), np.asarray(both.faces).astype(np.int64))
    turned = surface.triangles.copy()
    turned[::7] = turned[::7, ::-1]
    mesh = PartMesh(
        Surface(surface.vertices, turned), (RED,), np.zeros(len(turned), dtype=np.int64), False, 0.0
    )
    made = simplified(mesh, 1e-4)
    assert made is None or apart(mesh, made, 0.0, 1.0) < 1e-3


def test_the_distance_is_that_of_a_slow_reference():
    rng = np.random.default_rng(3)
    surface = part(ball(1.0, 2)).surface
    points = rng.normal(size=(40, 3))
    slow = max(
        np.linalg.norm(
            trimesh.triangles.closest_point(surface.corners, np.repeat(one[None], len(surface.triangles), 0))
            - one,
            axis=1,
        ).min()
        for one in points
    )
    assert farthest(points, surface, 0.0, 9.0) == pytest.approx(slow, abs=1e-12)


def test_walked_distances_are_never_too_small_and_the_largest_is_exact():
    # A tube of long slivers, two sheets that share its end without a common edge, and turned triangles.
    tube = trimesh.creation.annulus(0.02, 0.03, 0.2, sections=64)
    sheets = [trimesh.creation.box((0.08, 0.05, 1e-4), trimesh.transformations.translation_matrix([0, 0, z]))
              for z in (0.0999, 0.1002)]  # fmt: skip
    both = trimesh.util.concatenate([tube, *sheets])
    surface, _ = weld(np.asarray(both.vertices), np.asarray(both.faces).astype(np.int64))
    turned = surface.triangles.copy()
    turned[::5] = turned[::5, ::-1]
    rng = np.random.default_rng(7)
    for triangles in (surface.triangles, turned):
        target = Surface(surface.vertices, triangles)
        points = even(target.corners, 500).points + rng.normal(scale=2e-3, size=(500, 3))
        slow = np.array(
            [
                np.linalg.norm(
                    trimesh.triangles.closest_point(target.corners, np.repeat(one[None], len(triangles), 0))
                    - one,
                    axis=1,
                ).min()
                for one in points
            ]
        )
        walked = WalkedSurface.of(target).bounds(points, 1e-3)
        assert (walked >= slow - 1e-12).all()
        assert np.median(walked - slow) < 1e-3
        for enough in (0.0, 1e-3):
            assert farthest(points, target, enough, 9.0) == pytest.approx(slow.max(), abs=1e-12)


def test_neighbours_are_those_across_an_edge_in_the_opposite_sense():
    # A square of two triangles, and a third one on its diagonal in the same sense as the first.
    across = neighbours(
        Surface(
            np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1]]),
            np.array([[0, 1, 2], [0, 2, 3], [2, 0, 4]]),
        )
    )
    assert across[0].tolist() == [0, 0, 1]
    assert across[1].tolist()[1:] == [1, 1]
    assert across[1, 0] in (0, 2)
    assert across[2].tolist() == [1, 2, 2]
    assert (neighbours(part(trimesh.creation.box()).surface) != np.arange(12)[:, None]).all()


@given(falls=st.lists(st.integers(0, 400), max_size=12), most=st.integers(0, 1500))
def test_the_lowest_level_is_that_of_a_plain_search(falls, most):
    counts = np.cumsum([0, *falls])[::-1].tolist()
    plain = next((level for level, count in enumerate(counts) if count <= most), len(counts))
    assert lowest(len(counts), counts.__getitem__, most) == plain


def test_a_manifold_of_a_part_is_made_once_for_all_levels(monkeypatch):
    made = []
    of = Simplifiable.of
    monkeypatch.setattr(Simplifiable, "of", staticmethod(lambda *mesh: made.append(mesh) or of(*mesh)))
    mesh = part(ball())
    Decimator().fitted([ONE], {ONE: mesh}, 6000)
    assert len(made) == 1


def test_the_distance_from_a_sliver_is_exact():
    sliver = Surface(np.array([[0, 0, 0], [1, 0, 0], [0.5, 1e-9, 0]]), np.array([[0, 1, 2]]))
    assert farthest(np.array([[0.3, 0.0, 0.2]]), sliver, 0.0, 9.0) == pytest.approx(0.2)
    assert farthest(np.array([[1.5, 0.0, 0.0]]), sliver, 0.0, 9.0) == pytest.approx(0.5)


def test_a_colour_that_is_gone_is_infinitely_far():
    mesh = part(ball(), 0.01)
    one = PartMesh(mesh.surface, mesh.palette, np.ones_like(mesh.colours), True, 1.0)
    assert apart(mesh, one, 0.0, 1.0) == np.inf


def test_points_are_spread_by_area():
    mesh = part(trimesh.creation.box((1.0, 1.0, 0.1))).surface
    inside = np.abs(np.abs(even(mesh.corners, 10000).points[:, 2]) - 0.05) < 1e-12
    assert inside.mean() == pytest.approx(2 / 2.4, abs=0.01)


def test_triangles_go_where_the_surface_needs_them():
    # The cube needs 12 of its triangles, the ball all that it can get.
    cube = trimesh.creation.box((0.1, 0.1, 0.1))
    for _ in range(5):
        cube = cube.subdivide()
    meshes = {ONE: part(cube), TWO: part(ball())}
    fitted, decimation = Decimator().fitted([ONE, TWO, TWO], meshes, 8000)
    faces = {ref: len(mesh.surface.triangles) for ref, mesh in fitted.items()}
    assert faces[ONE] == 12
    assert 4000 < 12 + 2 * faces[TWO] <= 8000
    assert (decimation.before, decimation.after) == (12288 + 2 * 20480, 12 + 2 * faces[TWO])
    assert not decimation.limited
    assert 0 < decimation.error <= bound(meshes[TWO].surface)


def test_what_the_bound_forbids_is_kept_and_said():
    mesh = part(ball())
    fitted, decimation = Decimator().fitted([ONE], {ONE: mesh}, 10)
    assert decimation.limited
    assert decimation.after > 10
    assert bound(mesh.surface) > LEAST_BOUND
    assert apart(mesh, fitted[ONE], 0.0, 1.0) <= decimation.error + 1e-12 <= bound(mesh.surface) + 1e-12


def test_few_triangles_stay_exactly_as_they_are():
    mesh = part(ball())
    fitted, decimation = Decimator().fitted([ONE], {ONE: mesh}, len(mesh.surface.triangles))
    assert decimation is None
    assert fitted[ONE] is mesh


def test_a_part_within_the_budget_imports_no_library_that_decimates_or_collides():
    code = (
        "import sys, numpy\n"
        "import linkwright.stages.mesh.geometry\n"
        "from linkwright.stages.formats.meshes.surface import Surface\n"
        "from linkwright.stages.mesh.tessellation import PartMesh\n"
        "from linkwright.stages.mesh.visuals.budget import Decimator\n"
        "from linkwright.stages.robot.model.robot import MeshRef\n"
        "few = numpy.zeros((4, 3), dtype=int)\n"
        "mesh = PartMesh(Surface(numpy.eye(3), few), ((1, 0, 0, 1),), few[:, 0], False, 0.0)\n"
        "ref = MeshRef('reply', 'one')\n"
        "assert Decimator().fitted([ref], {ref: mesh}, 4)[1] is None\n"
        "heavy = 'manifold3d trimesh coacd mujoco scipy'.split()\n"
        "print([name for name in heavy if name in sys.modules])"
    )
    run = subprocess.run(
        [sys.executable, "-c", code], cwd=PROJECT, capture_output=True, text=True, check=True
    )
    assert run.stdout.strip() == "[]"


def test_a_mesh_that_does_not_simplify_stays(monkeypatch):
    monkeypatch.setattr("linkwright.stages.mesh.visuals.budget.simplified", lambda *_: None)
    mesh = part(ball())
    fitted, decimation = Decimator().fitted([ONE], {ONE: mesh}, 10)
    assert fitted[ONE] is mesh
    assert (decimation.after, decimation.limited, decimation.error) == (20480, True, 0.0)


def test_flat_colours_count_with_their_backs():
    x, y = np.meshgrid(np.linspace(0, 0.1, 31), np.linspace(0, 0.1, 31), indexing="ij")
    points = np.stack([x, y, np.zeros_like(x)], axis=-1).reshape(-1, 3)
    corner = (np.arange(30)[:, None] * 31 + np.arange(30)).ravel()
    faces = np.stack([corner, corner + 31, corner + 32], 1), np.stack([corner, corner + 32, corner + 1], 1)
    mesh = part(trimesh.Trimesh(points, np.concatenate(faces), process=False))
    made = visuals([Drawn(0, ONE, np.eye(4))], {ONE: mesh}, VisualSection(max_faces=1800), Decimator())
    assert sum(file.faces for file in made.files) <= 1800
    assert made.decimation is not None


@pytest.mark.slow
@settings(max_examples=10, deadline=None)
@given(seed=st.integers(0, 10**6), most=st.integers(50, 320))
def test_any_lump_fits_its_number_or_its_bound_whatever_the_order(seed, most):
    rng = np.random.default_rng(seed)
    shape = trimesh.creation.icosphere(subdivisions=2, radius=0.05)
    shape.vertices *= 1 + 0.15 * np.sin(rng.uniform(5, 60, 3) * shape.vertices).sum(axis=1, keepdims=True)
    mesh = part(shape, 0.0)
    shuffled = trimesh.Trimesh(shape.vertices, shape.faces[rng.permutation(len(shape.faces))], process=False)
    again = part(shuffled, 0.0)
    fitted, decimation = Decimator().fitted([ONE], {ONE: mesh}, most)
    other, _ = Decimator().fitted([ONE], {ONE: again}, most)
    assert np.array_equal(fitted[ONE].surface.vertices, other[ONE].surface.vertices)
    assert np.array_equal(fitted[ONE].surface.triangles, other[ONE].surface.triangles)
    if decimation is None:
        return
    assert decimation.limited == (len(fitted[ONE].surface.triangles) > most)
    most_apart = bound(mesh.surface)
    assert apart(mesh, fitted[ONE], most_apart / 2, 1.0) <= most_apart + 1e-12
    assert loaded(fitted[ONE]).is_watertight == loaded(mesh).is_watertight
    step = SNAP * np.linalg.norm(np.ptp(mesh.surface.vertices, axis=0))
    if fitted[ONE] is not mesh:
        multiples = fitted[ONE].surface.vertices / step
        assert np.abs(multiples - np.round(multiples)).max() < 1e-3


def test_a_mirrored_part_is_the_mirror_image_of_the_other():
    mesh = part(ball(), 0.0)
    mirror = np.diag([-1.0, 1.0, 1.0, 1.0])
    drawn = [Drawn(0, ONE, np.eye(4)), Drawn(1, ONE, mirror)]
    made = visuals(drawn, {ONE: mesh}, VisualSection(max_faces=8000, merge="part"), Decimator())
    assert made.owners == (0, 0, 1, 1)
    assert made.decimation.after <= 8000
    for plain, turned in zip(made.files[:2], made.files[2:], strict=True):
        assert plain.colour == turned.colour
        points, mirrored = stl.read(plain.data), stl.read(turned.data)
        flipped = (points * [-1, 1, 1])[:, ::-1] + 0.0
        assert {tuple(sorted(map(tuple, one))) for one in flipped.tolist()} == {
            tuple(sorted(map(tuple, one))) for one in mirrored.tolist()
        }
        assert turned.area == pytest.approx(plain.area, rel=1e-12)
