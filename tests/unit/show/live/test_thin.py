"""Meshes with fewer triangles stay near to what they were."""

import numpy as np
import pytest
import trimesh
from scipy.spatial import cKDTree

from linkwright.stages.show.decimate import Simplifiable
from linkwright.stages.show.live import pack, scene
from linkwright.stages.show.live.decimate import SimplifiableMesh, clustered, simplify_to_budget
from linkwright.stages.show.live.pack import Buffers
from linkwright.stages.show.live.scene import pack_of
from linkwright.stages.show.live.triangles import STEPS, Facets, store
from tests.support.live_robots import INCLUDED, bumpy, stl, triangles, write
from tests.support.robots import robot_with


def facets(corners):
    mesh = trimesh.Trimesh(**trimesh.triangles.to_kwargs(corners))
    mesh.merge_vertices()
    return Facets(np.array(mesh.vertices), np.array(mesh.faces), len(mesh.faces))


def hausdorff(first, other):
    """The two-sided Hausdorff distance [m], by points that lie close on either surface."""
    meshes = [trimesh.Trimesh(facets.points, facets.corners, process=False) for facets in (first, other)]
    a, b = (np.concatenate([m.vertices, trimesh.sample.sample_surface(m, 60_000, seed=1)[0]]) for m in meshes)
    return max(cKDTree(b).query(a)[0].max(), cKDTree(a).query(b)[0].max())


SAMPLING = 0.003
"""How far the nearest sample of a surface of this size may be [m]."""


def simpler(mesh, tolerance):
    return SimplifiableMesh(mesh).simpler(tolerance)


@pytest.mark.parametrize("way", [simpler, clustered], ids=lambda way: way.__name__)
@pytest.mark.parametrize("tolerance", [0.008, 0.016])
def test_simpler_mesh_is_within_its_tolerance(way, tolerance):
    mesh = facets(bumpy(5))
    made = way(mesh, tolerance)
    assert len(made.corners) < len(mesh.corners) / 2
    assert made.of_faces == len(mesh.corners)
    assert hausdorff(mesh, made) < 1.5 * tolerance + SAMPLING


def test_meshes_have_one_tolerance_so_small_ones_thin_first():
    large, small = facets(bumpy(4)), facets(bumpy(4, 0.005))
    made = simplify_to_budget({"large": large, "small": small}, {"large": 1, "small": 1}, 2500)
    faces = {name: len(value.corners) for name, value in made.items()}
    assert 1500 < sum(faces.values()) <= 2500
    assert faces["small"] < faces["large"] / 5


def test_uses_count_and_loose_triangles_are_thinned():
    mesh = facets(bumpy(3))
    count = len(mesh.corners)
    assert simplify_to_budget({0: mesh}, {0: 1}, count)[0] is mesh
    assert len(simplify_to_budget({0: mesh}, {0: 3}, count)[0].corners) <= count / 3
    rng = np.random.default_rng(0)
    loose = facets(rng.normal(size=(4000, 1, 3)) + 0.02 * rng.normal(size=(4000, 3, 3)))
    assert 0 < len(simplify_to_budget({0: loose}, {0: 1}, 800)[0].corners) <= 800


def test_of_too_many_meshes_the_smallest_are_left_out():
    meshes = {index: facets(bumpy(1, 0.01 * (index + 1))) for index in range(30)}
    made = simplify_to_budget(meshes, dict.fromkeys(meshes, 1), 100)
    faces = [len(made[index].corners) for index in meshes]
    assert 0 < sum(faces) <= 100
    assert faces == sorted(faces)


def test_mesh_that_manifold3d_does_not_take_is_clustered(monkeypatch):
    monkeypatch.setattr(Simplifiable, "simplified", lambda *_: None)
    mesh = facets(bumpy(4))
    made = simpler(mesh, 0.01)
    assert 0 < len(made.corners) < len(mesh.corners)


def test_page_has_at_most_this_number_of_triangles_and_says_so(tmp_path):
    write(tmp_path)
    (tmp_path / "assets" / "shell.stl").write_bytes(stl(bumpy(5)))
    header, content = pack.read_pack(pack_of(tmp_path, "scene.xml", robot_with(()), (), 2000))
    roles = {geom["role"]: geom["mesh"] for geom in header["geoms"] if geom["type"] == "mesh"}
    faces, collider = (header["meshes"][roles[role]]["faces"] for role in ("visual", "collision"))
    assert 500 < faces <= 2000
    assert header["meshes"][roles["visual"]]["of_faces"] == 20_480
    assert header["thinned"] == {"faces": faces + collider, "of_faces": 20_480 + collider}
    assert len(triangles(header, content, roles["visual"])) == faces
    # The engine's copy has the colliders as they are.
    (place,) = header["engine"]["files"].values()
    file = (tmp_path / "assets" / "hull.stl").read_bytes()
    assert content[place["at"] : place["at"] + place["bytes"]] == file
    # A geom whose mesh is left out is no geom.
    header, _ = pack.read_pack(pack_of(tmp_path, "scene.xml", robot_with(()), (), 1))
    assert [geom for geom in header["geoms"] if geom["type"] == "mesh"] == []
    assert header["meshes"] == []
    assert header["thinned"]["faces"] == 0
    assert INCLUDED.count('type="mesh"') == 2


def test_many_points_have_long_indices_and_flat_meshes_no_step():
    grid = np.stack(np.meshgrid(np.arange(260.0), np.arange(260.0)), axis=-1).reshape(-1, 2)
    points = np.column_stack([grid, np.full(len(grid), 0.5)])
    first = np.arange(len(points) - 261)
    corners = np.stack([first, first + 1, first + 260], axis=1)
    buffers = Buffers()
    entry = store(Facets(points, corners, len(corners)), buffers)
    assert entry["indices"]["bytes"] == 4
    assert entry["positions"]["step"] == pytest.approx([259 / STEPS, 259 / STEPS, 0], rel=1e-9)
    corners_read = triangles({"meshes": [entry]}, buffers.content(), 0)
    np.testing.assert_allclose(corners_read, points[corners], atol=259 / STEPS)


def test_points_that_fall_together_are_one():
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1e-9, 0, 0], [0, 0, 1]])
    corners = np.array([[0, 1, 2], [0, 1, 3], [3, 1, 4]])
    buffers = Buffers()
    entry = store(Facets(points, corners, 3), buffers)
    assert (entry["positions"]["count"], entry["faces"], entry["of_faces"]) == (4, 2, 3)


def test_large_pack_has_fewer_triangles_then_no_engine(tmp_path, monkeypatch):
    write(tmp_path)
    (tmp_path / "assets" / "shell.stl").write_bytes(stl(bumpy(5)))
    whole = pack_of(tmp_path, "scene.xml", robot_with(()), (), 100_000)
    monkeypatch.setattr(scene, "MAX_BYTES", len(whole) // 3)
    smaller = pack_of(tmp_path, "scene.xml", robot_with(()), (), 20_480)
    assert len(smaller) <= len(whole) // 3
    header, _ = pack.read_pack(smaller)
    assert header["engine"] is not None
    assert header["thinned"]["faces"] < header["thinned"]["of_faces"]
    without = pack_of(tmp_path, "scene.xml", robot_with(()), (), 1)
    monkeypatch.setattr(scene, "MAX_BYTES", 2 * len(without) - 1000)
    header, _ = pack.read_pack(pack_of(tmp_path, "scene.xml", robot_with(()), (), 100))
    assert (header["engine"], header["no_engine"]) == (None, "the colliders are too large for a page")
    monkeypatch.setattr(scene, "MAX_BYTES", 100)
    with pytest.raises(ValueError, match="too large for a page"):
        pack_of(tmp_path, "scene.xml", robot_with(()), (), 1000)
