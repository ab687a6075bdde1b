"""Which collider each part gets: by glob, by size, by source, and as far as the effort goes."""

import io
import subprocess
from dataclasses import replace
from hashlib import sha256

import numpy as np
import pytest
import trimesh

from linkwright.stages.mesh import make_geometry, part_mesh
from linkwright.stages.mesh.collide import make as collide
from linkwright.stages.mesh.fit import capped_hull
from linkwright.stages.mesh.library import MAX_DECIMATION_MOVE, MeshLibrary
from linkwright.stages.mesh.section import MeshSections
from linkwright.stages.robot import codec
from linkwright.stages.robot.bundle import Bundle
from linkwright.stages.robot.errors import DecompositionFailed
from linkwright.stages.robot.model.robot import Inertial, Link, MeshRef, Part, Primitive, frozen
from tests.support.physics import robot_of_meshes
from tests.support.robots import at, robot_with
from tests.support.solids import bodies_of
from tests.support.touching import Memory, no_memo

LEGS = [((0, 0, 0), (0.1, 0.02, 0.005)), ((0, 0, 0), (0.005, 0.02, 0.08))]
SHAPES = {
    "Block": trimesh.creation.box((0.06, 0.04, 0.02)),
    "Screw": trimesh.creation.cylinder(0.002, 0.01),
    "Bracket": trimesh.boolean.union([trimesh.creation.box(bounds=leg) for leg in LEGS], engine="manifold"),
    "Crumb": trimesh.creation.box((0.0005, 0.0005, 0.0005)),
}
REPLY = bodies_of(SHAPES)
DIGEST = sha256(REPLY).hexdigest()
BODY = Inertial(0.1, frozen([0.0, 0, 0]), frozen(np.eye(3) * 1e-5))


def bundle(kind="onshape"):
    return Bundle(kind, {}, "", {}, {DIGEST: REPLY})


def part(name, x=0.0, **more):
    """An instance of a shape, such as "Block <2>"."""
    shape = name.rpartition("/")[2].partition(" <")[0]
    place = frozen(at(x, 0, 0))
    return replace(Part((name,), name, shape, MeshRef(DIGEST, shape), place, place, BODY, 0.0), **more)


def robot(*parts, shapes=()):
    return replace(robot_with([], root="base"), links=(Link("base", BODY, parts, ("base",), None, shapes),))


def keys_of(**mesh):
    return MeshSections.model_validate({"mesh": {"collider": "ladder", **mesh}})


def made(value, kind="onshape", memo=no_memo, **mesh):
    return make_geometry(value, bundle(kind), keys_of(**mesh), memo)


def kinds(geometry):
    """The parts of each collider → what it is."""
    return {collider.parts: collider.rung for collider in geometry.colliders}


def codes(geometry):
    return [problem.code for problem in geometry.diagnostics if problem.code != "W-COM-OUTSIDE"]


def primitives(geometry):
    return [shape.primitive.kind for shape in geometry.shapes_of("base", "collision") if shape.primitive]


BRACKET = "Arm <1>/Bracket <1>"
BOTH = robot(part("Block <1>"), part(BRACKET, 0.2))


def test_default_is_a_collider_for_each_link():
    """Nothing else is near, and the only link of a robot does not meet the world."""
    geometry = made(BOTH)
    (collider,) = geometry.colliders
    assert (collider.rung, collider.maker, collider.reason) == ("hull", "ladder", "nothing moves")
    assert set(collider.parts) == {"Block <1>", BRACKET}
    assert codes(geometry) == []


@pytest.mark.parametrize("keys", [{"colliders": {"*": "ladder"}}, {"tolerance": 0.0015}])
def test_with_a_tolerance_or_a_glob_each_part_has_a_collider(keys):
    geometry = made(BOTH, **keys)
    assert kinds(geometry) == {("Block <1>",): "box", (BRACKET,): "pieces"}
    assert primitives(geometry) == ["box"] * 3
    assert codes(geometry) == []


@pytest.mark.parametrize(
    ("colliders", "block", "bracket"),
    [
        ({"Bracket": "hull"}, "box", "hull"),
        ({"Arm <1>/*": "box"}, "box", "box"),
        ({"Bracket <1>": {"make": "none"}}, "box", "none"),
        ({"B*": "none", "Bl*": "sphere"}, "sphere", "none"),
        ({"Block": "sphere", "B*": "none"}, "none", "none"),
        ({"Bracket": {"capsule": {"radius": 0.01}}}, "box", "capsule"),
    ],
)
def test_globs_choose_by_part_and_the_last_wins(colliders, block, bracket):
    assert kinds(made(BOTH, colliders=colliders)) == {("Block <1>",): block, (BRACKET,): bracket}


def test_glob_on_a_link_is_for_all_of_its_parts_together():
    geometry = made(BOTH, colliders={"base": "box"})
    assert list(kinds(geometry).values()) == ["box"]
    (shape,) = geometry.shapes_of("base", "collision")
    # From the left face of the block to the right end of the bracket.
    assert max(shape.primitive.size) == pytest.approx(0.33, abs=0.01)


def test_settings_of_a_glob_replace_those_of_the_mesh():
    ball = made(robot(part("Block <1>")), colliders={"Block": {"sphere": {"radius": 0.02}}})
    (shape,) = ball.shapes_of("base", "collision")
    assert (shape.primitive.kind, shape.primitive.size) == ("sphere", (0.02,))
    loose = {"make": "ladder", "tolerance": 0.05, "extra_volume": 100}
    (collider,) = made(robot(part("Bracket <1>")), colliders={"Bracket": loose}).colliders
    assert (collider.tolerance, collider.meets) == (0.05, True)
    assert collider.rung != "pieces"


def test_small_and_standard_parts_have_no_collider_unless_named():
    value = robot(part("Block <1>"), part("Crumb <1>", 0.05), part("Screw <1>", 0.06, standard=True))
    geometry = made(value, collider="primitives")
    assert list(kinds(geometry)) == [("Block <1>",)]
    (problem,) = (diagnostic for diagnostic in geometry.diagnostics if diagnostic.code == "I-SMALL-PARTS")
    assert "Crumb <1> of base, Screw <1> of base" in problem.message
    named = made(value, collider="primitives", colliders={"Screw": "hull", "Crumb": "box"})
    assert len(named.colliders) == 3
    assert ("Crumb <1>",) in kinds(made(value, collider="primitives", min_size=0))
    only = made(robot(part("Screw <1>", standard=True)), collider="primitives")
    assert list(kinds(only)) == [("Screw <1>",)]


SEEN, HIDDEN = part("Bracket <1>", collides=False), part("Block <1>", seen=False)
SPHERE = Primitive("sphere", (0.02,), frozen(np.eye(4)), visual=False)


@pytest.mark.parametrize(
    ("value", "kind", "basis", "parts"),
    [
        (robot(SEEN, HIDDEN), "urdf", "declared", [("Block <1>",)]),
        (robot(SEEN, HIDDEN), "urdf", "visual", [("Bracket <1>",)]),
        (robot(SEEN), "mjcf", "declared", [("Bracket <1>",)]),
        (robot(SEEN), "onshape", "declared", []),  # what CAD only shows, such as a sheet, does not collide
        (robot(SEEN, shapes=(SPHERE,)), "urdf", "declared", []),
    ],
)
def test_colliders_of_a_file_are_made_of_its_shapes_or_visuals(value, kind, basis, parts):
    geometry = made(value, kind, basis=basis, collider="primitives")
    assert list(kinds(geometry)) == parts
    assert primitives(geometry)[len(parts) :] == ["sphere"] * len(value.links[0].shapes)


def test_each_part_is_made_once_however_often_it_is_used():
    calls = []

    def memo(kind, key, make):
        calls.append((kind, key.get("step"), key.get("collider")))
        return make()

    value = robot(*(part(f"Bracket <{number}>", 0.2 * number) for number in range(4)))
    geometry = made(value, memo=memo, tolerance=0.0015)
    steps = [step for kind, step, _ in calls if kind == "mesh.collider"]
    assert steps == ["make", "together", "improve"]
    assert (len(geometry.colliders), len(geometry.shapes_of("base", "collision"))) == (4, 8)
    (key_of_part,) = {collider.key for collider in geometry.colliders}
    assert [step for _, step, key in calls if key == key_of_part] == ["make", "improve"]


@pytest.mark.parametrize("collider", ["primitives", "ladder"])
def test_figures_of_a_part_without_an_inside_survive_the_cache(collider):
    """A bent sheet: what its hull adds is no share of a volume."""
    bent = trimesh.Trimesh([[0, 0, 0], [0.1, 0, 0], [0.1, 0.1, 0.03], [0, 0.1, 0]], [[0, 1, 2], [0, 2, 3]])
    value, files = robot_of_meshes({"Sheet": bent})
    memo = Memory()
    for _ in range(2):
        geometry = make_geometry(value, files, keys_of(collider=collider, tolerance=0.002), memo)
        (figures,) = geometry.colliders
        assert figures.measures.extra is None
        assert codec.decode_geometry(codec.encode_geometry(geometry)).colliders == (figures,)


def test_guest_that_fails_leaves_the_hull_and_is_reported(monkeypatch):
    def fails(*_):
        raise DecompositionFailed("the decomposition took longer than 60 s")

    monkeypatch.setattr(collide, "improved", fails)
    geometry = made(BOTH, collider="coacd", tolerance=0.0015)
    assert kinds(geometry)[(BRACKET,)] == "hull"
    texts = [diagnostic.message for diagnostic in geometry.diagnostics if diagnostic.code == "W-COLLIDER"]
    assert any("Bracket" in text and "took longer than 60 s" in text for text in texts)
    assert not geometry.lasts


def loaded(geometry):
    files = [shape.file for shape in geometry.shapes_of("base", "collision") if shape.file]
    return [trimesh.load(io.BytesIO(geometry.files[file]), file_type="stl") for file in files]


def test_files_are_those_of_the_pieces():
    value, files = robot_of_meshes({"Ring": trimesh.creation.annulus(0.02, 0.03, 0.02, sections=32)})
    pieces = loaded(make_geometry(value, files, keys_of(collider="coacd"), no_memo))
    assert 4 <= len(pieces) <= 16
    for piece in pieces:
        assert piece.is_convex
        heights = -np.einsum("ij,ij->i", piece.face_normals, piece.triangles[:, 0])
        assert heights.max() > 0.015  # so far is the middle of the ring outside of each


@pytest.fixture(scope="module")
def ball():
    """A robot of a ball of very many triangles, and its files."""
    return robot_of_meshes({"Ball": trimesh.creation.icosphere(6, 0.03)})


@pytest.mark.parametrize("most", [5_000, 50_000])
def test_collider_of_very_many_triangles_is_made_of_fewer(most, ball):
    """As near as it was: the figures are against the part itself within seven hundredths of the tolerance."""
    assert MAX_DECIMATION_MOVE < 0.07 * 0.0016
    value, files = ball
    library, ref = MeshLibrary(value.links, files), value.links[0].parts[0].mesh
    light = library.surface(ref, most)
    assert len(light.triangles) < 30_000
    off = np.linalg.norm(light.corners.mean(axis=1), axis=1) - 0.03
    assert np.abs(off).max() < MAX_DECIMATION_MOVE + 1e-6
    assert len(library.surface(ref, None).triangles) == 81_920
    assert library.surface(MeshRef(ref.reply, "other"), most) is None


def test_hull_of_very_many_triangles_is_that_of_all_of_them(ball):
    value, files = ball
    keys = keys_of(collider="hull", max_vertices=64, visual={"max_faces": 100_000})
    (solid,) = loaded(make_geometry(value, files, keys, no_memo))
    reply = files.body(value.links[0].parts[0].mesh.reply)
    expected = capped_hull(part_mesh.decode_meshes(reply, ["Ball"])["Ball"].surface, 64)
    corners = [np.sort(points, axis=0) for points in (solid.vertices, expected.vertices)]
    np.testing.assert_allclose(*corners, atol=1e-8, rtol=0)


def test_process_starts_only_where_something_is_decomposed(monkeypatch):
    monkeypatch.setattr(subprocess, "Popen", None)
    for mesh in ({}, {"collider": "hull"}, {"collider": "ladder", "tolerance": 0.2}):
        assert set(kinds(made(BOTH, **mesh)).values()) <= {"box", "hull"}
    with pytest.raises(TypeError):
        made(BOTH, collider="coacd")
