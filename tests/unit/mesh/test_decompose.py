"""Decompositions: right in volume and number, the same whatever the order, and told in words where there is
none."""

import json
from contextlib import closing
from functools import cache

import manifold3d
import numpy as np
import pytest

from stages.mesh import decompose as rooms
from stages.mesh.decompose import (
    BOUNDS,
    EFFORTS,
    DecomposeOptions,
    decomposer,
    decomposition_key,
    estimated_cost,
    pieces,
    read,
    search,
    wire,
)
from stages.mesh.decompose.joining import groups, joinings
from stages.mesh.decompose.overhang import Overhang
from stages.mesh.decompose.prepare import Prepared, prepared
from stages.mesh.decompose.seams import containing, grown
from stages.mesh.inside import Inside
from stages.mesh.surface import Surface, weld
from stages.robot.errors import ConfigError, DecompositionFailed, MeshError
from stages.robot.guest import Bounds
from tests.fake_onshape import solids
from tests.support.decomposing import decompose, decomposition
from tests.support.poison import POISONED
from tests.support.solids import box, joined

OPTIONS, EASY = DecomposeOptions(0.001), DecomposeOptions(0.002)


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


@cache
def of_ring() -> wire.Decomposition:
    return read(decomposition(RING, OPTIONS))


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


def open_box(size: float = 0.05) -> Surface:
    """Loose sheets: a box without a lid whose sides share no vertex, 0.2 mm apart."""
    box = solids.box(size, size, size)
    corners = box.vertices[np.concatenate([face.triangles for face in box.faces if face.name != "+z"])]
    sides = corners.reshape(-1, 2, 3, 3)
    sides = sides * 0.996 + 0.004 * sides.mean(axis=(1, 2), keepdims=True)
    return Surface(sides.reshape(-1, 3), np.arange(len(sides) * 6).reshape(-1, 3))


def test_a_bracket_is_two_plates_and_a_clamp_three() -> None:
    for surface, count in ((BRACKET, 2), (CLAMP, 3)):
        found = decompose(surface, OPTIONS)
        assert len(found) == count
        assert all(piece.closed() and piece.volume() > 0 for piece in found)
        assert union(found).volume() == pytest.approx(surface.volume(), rel=5e-3)
        assert (body(surface) - union(found)).volume() < 1e-4 * surface.volume()


def test_a_ring_keeps_its_hole_and_every_number_of_pieces_holds_the_part() -> None:
    made = of_ring()
    solid, before = body(RING), 0.0
    hole = manifold3d.Manifold.cylinder(0.02, 0.018, circular_segments=64).translate([0, 0, -0.005])
    for most in (16, 8, 4, 2, 1):
        found = pieces(made, most)
        assert len(found) <= most
        around = union(found)
        assert (solid - around).volume() < 1e-3 * solid.volume()
        assert around.volume() >= before - 1e-9
        before = around.volume()
        if most >= 8:
            assert (around ^ hole).volume() == 0
    assert made.way == "as it is"
    assert not made.refused


@pytest.mark.slow
def test_a_bowl_stays_open() -> None:
    found = decompose(bowl(), OPTIONS)
    assert 4 <= len(found) <= 16
    room = manifold3d.Manifold.sphere(0.018, 48).translate([0, 0, 0])
    assert (union(found) ^ room).volume() < 0.02 * room.volume()


@pytest.mark.parametrize(("most", "vertices"), [(16, 64), (3, 64), (3, 12), (8, 8)])
def test_neighbours_leave_no_gap(most: int, vertices: int) -> None:
    """Shrinks the part by three tenths of a millimetre: what is left lies within the pieces."""
    each = pieces(of_ring(), most, vertices)
    assert max(len(piece.vertices) for piece in each) <= vertices
    found = union(each)
    within = surface_of(solids.tube(0.0297, 0.0223, 0.0094))
    core = body(Surface(within.vertices + np.array([0, 0, 0.0003]), within.triangles))
    assert (core - found).volume() < 1e-9 * core.volume()


@pytest.mark.slow
def test_the_order_of_the_input_does_not_matter() -> None:
    mixed = shuffled(BRACKET, 1)
    assert decomposition(mixed, OPTIONS) == decomposition(BRACKET, OPTIONS)
    for seed in range(5):
        assert decomposition_key(shuffled(CLAMP, seed), OPTIONS) == decomposition_key(CLAMP, OPTIONS)


@pytest.mark.slow
@pytest.mark.parametrize("surface", [CLAMP, RING, open_box()], ids=["clamp", "ring", "sheets"])
def test_the_order_of_the_input_matters_for_no_way(surface: Surface) -> None:
    plain = decomposition(surface, OPTIONS)
    assert [decomposition(shuffled(surface, seed), OPTIONS) for seed in range(2)] == [plain, plain]


def test_the_last_digits_of_the_input_do_not_matter() -> None:
    noise = np.random.default_rng(3).uniform(-1e-10, 1e-10, CLAMP.vertices.shape)
    noisy = Surface(CLAMP.vertices + 1e-8 + noise, CLAMP.triangles)
    plain = Surface(CLAMP.vertices + 1e-8, CLAMP.triangles)
    assert decomposition_key(noisy, OPTIONS) == decomposition_key(plain, OPTIONS)


def test_the_key_depends_on_the_shape_the_tolerance_and_the_search_but_not_on_how_many_pieces() -> None:
    keys = [
        decomposition_key(CLAMP, OPTIONS),
        decomposition_key(RING, OPTIONS),
        decomposition_key(CLAMP, DecomposeOptions(0.002)),
        decomposition_key(CLAMP, DecomposeOptions(0.001, search=search("low", {}))),
        decomposition_key(CLAMP, DecomposeOptions(0.001, search=search("normal", {"seed": 1}))),
    ]
    assert len({json.dumps(key) for key in keys}) == len(keys)
    assert decomposition_key(CLAMP, DecomposeOptions(0.001, 8, 32)) == keys[0]
    assert set(keys[0]["libraries"]) == {"coacd", "manifold3d", "numpy", "scipy"}


@pytest.mark.slow
def test_sheets_that_bound_nothing_are_decomposed_within_the_tolerance() -> None:
    sheets = open_box()
    made = read(decomposition(sheets, DecomposeOptions(0.002)))
    assert made.way == "remeshed"
    found = union(pieces(made, 16))
    inside = manifold3d.Manifold.cube([0.045, 0.045, 0.045], center=True).translate([0, 0, 0.0024])
    assert (found ^ inside).volume() < 1e-12
    whole = manifold3d.Manifold.cube([0.0545, 0.0545, 0.0545], center=True)
    assert (found - whole).volume() < 1e-12


@pytest.mark.slow
def test_a_mesh_with_a_bad_edge_is_drawn_in_to_its_own_surface() -> None:
    """One triangle too many: closed round about, then the pieces are those of the part, not thicker."""
    fin = np.array([[0, 1, len(CLAMP.vertices)]])
    tip = CLAMP.vertices[:2].mean(axis=0, keepdims=True) * [1, 1, 0.9]
    mesh = Surface(np.concatenate([CLAMP.vertices, tip]), np.concatenate([CLAMP.triangles, fin]))
    made = read(decomposition(mesh, OPTIONS))
    assert made.way == "remeshed"
    found = union(pieces(made, 16))
    assert (body(CLAMP) - found).volume() < 0.01 * CLAMP.volume()
    assert (found - body(CLAMP)).volume() < 0.06 * CLAMP.volume()


@pytest.mark.slow
def test_a_body_that_is_inside_out_and_a_bubble_within_are_made_good() -> None:
    outer, inner = surface_of(solids.ball(0.03)), surface_of(solids.ball(0.01))
    hollow = Surface(
        np.concatenate([outer.vertices, inner.vertices]),
        np.concatenate([outer.triangles, inner.triangles[:, ::-1] + len(outer.vertices)]),
    )
    for surface in (outer.flipped(), hollow):
        (piece,) = decompose(surface, OPTIONS)
        assert piece.volume() == pytest.approx(outer.volume(), rel=0.02)


def test_only_a_body_that_lies_across_itself_is_closed_round_anew() -> None:
    """CoACD would cut it without end. Bodies across each other are cut one by one."""
    across, others = POISONED["self-intersecting"](), POISONED["two overlapping"]()
    for mesh, way, count in ((across, "remeshed", 1), (others, "as it is", 2)):
        surface, _ = weld(*mesh)
        made = prepared(surface, 0.0016)
        assert isinstance(made, Prepared)
        assert (made.way, len(made.bodies)) == (way, count)
        assert all(Inside.of(body).times_around(body.vertices * 0.99).max() == 1 for body in made.bodies)


def test_two_bodies_are_two_pieces() -> None:
    here, there = solids.box(0.02, 0.02, 0.02), solids.box(0.02, 0.03, 0.02, at=(0.05, 0, 0))
    both = Surface(
        np.concatenate([here.vertices, there.vertices]),
        np.concatenate([here.triangles, there.triangles + len(here.vertices)]),
    )
    assert sorted(round(one.volume() * 1e6, 2) for one in decompose(both, OPTIONS)) == [8, 12]


@pytest.mark.parametrize(
    ("vertices", "triangles", "said"),
    [
        ([[0, 0, 0], [1, 0, 0], [0, 1, np.nan]], [[0, 1, 2]], "a coordinate of the mesh is not a number"),
        ([[0, 0, 0], [1, 0, 0], [0, np.inf, 0]], [[0, 1, 2]], "a coordinate of the mesh is not a number"),
        (np.zeros((0, 3)), np.zeros((0, 3)), "the mesh has no triangle"),
        ([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 0, 2]], "the mesh has no triangle"),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]], "the mesh is flat"),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]], [[0, 1, 2], [1, 3, 2], [0, 2, 1]], "the mesh is flat"),
    ],
)
def test_what_has_no_pieces_is_refused_in_words_and_that_is_a_result(vertices, triangles, said) -> None:
    surface = Surface(np.array(vertices, dtype=float), np.array(triangles, dtype=np.int64))
    assert read(decomposition(surface, OPTIONS)).refused == said
    with pytest.raises(DecompositionFailed) as caught:
        decompose(surface, OPTIONS)
    assert caught.value.message == said
    assert isinstance(caught.value, MeshError)


@pytest.fixture
def visitor(tmp_path, monkeypatch):
    """A guest in the place of CoACD's: the name of a module with these lines as its `answer(request)`. What
    is asked with twice the tolerance of OPTIONS, `EASY`, it refuses because of "peace"."""
    monkeypatch.syspath_prepend(tmp_path)

    def written(lines: str) -> str:
        easy = f"if b'tolerance\": {EASY.tolerance}' in request: return wire.write(wire.refusal('peace'))"
        body = "".join(f"    {line}\n" for line in [easy, *lines.splitlines()])
        (tmp_path / "visitor.py").write_text(
            f"from stages.mesh.decompose import wire\ndef answer(request):\n{body}"
        )
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
    with closing(decomposer(module=visitor(lines), bounds=bounds)) as guest:
        if used:
            assert read(rooms.decomposition(CLAMP, EASY, guest)).refused == "peace"
        with pytest.raises(DecompositionFailed) as caught:
            rooms.decomposition(CLAMP, OPTIONS, guest)
        assert f"the decomposition {said}" in caught.value.message
        assert read(rooms.decomposition(CLAMP, EASY, guest)).refused == "peace"


@pytest.mark.slow
def test_a_mesh_that_takes_too_long_ends_in_time() -> None:
    ball = body(surface_of(solids.ball(0.05, 64, 32)))
    spheres = [ball.scale([0.3] * 3).translate([0.05 * np.cos(a), 0.05 * np.sin(a), 0]) for a in range(6)]
    mesh = (ball - manifold3d.Manifold.batch_boolean(spheres, manifold3d.OpType.Add)).to_mesh64()
    surface = Surface(np.asarray(mesh.vert_properties)[:, :3], np.asarray(mesh.tri_verts).astype(np.int64))
    thorough = DecomposeOptions(1e-5, search=search("high", {"mcts_iterations": 2000, "threshold": 0.01}))
    with pytest.raises(DecompositionFailed, match="took longer than 2 s"):
        decomposition(surface, thorough, bounds=Bounds(2, 2 << 30, 1 << 26))


def test_the_guest_runs_on_one_thread(visitor) -> None:
    lines = (
        "import os\n"
        "names = ['OMP_NUM_THREADS', 'OPENBLAS_NUM_THREADS', 'MKL_NUM_THREADS']\n"
        "assert [os.environ.get(name) for name in names] == ['1'] * 3, 'threads'\n"
        "raise SystemExit('one')"
    )
    with pytest.raises(DecompositionFailed, match=r"failed \(one\)"):
        decomposition(CLAMP, OPTIONS, module=visitor(lines))


TETRAHEDRON = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
HEAD = {"way": "as it is", "faces": 4, "volume": 1.0, "refused": "", "joinings": []}


def test_a_decomposition_is_read_as_it_was_written() -> None:
    made = wire.Decomposition(
        (TETRAHEDRON, TETRAHEDRON + 1, TETRAHEDRON[:4] * 2),
        (wire.Joining(0, 2, 0.25), wire.Joining(1, 3, 0.5)),
        "remeshed",
        12,
        0.1,
    )
    again = wire.read(wire.write(made))
    assert [piece.tolist() for piece in again.pieces] == [piece.tolist() for piece in made.pieces]
    assert (again.joinings, again.way, again.faces, again.volume) == (made.joinings, "remeshed", 12, 0.1)


@pytest.mark.parametrize(
    ("head", "arrays"),
    [
        ({**HEAD, "joinings": [[0, 0, 0.0]]}, [TETRAHEDRON]),
        ({**HEAD, "joinings": [[0, 1, 0.0], [0, 2, 0.0]]}, [TETRAHEDRON] * 3),
        ({**HEAD, "joinings": [[0, 5, 0.0]]}, [TETRAHEDRON] * 2),
        ({**HEAD, "joinings": [[0, 1, "NaN"]]}, [TETRAHEDRON] * 2),
        ({**HEAD, "joinings": 3}, [TETRAHEDRON]),
        ({**HEAD, "volume": None}, [TETRAHEDRON]),
        ({"way": ""}, [TETRAHEDRON]),
        (HEAD, [TETRAHEDRON * np.nan]),
        (HEAD, []),
    ],
)
def test_a_reply_that_is_wrong_in_itself_is_none(head, arrays) -> None:
    with pytest.raises(ValueError):
        wire.read(wire.pack(head, arrays))


def test_a_reply_that_is_cut_off_is_none() -> None:
    whole = wire.pack(HEAD, [TETRAHEDRON])
    wire.read(whole)
    for end in (0, 5, 12, len(whole) - 24, len(whole) - 1):
        with pytest.raises(ValueError):
            wire.read(whole[:end])


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
    found = decompose(BRACKET, DecomposeOptions(0.001, search=search("low", given)))
    assert 1 <= len(found) <= 16


@pytest.mark.slow
def test_the_collider_coacd_is_the_pieces_of_a_part(monkeypatch) -> None:
    from stages.mesh.collider_settings import ColliderSettings
    from stages.mesh.colliders import coacd

    settings = ColliderSettings(coacd={"seed": 1})
    assert coacd.make([Surface(BRACKET.vertices * [1, 1, 0], BRACKET.triangles)], settings).pieces == ()
    hull = coacd.make([CLAMP], settings)
    assert (len(hull.pieces), hull.meets) == (1, False)
    with closing(decomposer()) as guest:
        made = coacd.improve([CLAMP], settings, hull, guest)
    assert len(made.pieces) == 3
    assert sum(piece.volume() for piece in made.pieces) == pytest.approx(CLAMP.volume(), rel=0.02)
    monkeypatch.setattr(coacd, "decomposition", lambda *_: (_ for _ in ()).throw(DecompositionFailed("no")))
    with pytest.raises(DecompositionFailed, match="no"):
        coacd.improve([CLAMP], settings, hull, decomposer())


def test_a_wrong_parameter_in_the_configuration_is_an_error_of_its_key() -> None:
    from stages.mesh.keys import MeshSection

    with pytest.raises(ValueError, match=r"coacd\n\s+treshold: .*did you mean threshold\?"):
        MeshSection.model_validate({"coacd": {"treshold": 0.1}})
    assert MeshSection.model_validate({"coacd": {"threshold": 0.1}}).coacd == {"threshold": 0.1}


def test_the_dearer_search_and_the_larger_mesh_are_estimated_dearer() -> None:
    costs = [estimated_cost(2000, DecomposeOptions(0.001, search=search(effort, {}))) for effort in EFFORTS]
    assert costs == sorted(costs)
    assert costs[0] < costs[-1]
    assert estimated_cost(500, OPTIONS) < estimated_cost(2500, OPTIONS) < estimated_cost(10**6, OPTIONS)
    assert estimated_cost(10**6, OPTIONS) < 60
    hasty = DecomposeOptions(0.001, search=search("normal", {}, hasty=True))
    assert estimated_cost(2500, hasty) < estimated_cost(2500, OPTIONS) < estimated_cost(2500, OPTIONS, False)


def test_a_hull_of_fewer_vertices_contains_the_one_it_stands_for() -> None:
    ball = surface_of(solids.ball(0.03, 32, 16))
    plain = containing(ball, 40)
    assert len(plain.vertices) <= 40
    assert (body(ball) - body(plain)).volume() < 1e-9 * ball.volume()
    assert plain.volume() < 1.35 * ball.volume()
    assert containing(ball, 10_000) is ball


def test_grown_faces_lie_further_out_by_the_distance() -> None:
    (cube,) = decompose(surface_of(solids.box(0.02, 0.03, 0.04)), OPTIONS)
    assert np.ptp(grown(cube, 0.001), axis=0) == pytest.approx([0.022, 0.032, 0.042], abs=1e-7)


def test_pieces_are_not_joined_across_a_hole_however_little_volume_that_adds() -> None:
    """A plate of 300 mm with a hole of 8 mm, as four bars around it: to close it adds 0.07 %."""
    whole, hole, thick, tolerance = 0.3, 0.008, 0.004, 0.001
    side = (whole - hole) / 2
    bars = [
        box(*size, at=at)
        for x in (-1, 1)
        for size, at in (
            ((side, whole, thick), (x * (hole + side) / 2, 0, 0)),
            ((hole, side, thick), (0, x * (hole + side) / 2, 0)),
        )
    ]
    surface = joined(*bars)
    overhang = Overhang.of([surface], [tolerance], Inside.of(surface))
    steps = joinings([bar.vertices for bar in bars], overhang)
    found = groups(4, steps, 16, surface.volume())
    assert len(found) > 1
    for group in found:
        common = manifold3d.Manifold.hull_points(np.concatenate([bars[one].vertices for one in group]))
        assert overhang(common).most < 3


def test_the_overhang_of_a_hull_is_known_in_closed_form() -> None:
    frame = [box(0.02, 0.1, 0.1, at=(x, 0, 0)) for x in (-0.04, 0.04)]
    overhang = Overhang.of([joined(*frame)], [0.01], Inside.of(joined(*frame)))
    hull = manifold3d.Manifold.hull_points(np.concatenate([bar.vertices for bar in frame]))
    standing = overhang(hull)
    # Four sides of 60 mm by 100 mm between two bars; what is nearer to a bar than 10 mm is near enough.
    assert standing.area == pytest.approx(4 * 0.04 * 0.1, rel=0.06)
    assert standing.most == pytest.approx(3, rel=0.12)  # told roughly
    alone = overhang(manifold3d.Manifold.hull_points(frame[0].vertices))
    assert (alone.area, alone.most) == (0, 1)
