"""Mesh files: STL that others read, pieces that MuJoCo compiles, names that never meet."""

import io

import mujoco
import numpy as np
import pytest
import trimesh

from linkwright.stages.formats.meshes.surface import Surface, moved
from linkwright.stages.mesh.files import mesh_file as module
from linkwright.stages.mesh.files import stl
from linkwright.stages.mesh.files.mesh_file import collider, visuals
from linkwright.stages.mesh.files.names import file_names
from linkwright.stages.mesh.surfaces.convex_hull import convex_hull

CUBE = convex_hull(np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float))
RED = (1.0, 0.0, 0.0, 1.0)


def square(size=1.0, at=(0.0, 0.0, 0.0)):
    vertices = size * np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]) + at
    return Surface(vertices, np.array([[0, 1, 2], [0, 2, 3]]))


def grid(side):
    """A wavy open surface of 2·side² triangles."""
    x, y = np.meshgrid(np.arange(side + 1.0), np.arange(side + 1.0), indexing="ij")
    vertices = np.stack([x, y, np.sin(x)], axis=-1).reshape(-1, 3)
    corner = (np.arange(side)[:, None] * (side + 1) + np.arange(side)).ravel()
    right, up, over = corner + side + 1, corner + 1, corner + side + 2
    return Surface(
        vertices, np.concatenate([np.stack([corner, right, over], 1), np.stack([corner, over, up], 1)])
    )


def reread(data):
    return trimesh.load(io.BytesIO(data), file_type="stl")


def compiles(data):
    """Whether MuJoCo takes the file as a visual of a URDF, which has no word for its inertia."""
    text = """<robot name="r"><mujoco><compiler strippath="false" fusestatic="false" discardvisual="false"/>
      </mujoco><link name="a"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0"
      iyz="0"/></inertial><visual><geometry><mesh filename="m.stl"/></geometry></visual></link></robot>"""
    return mujoco.MjModel.from_xml_string(text, {"m.stl": data}).nmesh == 1


def test_a_file_is_read_back_with_its_volume_and_normals():
    data = stl.write(CUBE)
    assert data[:10] == b"linkwright"
    assert not data.startswith(b"solid")
    mesh = reread(data)
    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(1)
    stored = np.frombuffer(data[84:], dtype=np.uint8).reshape(12, 50)[:, :12].copy().view("<f4")
    assert np.allclose(stored, mesh.face_normals)
    assert len(data) == 84 + 50 * 12


def test_a_mirroring_transform_keeps_the_outside_outside():
    mirror = np.diag([-2.0, 1, 1, 1])
    mirror[:3, 3] = [1, 2, 3]
    turned = moved(CUBE, mirror)
    assert turned.volume() == pytest.approx(2)
    assert turned.vertices.min(axis=0) == pytest.approx([-1, 2, 3])
    assert moved(CUBE, np.diag([2.0, 1, 1, 1])).volume() == pytest.approx(2)


def test_figures_are_those_of_the_file():
    shape = collider(moved(CUBE, np.diag([0.1, 0.2, 0.3, 1])))
    mesh = reread(shape.data)
    assert (shape.faces, shape.vertices, shape.colour) == (12, 8, None)
    assert shape.volume == pytest.approx(mesh.volume, rel=1e-6)
    assert shape.area == pytest.approx(mesh.area, rel=1e-6)


def test_triangles_smaller_than_single_precision_are_not_written():
    vertices = np.concatenate([CUBE.vertices + 1000, [[1000, 1000, 1000 + 1e-6]]])
    surface = Surface(vertices, np.concatenate([CUBE.triangles, [[0, 8, 7]]]))
    (part,) = visuals(surface, RED)
    assert (part.faces, part.vertices) == (12, 8)


@pytest.mark.parametrize("size", [1.0, 1e-2, 1e-4])
@pytest.mark.parametrize("at", [(0, 0, 0), (3, -2, 1)])
def test_a_flat_visual_gets_a_back_that_mujoco_accepts(size, at):
    (part,) = visuals(moved(square(size), _tilted(at)), RED)
    assert part.faces == 4
    assert compiles(part.data)
    corners = reread(part.data).triangles.reshape(-1, 3)
    local = (corners - at) @ _tilted(at)[:3, :3]
    assert local[:, 2].max() < 1e-6
    assert local[:, 2].min() > -max(1e-5, size)
    assert part.area == pytest.approx(2 * size**2, rel=0.1)


def test_a_single_triangle_is_a_visual_too():
    (part,) = visuals(Surface(square().vertices, np.array([[0, 1, 2]])), RED)
    assert compiles(part.data)


def test_specks_are_left_out_and_solids_stay_as_they_are():
    assert not list(visuals(square(1e-5), RED))
    (part,) = visuals(CUBE, RED)
    assert (part.faces, part.volume, part.colour) == (12, pytest.approx(1), RED)


def test_no_file_has_more_faces_than_mujoco_reads(monkeypatch):
    monkeypatch.setattr(module, "MOST_FACES", 100)
    surface = grid(12)
    parts = list(visuals(surface, RED))
    assert sum(part.faces for part in parts) == 2 * 12 * 12
    assert max(part.faces for part in parts) <= 100
    flat = Surface(surface.vertices * [1, 1, 0], surface.triangles)
    parts = list(visuals(flat, RED))
    assert max(part.faces for part in parts) <= 100
    assert sum(part.faces for part in parts) == 2 * 2 * 12 * 12


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
    assert len({name.casefold() for name in names}) == len(names) == 2 + 1 + 2 + 1 + 1 + 1 + 1 + 1
    assert names[:2] == ["arm__1.stl", "arm__2.stl"]


def _tilted(at):
    angle = 0.7
    transform = np.eye(4)
    transform[:3, :3] = [[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]]
    transform[:3, 3] = at
    return transform
