"""`mesh.format: glb`: one GLB a link in URDF, SDF and ROS 2, and the meshes as they are elsewhere."""

import re
from collections import Counter
from pathlib import Path

import mujoco
import numpy as np
import pytest
import trimesh

from linkwright.stages.formats.described import read_robot_json
from linkwright.stages.formats.xml import parse
from linkwright.stages.robot import codec
from linkwright.stages.show.live.compiled import compile_live
from linkwright.stages.show.preview import needed_by
from linkwright.stages.show.preview.compiled import look_of_files
from linkwright.stages.show.preview.surface import surface_of
from tests.fake_onshape import solids
from tests.support.building import shaped, write
from tests.support.checked import checked
from tests.support.kit import SIDE, TOP, Kit, two_arms
from tests.support.textures import built_into, by_trimesh, cube, image, obj, ordered, put, urdf, visual

FORMATS = ("urdf", "mjcf", "sdf", "usd", "ros2")


def built(folder, formats=FORMATS, **mesh):
    """A base of two colours with two equal arms, written into a folder."""
    kit = Kit()
    base = two_arms(kit)
    cap = kit.studio.part("Cap", solids.box(0.05, 0.05, 0.02), colour=(51, 102, 153, 128), density=900)
    kit.root.fasten("Glue", (kit.root.add(cap), SIDE), (base, TOP))
    keys = {"mesh": {"format": "glb", **mesh}, "export": {name: {} for name in formats}}
    robot, geometry, plan = shaped(kit.document, **keys)
    geometry = codec.decode_geometry(codec.encode_geometry(geometry))
    return robot, geometry, plan, write(robot, folder, plan, geometry).files


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A build of all formats, and its folder."""
    folder = tmp_path_factory.mktemp("whole")
    return (*built(folder), folder)


def triangles(path):
    """The triangles of a mesh file as trimesh reads them, in an order of their own."""
    return ordered(trimesh.load_scene(path, process=False).to_geometry().triangles)


def test_each_link_has_one_file_with_the_triangles_of_its_meshes(whole):
    _, geometry, _, _, folder = whole
    visuals = Counter(shape.link for shape in geometry.shapes if shape.role == "visual")
    assert visuals == {"base": 2, "left": 1, "right": 1}
    names = {"base": "base.glb", "left": "left.glb", "right": "left.glb"}
    assert {shape.link: shape.file for shape in geometry.whole_visuals} == names
    for shape in geometry.whole_visuals:
        parts = [
            triangles(folder / "assets" / part.file) for part in geometry.shapes_of(shape.link, "visual")
        ]
        corners = triangles(folder / "assets" / shape.file)
        assert np.array_equal(corners, ordered(np.concatenate(parts)))
        assert len(corners) == shape.faces
        points = corners.reshape(-1, 3)
        assert np.allclose([*points.min(axis=0), *points.max(axis=0)], shape.bounds, atol=1e-6)


def test_every_format_shows_what_its_readers_take(whole):
    *_, folder = whole

    def texts(name, pattern):
        return parse((folder / name).read_bytes()).xpath(pattern)

    glbs = ["assets/base.glb", "assets/left.glb", "assets/left.glb"]
    assert texts("robot.urdf", "//visual/geometry/mesh/@filename") == glbs
    assert texts("robot.urdf", "//material") == texts("robot.sdf", "//visual/material") == []
    assert texts("robot.urdf", "//compiler/@discardvisual") == ["true"]
    assert texts("robot.sdf", "//visual//uri/text()") == glbs
    stl = texts("robot.urdf", "//collision/geometry/mesh/@filename") + texts("robot.xml", "//mesh/@file")
    stl += texts("robot.sdf", "//collision//uri/text()")
    assert {Path(name).suffix for name in stl} == {".stl"}
    package = folder / "ros2" / "robot_description"
    named = re.findall('meshes/([^"]+)"', (package / "urdf" / "robot.urdf").read_text())
    assert {path.name for path in (package / "meshes").iterdir()} == {*named}
    assert {Path(name).suffix for name in named} == {".glb", ".stl"}


def test_mjcf_and_usd_are_those_of_stl_meshes(whole, tmp_path):
    _, _, _, files, _ = whole
    *_, with_stl = built(tmp_path, format="stl")
    same = [name for name in with_stl if not re.search("urdf|sdf|robot.json|^ros2/", name)]
    assert {name: files[name] for name in same} == {name: with_stl[name] for name in same}


def test_checks_compile_such_a_urdf_and_pass(whole):
    robot, geometry, plan, _, folder = whole
    checks = checked(folder, robot, plan, geometry=geometry)
    assert [check for check in checks if check.fails] == []
    assert any(check.code == "C-SHAPE" and check.name.startswith("robot.urdf") for check in checks)
    model = mujoco.MjModel.from_xml_path(str(folder / "robot.urdf"))
    assert model.ngeom == sum(shape.role == "collision" for shape in geometry.shapes)
    assert model.body_mass.sum() == pytest.approx(sum(link.inertial.mass for link in robot.links))


@pytest.mark.parametrize(
    ("before", "after", "words"),
    [
        ('discardvisual="true"', 'discardvisual="false"', "decoder|discardvisual"),
        ("assets/left.glb", "assets/base.glb", "left.glb"),
        ("assets/left.glb", "assets/none.glb", "none.glb"),
    ],
)
def test_change_in_the_urdf_is_reported(tmp_path, before, after, words):
    robot, geometry, plan, files = built(tmp_path, ["urdf"])
    (tmp_path / "robot.urdf").write_text(files["robot.urdf"].decode().replace(before, after))
    failed = [check for check in checked(tmp_path, robot, plan, geometry=geometry) if check.fails]
    messages = [check.detail + "".join(finding.message for finding in check.findings) for check in failed]
    assert any(re.search(words, message) for message in messages), messages


@pytest.mark.parametrize(
    ("formats", "endings"),
    [
        (["urdf"], {".glb": 2, ".stl": 2}),
        (["sdf"], {".glb": 2, ".stl": 2}),
        (["mjcf"], {".stl": 5}),
        (["urdf", "mjcf"], {".glb": 2, ".stl": 5}),
    ],
)
def test_only_files_that_the_formats_name_are_written(tmp_path, formats, endings):
    robot, geometry, plan, files = built(tmp_path, formats)
    assert Counter(path.suffix for path in (tmp_path / "assets").iterdir()) == endings
    assert [row for row in checked(tmp_path, robot, plan, geometry=geometry) if row.fails] == []
    if "urdf" in formats:  # robot.json has what the URDF shows
        read = read_robot_json(files["robot.json"]).written.geometry

        def shown(geometry):
            return [(row.link, row.role, row.file) for row in geometry.with_whole_visuals.shapes]

        assert shown(read) == shown(geometry)
        for shape in (*read.shapes, *read.whole_visuals):
            assert (tmp_path / "assets" / shape.file).is_file()


def test_pages_and_pictures_show_a_urdf_with_glb_as_with_stl(tmp_path):
    drawn = []
    for form in ("stl", "glb"):
        *_, files = built(tmp_path / form, ["urdf"], format=form)
        needed = {name: files[name] for name in needed_by("robot.urdf", files)}
        surface = surface_of(look_of_files("robot.urdf", needed))
        rows = np.concatenate([surface.corners.reshape(-1, 9), surface.colours[surface.geom]], axis=1)
        drawn.append(rows[np.lexsort(np.round(rows, 5).T)])
        model = compile_live(tmp_path / form, "robot.urdf").model
        assert (model.geom_contype == 0).sum() == 4
    assert np.allclose(*drawn, atol=1e-5)


def test_textured_mesh_has_its_image_in_the_glb(tmp_path):
    put(tmp_path / "source", **{"robot.urdf": urdf(visual("cube.obj")), "cube.obj": obj(cube())})
    put(tmp_path / "source", **{"m.mtl": b"newmtl m\nKd 0.5 0.75 1\nmap_Kd four.png\n", "four.png": image()})
    files = {}
    for source, folder in (("source", "first"), ("first", "second")):
        keys = {"kind": "urdf", "path": str(tmp_path / source / "robot.urdf")}
        files[folder] = built_into(tmp_path / folder, keys, format="glb")[1].files
    assert sorted(Path(name).suffix for name in files["first"]) == [".glb", ".mtl", ".obj", ".png"]
    assert image() in files["first"]["a.glb"]
    (mesh,) = trimesh.load_scene(tmp_path / "first/assets/a.glb", process=False).geometry.values()
    read_back = np.concatenate([mesh.vertices, mesh.visual.uv], axis=1)[mesh.faces]
    assert np.allclose(ordered(read_back), ordered(by_trimesh(tmp_path / "first/assets/a.obj")), atol=2e-6)
    for name in ("a.glb", "a.obj"):
        assert files["second"][name] == files["first"][name]


@pytest.mark.parametrize("up", ["z", "y"])
def test_files_are_a_source_of_the_same_robot(tmp_path, up):
    _, geometry, _, _ = built(tmp_path / "first", ["urdf"], glb_up=up)
    again = {"kind": "urdf", "path": str(tmp_path / "first" / "robot.urdf")}
    _, second, _ = built_into(tmp_path / "second", again)
    for link in ("base", "left"):
        first, other = (
            sorted(shapes.shapes_of(link, "visual"), key=lambda shape: shape.colour)
            for shapes in (geometry, second)
        )
        assert [(row.colour, row.faces) for row in first] == [(row.colour, row.faces) for row in other]
        assert np.allclose([row.bounds for row in first], [row.bounds for row in other], atol=1e-6)
