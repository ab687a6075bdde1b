"""Mesh files: STL that others read, pieces that MuJoCo compiles, names that never meet."""

import io

import mujoco
import numpy as np
import pytest
import trimesh

from linkwright.stages.formats.meshes.surface import Surface, moved
from linkwright.stages.mesh.files import mesh_file, stl
from linkwright.stages.mesh.files.mesh_file import collider, visuals
from linkwright.stages.mesh.files.names import file_names
from linkwright.stages.mesh.surfaces.convex_hull import convex_hull
from linkwright.stages.robot.model.poses import from_parts, rotation_from_rpy

CUBE = convex_hull(np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float))
RED = (1.0, 0.0, 0.0, 1.0)


def square(size=1.0):
    corners = size * np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    return Surface(corners, np.array([[0, 1, 2], [0, 2, 3]]))


def reread(data):
    return trimesh.load(io.BytesIO(data), file_type="stl")


def compiles(data):
    """Whether MuJoCo takes the file as a visual of a URDF, which has no word for its inertia."""
    text = """<robot name="r"><mujoco><compiler strippath="false" fusestatic="false" discardvisual="false"/>
      </mujoco><link name="a"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0"
      iyz="0"/></inertial><visual><geometry><mesh filename="m.stl"/></geometry></visual></link></robot>"""
    return mujoco.MjModel.from_xml_string(text, {"m.stl": data}).nmesh == 1


def test_file_is_read_back_with_its_volume_and_normals():
    data = stl.write(CUBE)
    assert (data[:10], len(data)) == (b"linkwright", 84 + 50 * 12)
    mesh = reread(data)
    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(1)
    stored = np.frombuffer(data[84:], dtype=np.uint8).reshape(12, 50)[:, :12].copy().view("<f4")
    assert np.allclose(stored, mesh.face_normals)
    shape = collider(moved(CUBE, np.diag([0.1, 0.2, 0.3, 1])))
    mesh = reread(shape.data)
    assert (shape.faces, shape.vertices, shape.colour) == (12, 8, None)
    assert (shape.volume, shape.area) == pytest.approx((mesh.volume, mesh.area), rel=1e-6)


def test_mirroring_transform_keeps_the_outside_outside():
    mirror = np.diag([-2.0, 1, 1, 1])
    mirror[:3, 3] = [1, 2, 3]
    turned = moved(CUBE, mirror)
    assert turned.volume() == moved(CUBE, np.diag([2.0, 1, 1, 1])).volume() == pytest.approx(2)
    assert turned.vertices.min(axis=0) == pytest.approx([-1, 2, 3])


def test_triangles_smaller_than_single_precision_are_not_written():
    vertices = np.concatenate([CUBE.vertices + 1000, [[1000, 1000, 1000 + 1e-6]]])
    (part,) = visuals(Surface(vertices, np.concatenate([CUBE.triangles, [[0, 8, 7]]])), RED)
    assert (part.faces, part.vertices) == (12, 8)


@pytest.mark.parametrize("size", [1.0, 1e-2, 1e-4])
@pytest.mark.parametrize("place", [(0, 0, 0), (3, -2, 1)])
def test_flat_visual_gets_a_back_that_mujoco_accepts(size, place):
    pose = from_parts(rotation_from_rpy((0, 0.7, 0)), np.array(place, dtype=float))
    (part,) = visuals(moved(square(size), pose), RED)
    assert part.faces == 4
    assert compiles(part.data)
    heights = ((reread(part.data).triangles.reshape(-1, 3) - place) @ pose[:3, :3])[:, 2]
    assert -max(1e-5, size) < heights.min() <= heights.max() < 1e-6
    assert part.area == pytest.approx(2 * size**2, rel=0.1)


def test_single_triangles_and_solids_are_written_and_specks_left_out():
    (triangle,) = visuals(Surface(square().vertices, np.array([[0, 1, 2]])), RED)
    assert compiles(triangle.data)
    assert not list(visuals(square(1e-5), RED))
    (part,) = visuals(CUBE, RED)
    assert (part.faces, part.volume, part.colour) == (12, pytest.approx(1), RED)


@pytest.mark.parametrize(("height", "sides"), [(1, 1), (0, 2)], ids=["wavy", "flat with a back"])
def test_no_file_has_more_faces_than_mujoco_reads(monkeypatch, height, sides):
    monkeypatch.setattr(mesh_file, "MAX_FACES", 100)
    x, y = np.meshgrid(np.arange(13.0), np.arange(13.0), indexing="ij")
    points = np.stack([x, y, height * np.sin(x)], axis=-1).reshape(-1, 3)
    corner = (np.arange(12)[:, None] * 13 + np.arange(12)).ravel()
    halves = np.stack([corner, corner + 13, corner + 14], 1), np.stack([corner, corner + 14, corner + 1], 1)
    parts = list(visuals(Surface(points, np.concatenate(halves)), RED))
    assert sum(part.faces for part in parts) == sides * 2 * 12 * 12
    assert max(part.faces for part in parts) <= 100


def test_file_names_follow_the_link_and_number_only_several():
    assert file_names({"base": (1, 1), "arm": (2, 2), "tip": (0, 0), "leaf": (1, 0), "fin": (0, 1)}) == {
        "base": (["base.stl"], ["base_collision.stl"]),
        "arm": (["arm_1.stl", "arm_2.stl"], ["arm_collision_1.stl", "arm_collision_2.stl"]),
        "tip": ([], []),
        "leaf": (["leaf.stl"], []),
        "fin": ([], ["fin_collision.stl"]),
    }
    many, _ = file_names({"arm": (12, 1)})["arm"]
    assert many == sorted(many)


def test_file_names_of_links_that_look_like_files_never_meet():
    links = {"arm": (2, 1), "ARM_1": (2, 1), "arm_1_1": (1, 1), "arm_collision": (1, 1)}
    names = [name for visuals, colliders in file_names(links).values() for name in [*visuals, *colliders]]
    assert len({name.casefold() for name in names}) == len(names) == 10
    assert names[:2] == ["arm__1.stl", "arm__2.stl"]
