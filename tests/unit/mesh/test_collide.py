"""Which collider each part gets: by glob, by size, by source, and as far as the effort goes."""

import io
import subprocess
from collections.abc import Mapping
from dataclasses import replace
from hashlib import sha256
from typing import Any

import numpy as np
import pytest
import trimesh

from linkwright.stages.mesh import make_geometry, tessellation
from linkwright.stages.mesh.collide import make as collide
from linkwright.stages.mesh.fit import capped_hull
from linkwright.stages.mesh.library import MOVED, MeshLibrary
from linkwright.stages.mesh.section import MeshSections
from linkwright.stages.robot import codec
from linkwright.stages.robot.bundle import Bundle
from linkwright.stages.robot.errors import DecompositionFailed, MeshError
from linkwright.stages.robot.model.geometry import Geometry
from linkwright.stages.robot.model.robot import Inertial, Link, MeshRef, Part, Primitive, Robot, frozen
from tests.support.robots import robot_with
from tests.support.solids import bodies_of

SHAPES = {
    "Block": trimesh.creation.box((0.06, 0.04, 0.02)),
    "Screw": trimesh.creation.cylinder(0.002, 0.01),
    "Bracket": trimesh.boolean.union(
        [
            trimesh.creation.box(bounds=[(0, 0, 0), (0.1, 0.02, 0.005)]),
            trimesh.creation.box(bounds=[(0, 0, 0), (0.005, 0.02, 0.08)]),
        ],
        engine="manifold",
    ),
    "Crumb": trimesh.creation.box((0.0005, 0.0005, 0.0005)),
}
REPLY = bodies_of(SHAPES)
DIGEST = sha256(REPLY).hexdigest()


def bundle(kind: str = "onshape") -> Bundle:
    return Bundle(kind, {}, "", {}, {DIGEST: REPLY})


def at(x: float, y: float = 0.0, z: float = 0.0) -> Any:
    pose = np.eye(4)
    pose[:3, 3] = x, y, z
    return frozen(pose)


def part(name: str, where: Any = None, **more: Any) -> Part:
    """An instance of a shape, such as "Block <2>"."""
    shape = name.rpartition("/")[2].partition(" <")[0]
    place = at(0) if where is None else where
    body = Inertial(0.1, frozen([0.0, 0, 0]), frozen(np.eye(3) * 1e-5))
    return replace(Part((name,), name, shape, MeshRef(DIGEST, shape), place, place, body, 0.0), **more)


def robot(*parts: Part, shapes: tuple[Primitive, ...] = ()) -> Robot:
    body = Inertial(0.1, frozen([0.0, 0, 0]), frozen(np.eye(3) * 1e-5))
    links = (Link("base", body, parts, ("base",), None, shapes),)
    return replace(robot_with([], root="base"), links=links)


def made(value: Robot, kind: str = "onshape", **mesh: Any) -> Geometry:
    keys = MeshSections.model_validate({"mesh": {"collider": "ladder", **mesh}})
    return make_geometry(value, bundle(kind), keys, lambda kind, key, make: make())


def rungs(geometry: Geometry) -> dict[tuple[str, ...], str]:
    return {one.parts: one.rung for one in geometry.colliders}


def codes(geometry: Geometry) -> list[str]:
    return [problem.code for problem in geometry.diagnostics if problem.code not in ("W-COM-OUTSIDE",)]


BOTH = robot(part("Block <1>"), part("Arm <1>/Bracket <1>", at(0.2)))


def test_the_default_is_a_collider_for_each_link() -> None:
    """Nothing else is near, and the only link of a robot does not meet the world."""
    geometry = made(BOTH)
    (one,) = geometry.colliders
    assert (one.rung, one.maker, set(one.parts)) == ("hull", "ladder", {"Block <1>", "Arm <1>/Bracket <1>"})
    assert one.reason == "nothing moves"
    assert codes(geometry) == []


@pytest.mark.parametrize("asked", [{"colliders": {"*": "ladder"}}, {"tolerance": 0.0015}])
def test_with_a_tolerance_or_a_glob_each_part_has_a_collider(asked: Any) -> None:
    geometry = made(BOTH, **asked)
    assert rungs(geometry) == {("Block <1>",): "box", ("Arm <1>/Bracket <1>",): "pieces"}
    assert [shape.primitive.kind for shape in geometry.of("base", "collision") if shape.primitive] == [
        "box"
    ] * 3
    assert codes(geometry) == []


@pytest.mark.parametrize(
    ("chosen", "expected"),
    [
        ({"Bracket": "hull"}, {"Block <1>": "box", "Arm <1>/Bracket <1>": "hull"}),
        ({"Arm <1>/*": "box"}, {"Block <1>": "box", "Arm <1>/Bracket <1>": "box"}),
        ({"Bracket <1>": {"make": "none"}}, {"Block <1>": "box", "Arm <1>/Bracket <1>": "none"}),
        ({"B*": "none", "Bl*": "sphere"}, {"Block <1>": "sphere", "Arm <1>/Bracket <1>": "none"}),
        ({"Block": "sphere", "B*": "none"}, {"Block <1>": "none", "Arm <1>/Bracket <1>": "none"}),
        ({"Bracket": {"capsule": {"radius": 0.01}}}, {"Block <1>": "box", "Arm <1>/Bracket <1>": "capsule"}),
    ],
)
def test_globs_choose_by_part_and_the_last_wins(chosen: Any, expected: Mapping[str, str]) -> None:
    assert rungs(made(BOTH, colliders=chosen)) == {(name,): rung for name, rung in expected.items()}


def test_a_glob_on_a_link_is_for_all_of_its_parts_together() -> None:
    geometry = made(BOTH, colliders={"base": "box"})
    assert list(rungs(geometry).values()) == ["box"]
    (shape,) = geometry.of("base", "collision")
    assert shape.primitive is not None
    # From the left face of the block to the right end of the bracket.
    assert sorted(shape.primitive.size)[-1] == pytest.approx(0.33, abs=0.01)


def test_a_size_that_is_said_is_kept() -> None:
    (shape,) = made(robot(part("Block <1>")), colliders={"Block": {"sphere": {"radius": 0.02}}}).of(
        "base", "collision"
    )
    assert shape.primitive is not None
    assert (shape.primitive.kind, shape.primitive.size) == ("sphere", (0.02,))


def test_settings_of_a_glob_replace_those_of_the_mesh() -> None:
    loose = {"make": "ladder", "tolerance": 0.05, "extra_volume": 100}
    (one,) = made(robot(part("Bracket <1>")), colliders={"Bracket": loose}).colliders
    assert (one.tolerance, one.meets) == (0.05, True)
    assert one.rung != "pieces"


def test_a_glob_without_a_match_says_what_there_is() -> None:
    with pytest.raises(MeshError) as caught:
        made(BOTH, colliders={"Finger*": "box", "*": "ladder"})
    (problem,) = caught.value.problems
    assert (problem.code, problem.where) == ("E-GLOB", "mesh.colliders")
    assert "Finger*" in problem.message
    assert "Block, Bracket" in problem.hint


def test_small_parts_and_standard_content_have_no_collider_unless_named() -> None:
    def plain(value: Robot, **mesh: Any) -> Geometry:
        return made(value, collider="primitives", **mesh)

    value = robot(part("Block <1>"), part("Crumb <1>", at(0.05)), part("Screw <1>", at(0.06), standard=True))
    geometry = plain(value)
    assert list(rungs(geometry)) == [("Block <1>",)]
    (problem,) = (one for one in geometry.diagnostics if one.code == "I-SMALL-PARTS")
    assert "Crumb <1> of base, Screw <1> of base" in problem.message
    assert len(plain(value, colliders={"Screw": "hull", "Crumb": "box"}).colliders) == 3
    assert ("Crumb <1>",) in rungs(plain(value, min_size=0))
    assert list(rungs(plain(robot(part("Screw <1>", standard=True))))) == [("Screw <1>",)]


def test_colliders_of_a_file_are_made_of_its_own_shapes_or_of_what_is_seen() -> None:
    def parts(value: Robot, kind: str, basis: str = "declared") -> list[tuple[str, ...]]:
        return list(rungs(made(value, kind, basis=basis, collider="primitives")))

    seen = part("Bracket <1>", collides=False)
    hidden = part("Block <1>", seen=False)
    assert parts(robot(seen, hidden), "urdf") == [("Block <1>",)]
    assert parts(robot(seen, hidden), "urdf", "visual") == [("Bracket <1>",)]
    assert parts(robot(seen), "mjcf") == [("Bracket <1>",)]
    # What CAD only shows, such as a sheet, does not collide for want of something else.
    assert parts(robot(seen), "onshape") == []
    ball = Primitive("sphere", (0.02,), at(0), visual=False)
    declared = made(robot(seen, shapes=(ball,)), "urdf")
    assert [one.primitive.kind for one in declared.of("base", "collision") if one.primitive] == ["sphere"]


def test_each_part_is_made_once_however_often_it_is_used() -> None:
    calls: list[Any] = []

    def memo(kind: str, key: Any, make: Any) -> bytes:
        calls.append((kind, key.get("step"), key.get("collider")))
        return make()

    value = robot(*(part(f"Bracket <{number}>", at(0.2 * number)) for number in range(4)))
    keys = MeshSections.model_validate({"mesh": {"collider": "ladder", "tolerance": 0.0015}})
    geometry = make_geometry(value, bundle(), keys, memo)
    assert [step for kind, step, _ in calls if kind == "mesh.collider"] == [
        "make",
        "together",
        "improve",
    ]
    assert len(geometry.colliders) == 4
    assert len(geometry.of("base", "collision")) == 8
    (own,) = {one.key for one in geometry.colliders}
    assert [step for _, step, key in calls if key == own] == ["make", "improve"]


def test_the_figures_of_a_part_without_an_inside_survive_the_cache() -> None:
    """A bent sheet: what its hull adds is no share of a volume."""
    bent = trimesh.Trimesh([[0, 0, 0], [0.1, 0, 0], [0.1, 0.1, 0.03], [0, 0.1, 0]], [[0, 1, 2], [0, 2, 3]])
    reply = bodies_of({"Sheet": bent})
    digest = sha256(reply).hexdigest()
    value = robot(part("Sheet <1>", mesh=MeshRef(digest, "Sheet")))
    files = Bundle("onshape", {}, "", {}, {digest: reply})
    kept: dict[str, bytes] = {}

    def memo(kind: str, key: Any, make: Any) -> bytes:
        name = repr((kind, key))
        if name not in kept:
            kept[name] = make()
        return kept[name]

    for _ in range(2):
        for collider in ("primitives", "ladder"):
            keys = MeshSections.model_validate({"mesh": {"collider": collider, "tolerance": 0.002}})
            geometry = make_geometry(value, files, keys, memo)
            (figures,) = geometry.colliders
            assert figures.measures is not None
            assert figures.measures.extra is None
            assert codec.decode_geometry(codec.encode_geometry(geometry)).colliders == (figures,)


def test_a_guest_that_fails_leaves_the_hull_and_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    def fails(*_: Any) -> bytes:
        raise DecompositionFailed("the decomposition took longer than 60 s")

    monkeypatch.setattr(collide, "improved", fails)
    geometry = made(BOTH, collider="coacd", tolerance=0.0015)
    assert rungs(geometry)["Arm <1>/Bracket <1>",] == "hull"
    texts = [one.message for one in geometry.diagnostics if one.code == "W-COLLIDER"]
    assert any("Bracket" in text and "took longer than 60 s" in text for text in texts)
    assert not geometry.lasts


def test_the_files_are_those_of_the_pieces() -> None:
    """An independent reader: the written meshes of a decomposed ring leave its hole open."""
    ring = trimesh.creation.annulus(0.02, 0.03, 0.02, sections=32)
    reply = bodies_of({"Ring": ring})
    digest = sha256(reply).hexdigest()
    value = robot(part("Ring <1>", at(1), mesh=MeshRef(digest, "Ring")))
    keys = MeshSections.model_validate({"mesh": {"collider": "coacd"}})
    files = Bundle("onshape", {}, "", {}, {digest: reply})
    geometry = make_geometry(value, files, keys, lambda kind, key, make: make())
    pieces = [
        trimesh.load(io.BytesIO(geometry.files[shape.file]), file_type="stl")
        for shape in geometry.of("base", "collision")
        if shape.file
    ]
    assert 4 <= len(pieces) <= 16
    for piece in pieces:
        assert piece.is_convex
        heights = np.einsum("ij,ij->i", piece.face_normals, [1, 0, 0] - piece.triangles[:, 0])
        assert heights.max() > 0.015  # so far is the middle of the ring outside of each


@pytest.mark.parametrize("most", [5_000, 50_000])
def test_of_very_many_triangles_a_collider_is_made_of_fewer(most: int) -> None:
    """As near as it was: the figures are against the part itself within seven hundredths of the tolerance."""
    assert MOVED < 0.07 * 0.0016
    ball = trimesh.creation.icosphere(6, 0.03)
    reply = bodies_of({"Ball": ball})
    digest = sha256(reply).hexdigest()
    value = robot(part("Ball <1>", mesh=MeshRef(digest, "Ball")))
    library = MeshLibrary(value.links, Bundle("onshape", {}, "", {}, {digest: reply}))
    light = library.surface(MeshRef(digest, "Ball"), most)
    assert light is not None
    assert len(ball.faces) > most
    assert len(light.triangles) < 30_000
    apart = np.linalg.norm(light.corners.mean(axis=1), axis=1) - 0.03
    assert np.abs(apart).max() < MOVED + 1e-6
    whole = library.surface(MeshRef(digest, "Ball"), None)
    assert whole is not None
    assert len(whole.triangles) == len(ball.faces)
    assert library.surface(MeshRef(digest, "other"), most) is None


def test_the_hull_of_very_many_triangles_is_that_of_all_of_them() -> None:
    ball = trimesh.creation.icosphere(6, 0.03)
    reply = bodies_of({"Ball": ball})
    digest = sha256(reply).hexdigest()
    value = robot(part("Ball <1>", mesh=MeshRef(digest, "Ball")))
    source = Bundle("onshape", {}, "", {}, {digest: reply})
    mesh = {"collider": "hull", "max_vertices": 64, "visual": {"max_faces": 100_000}}
    keys = MeshSections.model_validate({"mesh": mesh})
    geometry = make_geometry(value, source, keys, lambda kind, key, make: make())
    (solid,) = (shape for shape in geometry.shapes if shape.role == "collision")
    expected = capped_hull(tessellation.read(reply, ["Ball"])["Ball"].surface, 64)
    assert expected is not None
    corners = trimesh.load_mesh(io.BytesIO(geometry.files[solid.file]), file_type="stl")
    np.testing.assert_allclose(
        np.sort(corners.vertices, axis=0), np.sort(expected.vertices, axis=0), atol=1e-8, rtol=0
    )


def test_a_process_starts_only_where_something_is_decomposed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(subprocess, "Popen", None)
    for mesh in ({}, {"collider": "hull"}, {"collider": "ladder", "tolerance": 0.2}):
        assert set(rungs(made(BOTH, **mesh)).values()) <= {"box", "hull"}
    with pytest.raises(TypeError):
        made(BOTH, collider="coacd")
