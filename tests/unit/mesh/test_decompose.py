"""Decompositions: right in volume and number, whatever the order, and a failure in words."""

import inspect
from contextlib import closing

import manifold3d
import numpy as np
import pytest

from linkwright.stages.formats.meshes.surface import Surface, weld
from linkwright.stages.mesh.collide import collision, improvement
from linkwright.stages.mesh.collide.collision import Collision
from linkwright.stages.mesh.collide.cut_pieces import PieceCutter
from linkwright.stages.mesh.collide.improvement import BOUNDS, Improvement, helper
from linkwright.stages.mesh.colliders import coacd as collider
from linkwright.stages.mesh.configuration.collider_settings import CoacdSettings
from linkwright.stages.mesh.decompose import CoacdParameters, coacd_parameters, convex_pieces
from linkwright.stages.mesh.decompose.coacd_pieces import NOT_CLOSED, prepared
from linkwright.stages.mesh.decompose.seams import containing_hull, expanded_corners
from linkwright.stages.mesh.measure import MeasuredPart
from linkwright.stages.mesh.measure.field import Field
from linkwright.stages.mesh.section import MeshSection
from linkwright.stages.mesh.surfaces.pieces import surface_of as piece_surface
from linkwright.stages.robot.errors import ConfigError, DecompositionFailed, MeshError
from linkwright.stages.robot.system.guest import Bounds
from tests.fake_onshape import solids
from tests.support.cases import mostly_slow
from tests.support.decomposing import cut, decompose, improved, judge, task
from tests.support.poison import POISONED
from tests.support.solids import box, joined

TOLERANCE = 0.001


def surface_of(solid):
    return weld(solid.vertices, solid.triangles.astype(np.int64))[0]


ANGLE = [(0, 0), (0.06, 0), (0.06, 0.006), (0.006, 0.006), (0.006, 0.04), (0, 0.04)]
FORK = np.array([(0, 0), (40, 0), (40, 10), (10, 10), (10, 40), (40, 40), (40, 50), (0, 50)]) * 0.001
BRACKET = surface_of(solids.extrude(ANGLE, 0.03))
CLAMP = surface_of(solids.extrude(FORK, 0.02))
RING = surface_of(solids.tube(0.03, 0.022, 0.01))


def union(parts):
    return manifold3d.Manifold.batch_boolean([body(part) for part in parts], manifold3d.OpType.Add)


def body(surface):
    return manifold3d.Manifold(
        manifold3d.Mesh64(surface.vertices.copy(), surface.triangles.astype(np.uint64))
    )


def shuffled(surface, seed):
    """The same surface with its vertices and triangles in another order."""
    rng = np.random.default_rng(seed)
    order = rng.permutation(len(surface.vertices))
    place = np.argsort(order)
    triangles = np.array([np.roll(row, rng.integers(3)) for row in place[surface.triangles]])
    return Surface(surface.vertices[order], triangles[rng.permutation(len(triangles))])


@pytest.mark.parametrize(("way", "lost"), [(decompose, 1e-4), (cut, 1e-5)])
@pytest.mark.parametrize(("surface", "count"), [(BRACKET, 2), (CLAMP, 3)], ids=["bracket", "clamp"])
def test_bracket_is_two_plates_and_a_clamp_three(surface, count, way, lost):
    """`lost`: the share of the part's volume that the pieces may leave out."""
    pieces = way(surface, TOLERANCE)
    assert len(pieces) == count
    assert all(piece.is_closed() and piece.volume() > 0 for piece in pieces)
    assert union(pieces).volume() == pytest.approx(surface.volume(), rel=5e-3)
    assert (body(surface) - union(pieces)).volume() < lost * surface.volume()


@pytest.mark.parametrize(("way", "lost"), [(decompose, 1e-9), (cut, 1e-5)])
@pytest.mark.parametrize("vertices", mostly_slow([64, 12], 1))
def test_ring_keeps_its_hole_and_neighbours_leave_no_gap(vertices, way, lost):
    pieces = way(RING, TOLERANCE, vertices)
    assert len(pieces) <= 16
    assert max(len(piece.vertices) for piece in pieces) <= vertices
    hole = manifold3d.Manifold.cylinder(0.02, 0.018, circular_segments=64).translate([0, 0, -0.005])
    assert (union(pieces) ^ hole).volume() == 0
    # The ring less 0.3 mm is within the pieces.
    within = surface_of(solids.tube(0.0297, 0.0223, 0.0094))
    core = body(Surface(within.vertices + np.array([0, 0, 0.0003]), within.triangles))
    assert (core - union(pieces)).volume() < lost * core.volume()
    assert way is cut or vertices == 12 or (body(RING) - union(pieces)).volume() < 1e-3 * RING.volume()


@pytest.mark.slow
def test_bowl_stays_open():
    angles = np.linspace(0, np.pi / 2, 9)
    outer = [(0.03 * np.sin(t), -0.03 * np.cos(t)) for t in angles[1:]]
    inner = [(0.025 * np.sin(t), -0.025 * np.cos(t)) for t in angles[:0:-1]]
    bowl = surface_of(solids.revolve([(0, -0.03), *outer, *inner, (0, -0.025)], 24))
    pieces = decompose(bowl, TOLERANCE)
    assert 4 <= len(pieces) <= 16
    room = manifold3d.Manifold.sphere(0.018, 48)
    assert (union(pieces) ^ room).volume() < 0.02 * room.volume()


def corners(surface):
    return [piece.vertices.tolist() for piece in convex_pieces(surface, TOLERANCE, CoacdParameters())]


@pytest.mark.slow
def test_neither_order_nor_last_digits_of_the_input_matter():
    for surface in (BRACKET, CLAMP, RING):
        plain = corners(surface)
        assert [corners(shuffled(surface, seed)) for seed in range(2)] == [plain, plain]
    noise = np.random.default_rng(3).uniform(-1e-10, 1e-10, CLAMP.vertices.shape)
    noisy = Surface(CLAMP.vertices + 1e-8 + noise, CLAMP.triangles)
    assert corners(noisy) == corners(Surface(CLAMP.vertices + 1e-8, CLAMP.triangles))


@pytest.mark.slow
def test_body_inside_out_and_a_bubble_within_are_repaired():
    outer, inner = surface_of(solids.ball(0.03)), surface_of(solids.ball(0.01))
    for surface in (outer.flipped(), joined(outer, inner.flipped())):
        (piece,) = decompose(surface, TOLERANCE, 256)
        assert piece.volume() == pytest.approx(outer.volume(), rel=0.02)


def test_only_a_self_intersecting_body_is_refused():
    """CoACD would not terminate. Bodies across each other are cut one by one."""
    across, overlapping = (weld(*POISONED[name]())[0] for name in ("self-intersecting", "two overlapping"))
    assert prepared(across, 0.0016) == NOT_CLOSED
    assert [piece.is_closed() for piece in prepared(overlapping, 0.0016)] == [True, True]


def test_two_bodies_are_two_pieces():
    both = joined(
        *map(surface_of, (solids.box(0.02, 0.02, 0.02), solids.box(0.02, 0.03, 0.02, at=(0.05, 0, 0))))
    )
    assert sorted(round(piece.volume() * 1e6, 2) for piece in decompose(both, TOLERANCE)) == [8, 12]


@pytest.mark.parametrize("triangles", [[[0, 1, 2]], [[0, 1, 2], [1, 3, 2], [0, 2, 1]]])
def test_flat_mesh_is_refused_in_words(triangles):
    flat = Surface(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0.0]]), np.array(triangles))
    with pytest.raises(DecompositionFailed, match="the mesh is flat") as caught:
        decompose(flat, TOLERANCE)
    assert isinstance(caught.value, MeshError)


PEACE = collision.encode(Collision(note="peace"))
EASY = Improvement("peace", [], CoacdSettings(), Collision())


@pytest.fixture
def visitor(tmp_path, monkeypatch):
    """A guest in place of ours: the name of a module with these lines as its `answer(request)`. To `EASY` it
    says "peace"."""
    monkeypatch.syspath_prepend(tmp_path)

    def written(lines):
        easy = f"if b'peace' in request: return {PEACE!r}"
        text = "".join(f"    {line}\n" for line in [easy, *lines.splitlines()])
        (tmp_path / "visitor.py").write_text(f"def answer(request):\n{text}")
        return "visitor"

    return written


HUNGRY = "import time\nheld = b'x' * (400 << 20)\ntime.sleep(1000)"


@pytest.mark.parametrize(
    ("lines", "bounds", "message"),
    mostly_slow(
        [
            ("import time\ntime.sleep(1000)", Bounds(1, 1 << 30, 1000), "took longer than 1 s"),
            ("import os\nos.abort()", BOUNDS, "crashed (SIGABRT)"),
            (HUNGRY, Bounds(60, 210 << 20, 1000), "needed more than 0.22 GB of memory"),
            ("return b'garbage'", BOUNDS, "returned an invalid reply"),
            ("return bytes(1001)", Bounds(60, 1 << 30, 1000), "made more than 0.001 MB"),
            ("return None + 1", BOUNDS, "failed (TypeError"),
            ("while True: pass", Bounds(1, 1 << 30, 1000), "took longer than 1 s"),
            ("import ctypes\nctypes.string_at(0)", BOUNDS, "crashed (SIGSEGV)"),
            ("return b''", BOUNDS, "returned an invalid reply"),
        ],
        keep=4,
    ),
)
def test_failure_of_a_guest_is_reported_and_is_no_result(visitor, lines, bounds, message):
    """A new guest fails, and so does one that has answered; later requests have their own results."""
    with closing(helper(module=visitor(lines), bounds=bounds)) as guest:
        for _ in range(2):
            with pytest.raises(DecompositionFailed) as caught:
                improvement.improved(task(CLAMP), guest)
            assert f"the decomposition {message}" in caught.value.message
            assert improvement.improved(EASY, guest) == PEACE


@pytest.mark.slow
def test_mesh_that_takes_too_long_ends_in_time():
    ball = body(surface_of(solids.ball(0.05, 64, 32)))
    spheres = [ball.scale([0.3] * 3).translate([0.05 * np.cos(a), 0.05 * np.sin(a), 0]) for a in range(6)]
    mesh = (ball - manifold3d.Manifold.batch_boolean(spheres, manifold3d.OpType.Add)).to_mesh64()
    surface = Surface(np.asarray(mesh.vert_properties)[:, :3], np.asarray(mesh.tri_verts).astype(np.int64))
    thorough = task(surface, 1e-5, effort="high", coacd={"mcts_iterations": 2000, "threshold": 0.01})
    with pytest.raises(DecompositionFailed, match="took longer than 4 s"):
        improved(thorough, bounds=Bounds(4, 2 << 30, 1 << 26))


def test_guest_runs_on_one_thread(visitor):
    names = ["OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"]
    lines = f"import os\nraise SystemExit(str([os.environ.get(name) for name in {names}]))"
    with pytest.raises(DecompositionFailed, match=r"failed \(\['1', '1', '1'\]\)"):
        improved(task(CLAMP), module=visitor(lines))


def test_parameters_are_those_of_coacd_with_its_names():
    import coacd

    arguments = coacd_parameters("normal", {}).arguments(0.001)
    assert set(arguments) == set(inspect.signature(coacd.run_coacd).parameters) - {"mesh"}
    assert (arguments["threshold"], arguments["real_metric"]) == (0.002, True)
    chosen = coacd_parameters("normal", {"threshold": 0.1, "pca": True, "seed": 7}).arguments(0.001)
    assert [chosen[name] for name in ("threshold", "real_metric", "pca", "seed")] == [0.1, False, True, 7]


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("treshold", 0.1, "did you mean threshold?"),
        ("threshold", -1, "not a positive number"),
        ("threshold", 5, "not between 0.01 and 1"),
        ("threshold", 0.001, "not between 0.01 and 1"),
        ("threshold", True, "not a positive number"),
        ("mcts_nodes", 0, "not between 2 and 100"),
        ("mcts_nodes", 2.5, "not a whole number"),
        ("pca", 1, "neither true nor false"),
        ("preprocess_mode", "maybe", "not one of auto, on, off"),
        ("max_convex_hull", 4, "needs merge: true"),
    ],
)
def test_wrong_parameter_is_reported_with_its_key(name, value, message):
    with pytest.raises(ConfigError) as caught:
        coacd_parameters("normal", {name: value})
    assert caught.value.where == f"mesh.coacd.{name}"
    assert message in f"{caught.value.message} {caught.value.hint}"


def test_wrong_parameter_is_an_error_of_its_key():
    with pytest.raises(ValueError, match=r"coacd\n\s+treshold: .*did you mean threshold\?"):
        MeshSection.model_validate({"coacd": {"treshold": 0.1}})
    assert MeshSection.model_validate({"coacd": {"threshold": 0.1}}).coacd == {"threshold": 0.1}


@pytest.mark.parametrize(
    "options",
    mostly_slow(
        [
            {"threshold": 0.05, "real_metric": False},
            {"merge": True, "max_convex_hull": 2},
            {"extrude": True, "pca": True},
            {"threshold": 0.002, "real_metric": True},
            {"merge": True, "max_convex_hull": 1},
            {"decimate": True, "max_ch_vertex": 8},
            {"preprocess_mode": "on", "preprocess_resolution": 20},
            {"preprocess_mode": "off", "apx_mode": "box"},
        ],
        keep=3,
    ),
    ids=str,
)
def test_coacd_takes_its_parameters(options):
    assert 1 <= len(decompose(BRACKET, TOLERANCE, parameters=coacd_parameters("low", options))) <= 16


@pytest.mark.slow
def test_collider_coacd_is_the_pieces_of_a_part():
    settings = CoacdSettings(coacd={"seed": 1})
    assert collider.make([Surface(BRACKET.vertices * [1, 1, 0], BRACKET.triangles)], settings).pieces == ()
    hull = collider.make([CLAMP], settings)
    assert (len(hull.pieces), hull.meets) == (1, False)
    pieces = collider.improve([CLAMP], settings, hull).pieces
    assert len(pieces) == 3
    assert sum(piece.volume() for piece in pieces) == pytest.approx(CLAMP.volume(), rel=0.02)


def test_hull_of_fewer_vertices_contains_the_whole_hull():
    ball = surface_of(solids.ball(0.03, 32, 16))
    capped = containing_hull(ball, 40)
    assert len(capped.vertices) <= 40
    assert (body(ball) - body(capped)).volume() < 1e-9 * ball.volume()
    assert capped.volume() < 1.35 * ball.volume()
    assert containing_hull(ball, 10_000) is ball
    (cube,) = decompose(surface_of(solids.box(0.02, 0.03, 0.04)), TOLERANCE)
    assert np.ptp(expanded_corners(cube, 0.001), axis=0) == pytest.approx([0.022, 0.032, 0.042], abs=1e-7)


@pytest.mark.slow
def test_flanged_tube_keeps_its_bore_and_its_flanges_corner():
    profile = [(0.022, 0), (0.04, 0), (0.04, 0.008), (0.028, 0.008), (0.028, 0.06), (0.022, 0.06)]
    flanged, tolerance = surface_of(solids.revolve(profile, 48)), 0.0018
    pieces = cut(flanged, tolerance)
    assert len(pieces) <= 16
    whole = union(pieces)
    assert (body(flanged) - whole).volume() < 1e-3 * flanged.volume()
    assert judge(flanged, tolerance).measure(pieces).bareness_max < 1e-5
    bore, around, outer = (
        manifold3d.Manifold.cylinder(0.05, radius, circular_segments=64).translate([0, 0, 0.0085])
        for radius in (0.022 - 2 * tolerance, 0.028 + tolerance, 0.04)
    )
    assert (whole ^ bore).volume() < 1e-9 * flanged.volume()
    assert (whole ^ (outer - around)).volume() < 0.02 * flanged.volume()


def test_mesh_with_a_bad_edge_is_cut_at_its_own_surface():
    """One triangle too many: the pieces are those of the part, not thicker."""
    tip = CLAMP.vertices[:2].mean(axis=0, keepdims=True) * [1, 1, 0.9]
    points = np.concatenate([CLAMP.vertices, tip])
    whole = union(cut(Surface(points, np.vstack([CLAMP.triangles, [0, 1, len(CLAMP.vertices)]])), 0.001))
    assert (body(CLAMP) - whole).volume() < 0.01 * CLAMP.volume()
    assert (whole - body(CLAMP)).volume() < 0.06 * CLAMP.volume()


@pytest.mark.slow
def test_no_fewer_of_the_pieces_would_do():
    part = judge(RING, 0.001)
    cutter = PieceCutter(part, 64)
    result = cutter.cut()
    assert result.meets_tolerance
    assert part.is_near(result.pieces)
    assert len(cutter.join(cutter.prepare(result.pieces)).pieces) == len(result.pieces)


@pytest.mark.slow
def test_order_of_the_input_changes_no_corner():
    for surface in (BRACKET, CLAMP):
        plain = [piece.vertices.tolist() for piece in cut(surface, 0.001)]
        for seed in range(2):
            assert [piece.vertices.tolist() for piece in cut(shuffled(surface, seed), 0.001)] == plain


def test_pieces_are_not_joined_across_a_hole_however_small():
    """A plate of 300 mm with a hole of 8 mm, as four bars around it: to close it adds 0.07 %."""
    whole, hole, thick = 0.3, 0.008, 0.004
    side, off = (whole - hole) / 2, (whole + hole) / 4
    bars = [box(side, whole, thick, at=(x * off, 0, 0)) for x in (-1, 1)]
    bars += [box(hole, side, thick, at=(0, y * off, 0)) for y in (-1, 1)]
    cutter = PieceCutter(judge(joined(*bars), 0.001), 64)
    pieces = [piece_surface(piece) for piece in cutter.join(cutter.prepare(bars)).pieces]
    assert 1 < len(pieces) <= 4
    pin = manifold3d.Manifold.cube([0.003, 0.003, 0.003], center=True)
    assert (union(pieces) ^ pin).volume() < 1e-15


@pytest.mark.parametrize("tolerance", [0.01, 0.0002])
def test_field_has_the_distances_of_closed_forms(tolerance):
    """The target is two bars 60 mm apart, by a grid, and where that would be too large."""
    bars = joined(*(box(0.02, 0.1, 0.1, at=(x, 0, 0)) for x in (-0.04, 0.04)))
    field = Field.of(MeasuredPart.of(bars), tolerance)
    assert (field.values is None) == (tolerance < 0.001)
    places = np.array([[0, 0, 0], [0.04, 0, 0], [0.03 - 2 * tolerance, 0, 0], [0.03, 0, 0]])
    assert field(places) == pytest.approx([min(0.03 / tolerance, 10), 0, 2, 0], rel=0.15, abs=0.25)
