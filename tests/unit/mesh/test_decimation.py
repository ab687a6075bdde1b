"""Decimation: fewer triangles, one surface, borders between colours closed, the error measured."""

import subprocess
import sys

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from linkwright.stages.formats.meshes.surface import Surface
from linkwright.stages.mesh.files import stl
from linkwright.stages.mesh.measure import evenly_spread
from linkwright.stages.mesh.part_mesh import PartMesh
from linkwright.stages.mesh.section import VisualSection
from linkwright.stages.mesh.surfaces.neighbours import neighbours
from linkwright.stages.mesh.visuals import budget
from linkwright.stages.mesh.visuals.budget import MIN_BOUND, Decimator, bound
from linkwright.stages.mesh.visuals.error import farthest, hausdorff_bound
from linkwright.stages.mesh.visuals.make import DrawnPart, make_visuals
from linkwright.stages.mesh.visuals.walk import WalkedSurface
from linkwright.stages.robot.model.robot import MeshRef
from linkwright.stages.show.decimate import SNAP, Simplifiable, lowest_level
from tests.support.places import PROJECT
from tests.support.solids import of_mesh

RED, BLUE = (1.0, 0.0, 0.0, 1.0), (0.0, 0.0, 1.0, 1.0)
FIRST, SECOND = MeshRef("reply", "first"), MeshRef("reply", "second")


def simplified(mesh, tolerance):
    solid = Simplifiable.of(mesh.surface, mesh.colours, len(mesh.palette))
    return budget.simplified(mesh, solid, tolerance)


def part(mesh, split=None):
    """A mesh as a part; where `split` is given, faces above that height are blue."""
    surface = of_mesh(mesh)
    if split is None:
        return PartMesh(surface, (RED,), np.zeros(len(surface.triangles), dtype=np.int64), True, 1.0)
    above = surface.corners[:, :, 2].mean(axis=1) > split
    return PartMesh(surface, (BLUE, RED), np.where(above, 0, 1), True, 1.0)


def ball(subdivisions=5):
    return trimesh.creation.icosphere(subdivisions, 0.05)


def sheet(count, size, height):
    """An open sheet of 2 count² triangles above a square, whose height [m] depends on x."""
    x, y = np.meshgrid(np.linspace(0, size, count + 1), np.linspace(0, size, count + 1), indexing="ij")
    points = np.stack([x, y, height(x)], axis=-1).reshape(-1, 3)
    a = (np.arange(count)[:, None] * (count + 1) + np.arange(count)).ravel()
    b, c, d = a + count + 1, a + count + 2, a + 1
    faces = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    return trimesh.Trimesh(points, faces, process=False)


def loaded(mesh):
    return trimesh.Trimesh(mesh.surface.vertices, mesh.surface.triangles, process=False)


def border(mesh, colour):
    """The edges of one colour that have no other side within it, as sets of exact points."""
    triangles = mesh.surface.triangles[mesh.colours == colour]
    edges = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    single, count = np.unique(edges, axis=0, return_counts=True)
    points = mesh.surface.vertices
    return {(points[a].tobytes(), points[b].tobytes()) for a, b in single[count == 1]}


def slow_distances(points, corners):
    """The distance of points from the nearest of triangles (m, 3, 3), by trimesh."""
    nearest = (trimesh.triangles.closest_point(corners, np.repeat(p[None], len(corners), 0)) for p in points)
    return np.array([np.linalg.norm(near - p, axis=1).min() for near, p in zip(nearest, points, strict=True)])


def test_ball_keeps_its_shape_within_the_tolerance():
    mesh = part(ball())
    decimated = simplified(mesh, 1e-3)
    assert len(decimated.surface.triangles) < len(mesh.surface.triangles) / 10
    result = loaded(decimated)
    assert result.is_watertight
    assert result.volume > 0
    # The distance from a sphere is known in closed form, whatever measures it.
    samples, _ = trimesh.sample.sample_surface(result, 20000, seed=1)
    off = np.abs(np.linalg.norm(samples, axis=1) - 0.05).max()
    assert off < 2.5e-3
    assert off == pytest.approx(hausdorff_bound(mesh, decimated, 0.0, 1.0), rel=0.15)


@pytest.mark.slow
def test_two_colours_meet_in_one_line_on_curved_and_flat_sides():
    angles = np.linspace(-np.pi / 2, np.pi / 2, 65)
    lump = np.stack([0.05 * np.cos(angles), 0.05 * np.sin(angles)], axis=1)
    lump[[0, -1], 0] = 0.0
    drum = [(0.0, -0.05), *((0.03, height) for height in np.linspace(-0.05, 0.05, 33)), (0.0, 0.05)]
    for profile in (lump, np.array(drum)):
        mesh = part(trimesh.creation.revolve(profile, sections=128), 0.0)
        assert len(border(mesh, 0)) > 40
        decimated = simplified(mesh, 3e-4)
        assert loaded(decimated).is_watertight
        assert border(decimated, 0) == border(decimated, 1)
        assert 3 <= len(border(decimated, 0)) < len(border(mesh, 0))
        assert hausdorff_bound(mesh, decimated, 0.0, 1.0) < 1e-3


def test_open_sheet_keeps_its_edges():
    mesh = part(sheet(40, 0.1, lambda x: 0.01 * np.sin(40 * x)))
    decimated = simplified(mesh, 2e-4)
    assert len(decimated.surface.triangles) < 800
    before, after = loaded(mesh), loaded(decimated)
    assert after.bounds == pytest.approx(before.bounds, abs=2e-4)
    assert after.area == pytest.approx(before.area, rel=2e-3)
    assert hausdorff_bound(mesh, decimated, 0.0, 1.0) < 6e-4


def test_three_sheets_on_one_edge_stay_where_they_are():
    plate = trimesh.creation.box((0.1, 0.1, 0.001)).subdivide().subdivide().subdivide()
    upright = plate.copy().apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, [1, 0, 0]))
    surface = of_mesh(trimesh.util.concatenate([plate, upright]))
    turned = surface.triangles.copy()
    turned[::7] = turned[::7, ::-1]
    colours = np.zeros(len(turned), dtype=np.int64)
    mesh = PartMesh(Surface(surface.vertices, turned), (RED,), colours, False, 0.0)
    decimated = simplified(mesh, 1e-4)
    assert decimated is None or hausdorff_bound(mesh, decimated, 0.0, 1.0) < 1e-3


def test_distances_from_a_sliver_are_exact():
    sliver = Surface(np.array([[0, 0, 0], [1, 0, 0], [0.5, 1e-9, 0]]), np.array([[0, 1, 2]]))
    for point, distance in (((0.3, 0.0, 0.2), 0.2), ((1.5, 0.0, 0.0), 0.5)):
        assert farthest(np.array([point]), sliver, 0.0, 9.0) == pytest.approx(distance)


@pytest.mark.parametrize("turned", [False, True])
def test_walked_distances_are_bounds_and_the_largest_is_exact(turned):
    # A tube of long slivers, two sheets that share its end without a common edge, and turned triangles.
    tube = trimesh.creation.annulus(0.02, 0.03, 0.2, sections=64)
    sheets = [
        trimesh.creation.box((0.08, 0.05, 1e-4), trimesh.transformations.translation_matrix([0, 0, z]))
        for z in (0.0999, 0.1002)
    ]
    surface = of_mesh(trimesh.util.concatenate([tube, *sheets]))
    triangles = surface.triangles.copy()
    if turned:
        triangles[::5] = triangles[::5, ::-1]
    target = Surface(surface.vertices, triangles)
    points = evenly_spread(target.corners, 300).points
    points = points + np.random.default_rng(7).normal(scale=2e-3, size=points.shape)
    slow = slow_distances(points, target.corners)
    walked = WalkedSurface.of(target).bounds(points, 1e-3)
    assert (walked >= slow - 1e-12).all()
    assert np.median(walked - slow) < 1e-3
    for enough in (0.0, 1e-3):
        assert farthest(points, target, enough, 9.0) == pytest.approx(slow.max(), abs=1e-12)


def test_neighbours_are_across_an_edge_in_the_opposite_sense():
    # A square of two triangles, and a third on its diagonal in the same sense as the first.
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1]])
    across = neighbours(Surface(corners, np.array([[0, 1, 2], [0, 2, 3], [2, 0, 4]])))
    assert across[0].tolist() == [0, 0, 1]
    assert across[1].tolist()[1:] == [1, 1]
    assert across[1, 0] in (0, 2)
    assert across[2].tolist() == [1, 2, 2]
    assert (neighbours(of_mesh(trimesh.creation.box())) != np.arange(12)[:, None]).all()


@given(falls=st.lists(st.integers(0, 400), max_size=12), most=st.integers(0, 1500))
def test_lowest_level_is_that_of_a_plain_search(falls, most):
    counts = np.cumsum([0, *falls])[::-1].tolist()
    plain = next((level for level, count in enumerate(counts) if count <= most), len(counts))
    assert lowest_level(len(counts), counts.__getitem__, most) == plain


def test_colour_that_is_gone_is_infinitely_far():
    mesh = part(ball(3), 0.01)
    grey = PartMesh(mesh.surface, mesh.palette, np.ones_like(mesh.colours), True, 1.0)
    assert hausdorff_bound(mesh, grey, 0.0, 1.0) == np.inf


def test_points_are_spread_by_area():
    surface = of_mesh(trimesh.creation.box((1.0, 1.0, 0.1)))
    inside = np.abs(np.abs(evenly_spread(surface.corners, 10000).points[:, 2]) - 0.05) < 1e-12
    assert inside.mean() == pytest.approx(2 / 2.4, abs=0.01)


def test_triangles_go_where_the_surface_needs_them(monkeypatch):
    """The cube needs 12 of its triangles, the ball all that it can get; each is made a manifold once."""
    manifolds = []
    of = Simplifiable.of
    monkeypatch.setattr(Simplifiable, "of", staticmethod(lambda *mesh: manifolds.append(mesh) or of(*mesh)))
    cube = trimesh.creation.box((0.1, 0.1, 0.1))
    for _ in range(5):
        cube = cube.subdivide()
    meshes = {FIRST: part(cube), SECOND: part(ball())}
    fitted, decimation = Decimator().fitted([FIRST, SECOND, SECOND], meshes, 8000)
    faces = {ref: len(mesh.surface.triangles) for ref, mesh in fitted.items()}
    assert faces[FIRST] == 12
    assert 4000 < 12 + 2 * faces[SECOND] <= 8000
    assert (decimation.before, decimation.after) == (12288 + 2 * 20480, 12 + 2 * faces[SECOND])
    assert not decimation.limited
    assert 0 < decimation.error <= bound(meshes[SECOND].surface)
    assert len(manifolds) == 2


def test_bound_is_kept_and_reported_and_few_triangles_stay(monkeypatch):
    mesh = part(ball(4))
    fitted, decimation = Decimator().fitted([FIRST], {FIRST: mesh}, 10)
    assert decimation.limited
    assert decimation.after > 10
    error = hausdorff_bound(mesh, fitted[FIRST], 0.0, 1.0)
    assert error <= decimation.error + 1e-12 <= bound(mesh.surface) + 1e-12
    assert bound(mesh.surface) > MIN_BOUND
    fitted, decimation = Decimator().fitted([FIRST], {FIRST: mesh}, len(mesh.surface.triangles))
    assert (fitted[FIRST] is mesh, decimation) == (True, None)
    # A mesh that does not simplify stays.
    monkeypatch.setattr(budget, "simplified", lambda *_: None)
    fitted, decimation = Decimator().fitted([FIRST], {FIRST: mesh}, 10)
    assert fitted[FIRST] is mesh
    assert (decimation.after, decimation.limited, decimation.error) == (5120, True, 0.0)


def test_part_within_the_budget_imports_no_heavy_library():
    code = (
        "import sys, numpy\n"
        "import linkwright.stages.mesh.geometry\n"
        "from linkwright.stages.formats.meshes.surface import Surface\n"
        "from linkwright.stages.mesh.part_mesh import PartMesh\n"
        "from linkwright.stages.mesh.visuals.budget import Decimator\n"
        "from linkwright.stages.robot.model.robot import MeshRef\n"
        "few = numpy.zeros((4, 3), dtype=int)\n"
        "mesh = PartMesh(Surface(numpy.eye(3), few), ((1, 0, 0, 1),), few[:, 0], False, 0.0)\n"
        "ref = MeshRef('reply', 'part')\n"
        "assert Decimator().fitted([ref], {ref: mesh}, 4)[1] is None\n"
        "heavy = 'manifold3d trimesh coacd mujoco scipy.spatial scipy.sparse'.split()\n"
        "assert not [name for name in heavy if name in sys.modules]"
    )
    subprocess.run([sys.executable, "-c", code], cwd=PROJECT, check=True)


def test_flat_colours_count_with_their_backs():
    mesh = part(sheet(30, 0.1, np.zeros_like))
    made = make_visuals(
        [DrawnPart(0, FIRST, np.eye(4))], {FIRST: mesh}, VisualSection(max_faces=1800), Decimator()
    )
    assert sum(file.faces for file in made.files) <= 1800
    assert made.decimation is not None


@pytest.mark.slow
@settings(max_examples=10, deadline=None)
@given(seed=st.integers(0, 10**6), most=st.integers(50, 320))
def test_any_lump_fits_its_number_or_bound_in_any_order(seed, most):
    rng = np.random.default_rng(seed)
    shape = ball(2)
    shape.vertices *= 1 + 0.15 * np.sin(rng.uniform(5, 60, 3) * shape.vertices).sum(axis=1, keepdims=True)
    mesh = part(shape, 0.0)
    shuffled = trimesh.Trimesh(shape.vertices, shape.faces[rng.permutation(len(shape.faces))], process=False)
    fitted, decimation = Decimator().fitted([FIRST], {FIRST: mesh}, most)
    result = fitted[FIRST]
    other = Decimator().fitted([FIRST], {FIRST: part(shuffled, 0.0)}, most)[0][FIRST]
    assert np.array_equal(result.surface.vertices, other.surface.vertices)
    assert np.array_equal(result.surface.triangles, other.surface.triangles)
    if decimation is None:
        return
    assert decimation.limited == (len(result.surface.triangles) > most)
    limit = bound(mesh.surface)
    assert hausdorff_bound(mesh, result, limit / 2, 1.0) <= limit + 1e-12
    assert loaded(result).is_watertight == loaded(mesh).is_watertight
    if result is not mesh:
        multiples = result.surface.vertices / (SNAP * np.linalg.norm(np.ptp(mesh.surface.vertices, axis=0)))
        assert np.abs(multiples - np.round(multiples)).max() < 1e-3


def test_mirrored_part_is_the_mirror_image_of_the_other():
    drawn = [DrawnPart(0, FIRST, np.eye(4)), DrawnPart(1, FIRST, np.diag([-1.0, 1.0, 1.0, 1.0]))]
    keys = VisualSection(max_faces=4000, merge="part")
    made = make_visuals(drawn, {FIRST: part(ball(4), 0.0)}, keys, Decimator())
    assert made.owners == (0, 0, 1, 1)
    assert made.decimation.after <= 4000

    def triangles(corners):
        return {tuple(sorted(map(tuple, triangle))) for triangle in corners.tolist()}

    for plain, turned in zip(made.files[:2], made.files[2:], strict=True):
        assert plain.colour == turned.colour
        flipped = (stl.read(plain.data) * [-1, 1, 1])[:, ::-1] + 0.0
        assert triangles(flipped) == triangles(stl.read(turned.data))
        assert turned.area == pytest.approx(plain.area, rel=1e-12)
