"""Decompositions: right in volume and number, the same whatever the order, and told in words where there is
none."""

from contextlib import closing

import manifold3d
import numpy as np
import pytest

from linkwright.stages.formats.meshes.surface import Surface, weld
from linkwright.stages.mesh.collide import collision, improvement
from linkwright.stages.mesh.collide.collision import Collision
from linkwright.stages.mesh.collide.improvement import BOUNDS, Improvement, helper
from linkwright.stages.mesh.configuration.collider_settings import CoacdSettings
from linkwright.stages.mesh.decompose import Search, decomposed, search
from linkwright.stages.mesh.decompose.coacd_pieces import NOT_CLOSED, prepared
from linkwright.stages.mesh.decompose.seams import containing_hull, grown
from linkwright.stages.robot.errors import ConfigError, DecompositionFailed, MeshError
from linkwright.stages.robot.system.guest import Bounds
from tests.fake_onshape import solids
from tests.support.decomposing import decompose, improved, task
from tests.support.poison import POISONED

TOLERANCE = 0.001


def surface_of(solid) -> Surface:
    surface, _ = weld(solid.vertices, solid.triangles.astype(np.int64))
    return surface


BRACKET = surface_of(
    solids.extrude([(0, 0), (0.06, 0), (0.06, 0.006), (0.006, 0.006), (0.006, 0.04), (0, 0.04)], 0.03)
)
CLAMP = surface_of(
    solids.extrude(
        [(0, 0), (40, 0), (40, 10), (10, 10), (10, 40), (40, 40), (40, 50), (0, 50)] * np.array(0.001), 0.02
    )
)
RING = surface_of(solids.tube(0.03, 0.022, 0.01))


def bowl() -> Surface:
    angles = np.linspace(0, np.pi / 2, 9)
    outer = [(0.03 * np.sin(t), -0.03 * np.cos(t)) for t in angles[1:]]
    inner = [(0.025 * np.sin(t), -0.025 * np.cos(t)) for t in angles[:0:-1]]
    return surface_of(solids.revolve([(0, -0.03), *outer, *inner, (0, -0.025)], 24))


def union(parts) -> manifold3d.Manifold:
    solid = [body(part) for part in parts]
    return manifold3d.Manifold.batch_boolean(solid, manifold3d.OpType.Add)


def body(surface: Surface) -> manifold3d.Manifold:
    mesh = manifold3d.Mesh64(surface.vertices.copy(), surface.triangles.astype(np.uint64))
    return manifold3d.Manifold(mesh)


def shuffled(surface: Surface, seed: int) -> Surface:
    """The same surface with its vertices and triangles in another order."""
    rng = np.random.default_rng(seed)
    order = rng.permutation(len(surface.vertices))
    place = np.empty_like(order)
    place[order] = np.arange(len(order))
    triangles = np.array([np.roll(row, rng.integers(3)) for row in place[surface.triangles]])
    return Surface(surface.vertices[order], triangles[rng.permutation(len(triangles))])


def test_a_bracket_is_two_plates_and_a_clamp_three() -> None:
    for surface, count in ((BRACKET, 2), (CLAMP, 3)):
        found = decompose(surface, TOLERANCE)
        assert len(found) == count
        assert all(piece.closed() and piece.volume() > 0 for piece in found)
        assert union(found).volume() == pytest.approx(surface.volume(), rel=5e-3)
        assert (body(surface) - union(found)).volume() < 1e-4 * surface.volume()


@pytest.mark.slow
def test_a_bowl_stays_open() -> None:
    found = decompose(bowl(), TOLERANCE)
    assert 4 <= len(found) <= 16
    room = manifold3d.Manifold.sphere(0.018, 48).translate([0, 0, 0])
    assert (union(found) ^ room).volume() < 0.02 * room.volume()


def corners(surface: Surface) -> list[list[list[float]]]:
    found = decomposed(surface, TOLERANCE, Search())
    assert not isinstance(found, str)
    return [piece.vertices.tolist() for piece in found]


@pytest.mark.slow
def test_neither_the_order_nor_the_last_digits_of_the_input_matter() -> None:
    for surface in (BRACKET, CLAMP, RING):
        plain = corners(surface)
        assert [corners(shuffled(surface, seed)) for seed in range(2)] == [plain, plain]
    noise = np.random.default_rng(3).uniform(-1e-10, 1e-10, CLAMP.vertices.shape)
    noisy = Surface(CLAMP.vertices + 1e-8 + noise, CLAMP.triangles)
    assert corners(noisy) == corners(Surface(CLAMP.vertices + 1e-8, CLAMP.triangles))


@pytest.mark.slow
def test_a_body_that_is_inside_out_and_a_bubble_within_are_made_good() -> None:
    outer, inner = surface_of(solids.ball(0.03)), surface_of(solids.ball(0.01))
    hollow = Surface(
        np.concatenate([outer.vertices, inner.vertices]),
        np.concatenate([outer.triangles, inner.triangles[:, ::-1] + len(outer.vertices)]),
    )
    for surface in (outer.flipped(), hollow):
        (piece,) = decompose(surface, TOLERANCE, 256)
        assert piece.volume() == pytest.approx(outer.volume(), rel=0.02)


def test_only_a_body_that_lies_across_itself_is_refused() -> None:
    """CoACD would cut it without end. Bodies across each other are cut one by one."""
    across, others = POISONED["self-intersecting"](), POISONED["two overlapping"]()
    assert prepared(weld(*across)[0], 0.0016) == NOT_CLOSED
    bodies = prepared(weld(*others)[0], 0.0016)
    assert [isinstance(one, Surface) and one.closed() for one in bodies] == [True, True]


def test_a_ring_keeps_its_hole() -> None:
    found = decompose(RING, TOLERANCE)
    assert len(found) <= 16
    hole = manifold3d.Manifold.cylinder(0.02, 0.018, circular_segments=64).translate([0, 0, -0.005])
    assert (union(found) ^ hole).volume() == 0
    assert (body(RING) - union(found)).volume() < 1e-3 * RING.volume()


@pytest.mark.parametrize("vertices", [64, 12])
def test_neighbours_leave_no_gap(vertices: int) -> None:
    """Shrinks the part by three tenths of a millimetre: what is left lies within the pieces."""
    each = decompose(RING, TOLERANCE, vertices)
    assert max(len(piece.vertices) for piece in each) <= vertices
    within = surface_of(solids.tube(0.0297, 0.0223, 0.0094))
    core = body(Surface(within.vertices + np.array([0, 0, 0.0003]), within.triangles))
    assert (core - union(each)).volume() < 1e-9 * core.volume()


def test_two_bodies_are_two_pieces() -> None:
    here, there = solids.box(0.02, 0.02, 0.02), solids.box(0.02, 0.03, 0.02, at=(0.05, 0, 0))
    both = Surface(
        np.concatenate([here.vertices, there.vertices]),
        np.concatenate([here.triangles, there.triangles + len(here.vertices)]),
    )
    assert sorted(round(one.volume() * 1e6, 2) for one in decompose(both, TOLERANCE)) == [8, 12]


@pytest.mark.parametrize(
    ("vertices", "triangles"),
    [
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]], [[0, 1, 2], [1, 3, 2], [0, 2, 1]]),
    ],
)
def test_what_has_no_pieces_is_refused_in_words(vertices, triangles) -> None:
    surface = Surface(np.array(vertices, dtype=float), np.array(triangles, dtype=np.int64))
    with pytest.raises(DecompositionFailed, match="the mesh is flat") as caught:
        decompose(surface, TOLERANCE)
    assert isinstance(caught.value, MeshError)


PEACE = collision.encode(Collision(note="peace"))
EASY = Improvement("peace", [], CoacdSettings(), Collision())


@pytest.fixture
def visitor(tmp_path, monkeypatch):
    """A guest in the place of ours: the name of a module with these lines as its `answer(request)`. To `EASY`
    it says "peace"."""
    monkeypatch.syspath_prepend(tmp_path)

    def written(lines: str) -> str:
        easy = f"if b'peace' in request: return {PEACE!r}"
        body = "".join(f"    {line}\n" for line in [easy, *lines.splitlines()])
        (tmp_path / "visitor.py").write_text(f"def answer(request):\n{body}")
        return "visitor"

    return written


@pytest.mark.parametrize("used", [False, True], ids=["new", "used"])
@pytest.mark.parametrize(
    ("lines", "bounds", "said"),
    [
        ("import time\ntime.sleep(1000)", Bounds(1, 1 << 30, 1000), "took longer than 1 s"),
        ("while True: pass", Bounds(1, 1 << 30, 1000), "took longer than 1 s"),
        ("import os\nos.abort()", BOUNDS, "crashed (SIGABRT)"),
        ("import ctypes\nctypes.string_at(0)", BOUNDS, "crashed (SIGSEGV)"),
        (
            "import time\nheld = b'x' * (400 << 20)\ntime.sleep(1000)",
            Bounds(60, 210 << 20, 1000),
            "needed more than 0.22 GB of memory",
        ),
        ("return bytes(1001)", Bounds(60, 1 << 30, 1000), "made more than 0.001 MB"),
        ("return b'garbage'", BOUNDS, "gave a reply that is none"),
        ("return b''", BOUNDS, "gave a reply that is none"),
        ("return None + 1", BOUNDS, "failed (TypeError"),
    ],
)
def test_however_the_guest_fails_it_is_told_and_is_no_result(visitor, used, lines, bounds, said) -> None:
    """And what is asked before and after has its own result."""
    with closing(helper(module=visitor(lines), bounds=bounds)) as guest:
        if used:
            assert improvement.improved(EASY, guest) == PEACE
        with pytest.raises(DecompositionFailed) as caught:
            improvement.improved(task(CLAMP), guest)
        assert f"the decomposition {said}" in caught.value.message
        assert improvement.improved(EASY, guest) == PEACE


@pytest.mark.slow
def test_a_mesh_that_takes_too_long_ends_in_time() -> None:
    ball = body(surface_of(solids.ball(0.05, 64, 32)))
    spheres = [ball.scale([0.3] * 3).translate([0.05 * np.cos(a), 0.05 * np.sin(a), 0]) for a in range(6)]
    mesh = (ball - manifold3d.Manifold.batch_boolean(spheres, manifold3d.OpType.Add)).to_mesh64()
    surface = Surface(np.asarray(mesh.vert_properties)[:, :3], np.asarray(mesh.tri_verts).astype(np.int64))
    thorough = task(surface, 1e-5, effort="high", coacd={"mcts_iterations": 2000, "threshold": 0.01})
    with pytest.raises(DecompositionFailed, match="took longer than 4 s"):
        improved(thorough, bounds=Bounds(4, 2 << 30, 1 << 26))


def test_the_guest_runs_on_one_thread(visitor) -> None:
    lines = (
        "import os\n"
        "names = ['OMP_NUM_THREADS', 'OPENBLAS_NUM_THREADS', 'MKL_NUM_THREADS']\n"
        "assert [os.environ.get(name) for name in names] == ['1'] * 3, 'threads'\n"
        "raise SystemExit('one')"
    )
    with pytest.raises(DecompositionFailed, match=r"failed \(one\)"):
        improved(task(CLAMP), module=visitor(lines))


def test_the_parameters_are_those_of_coacd_with_its_names() -> None:
    import inspect

    import coacd

    names = set(inspect.signature(coacd.run_coacd).parameters) - {"mesh"}
    assert set(search("normal", {}).arguments(0.001)) == names
    chosen = search("normal", {"threshold": 0.1, "pca": True, "seed": 7})
    arguments = chosen.arguments(0.001)
    assert (arguments["threshold"], arguments["real_metric"]) == (0.1, False)
    assert (arguments["pca"], arguments["seed"]) == (True, 7)
    own = search("normal", {}).arguments(0.001)
    assert (own["threshold"], own["real_metric"]) == (0.002, True)


@pytest.mark.parametrize(
    ("given", "where", "said"),
    [
        ({"treshold": 0.1}, "mesh.coacd.treshold", "did you mean threshold?"),
        ({"threshold": -1}, "mesh.coacd.threshold", "no positive number"),
        ({"threshold": 5}, "mesh.coacd.threshold", "not between 0.01 and 1"),
        ({"threshold": 0.001}, "mesh.coacd.threshold", "not between 0.01 and 1"),
        ({"threshold": True}, "mesh.coacd.threshold", "no positive number"),
        ({"mcts_nodes": 0}, "mesh.coacd.mcts_nodes", "not between 2 and 100"),
        ({"mcts_nodes": 2.5}, "mesh.coacd.mcts_nodes", "no whole number"),
        ({"pca": 1}, "mesh.coacd.pca", "neither true nor false"),
        ({"preprocess_mode": "maybe"}, "mesh.coacd.preprocess_mode", "none of auto, on, off"),
        ({"max_convex_hull": 4}, "mesh.coacd.max_convex_hull", "needs merge: true"),
    ],
)
def test_a_wrong_parameter_is_told_with_its_key(given, where, said) -> None:
    with pytest.raises(ConfigError) as caught:
        search("normal", given)
    assert caught.value.where == where
    assert said in f"{caught.value.message} {caught.value.hint}"


@pytest.mark.parametrize(
    "given",
    [
        {"threshold": 0.05, "real_metric": False},
        {"threshold": 0.002, "real_metric": True},
        {"merge": True, "max_convex_hull": 1},
        {"merge": True, "max_convex_hull": 2},
        {"decimate": True, "max_ch_vertex": 8},
        pytest.param({"preprocess_mode": "on", "preprocess_resolution": 20}, marks=pytest.mark.slow),
        {"preprocess_mode": "off", "apx_mode": "box"},
        {"extrude": True, "pca": True},
    ],
    ids=str,
)
def test_what_is_given_to_coacd_gives_pieces(given) -> None:
    found = decompose(BRACKET, TOLERANCE, search=search("low", given))
    assert 1 <= len(found) <= 16


@pytest.mark.slow
def test_the_collider_coacd_is_the_pieces_of_a_part() -> None:
    from linkwright.stages.mesh.colliders import coacd

    settings = CoacdSettings(coacd={"seed": 1})
    assert coacd.make([Surface(BRACKET.vertices * [1, 1, 0], BRACKET.triangles)], settings).pieces == ()
    hull = coacd.make([CLAMP], settings)
    assert (len(hull.pieces), hull.meets) == (1, False)
    made = coacd.improve([CLAMP], settings, hull)
    assert len(made.pieces) == 3
    assert sum(piece.volume() for piece in made.pieces) == pytest.approx(CLAMP.volume(), rel=0.02)


def test_a_wrong_parameter_in_the_configuration_is_an_error_of_its_key() -> None:
    from linkwright.stages.mesh.section import MeshSection

    with pytest.raises(ValueError, match=r"coacd\n\s+treshold: .*did you mean threshold\?"):
        MeshSection.model_validate({"coacd": {"treshold": 0.1}})
    assert MeshSection.model_validate({"coacd": {"threshold": 0.1}}).coacd == {"threshold": 0.1}


def test_a_hull_of_fewer_vertices_contains_the_one_it_stands_for() -> None:
    ball = surface_of(solids.ball(0.03, 32, 16))
    plain = containing_hull(ball, 40)
    assert len(plain.vertices) <= 40
    assert (body(ball) - body(plain)).volume() < 1e-9 * ball.volume()
    assert plain.volume() < 1.35 * ball.volume()
    assert containing_hull(ball, 10_000) is ball


def test_grown_faces_lie_further_out_by_the_distance() -> None:
    (cube,) = decompose(surface_of(solids.box(0.02, 0.03, 0.04)), TOLERANCE)
    assert np.ptp(grown(cube, 0.001), axis=0) == pytest.approx([0.022, 0.032, 0.042], abs=1e-7)
