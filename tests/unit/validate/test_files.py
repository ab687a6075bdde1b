"""Files that the checks read: bounded in size and count, each fault of their text found at its place."""

import os
import struct

import mujoco
import pytest

from linkwright.stages.robot.check import Finding
from linkwright.stages.robot.errors import SourceError
from linkwright.stages.validate.files.run import check_document, check_folder, read_checked
from linkwright.stages.validate.reading import admission
from linkwright.stages.validate.reading.admission import admitted
from linkwright.stages.validate.reading.documents import read
from linkwright.stages.validate.reading.located import located
from tests.support.faults.arm import MJCF, box_stl, problems, replace_last, write_arm
from tests.support.faults.bare import FAULTS, IN_A_BUILD
from tests.support.mujoco_schema import schema

TEXT = {"C-XML", "C-XML-KNOWN", "C-NAME", "C-NUMBER", "C-REFERENCE", "C-ASSET", "C-PATH"}

SCENE = """<mujoco model="scene"><include file="arm.xml"/>
<asset><texture name="checker" type="2d" builtin="checker" width="9" height="9"/>
<material name="floor" texture="checker"/></asset>
<worldbody><geom name="floor" type="plane" size="1 1 1" material="floor"/></worldbody></mujoco>
"""

STL = box_stl(0.07, 0.07, 0.2)


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "scene.xml").write_text(SCENE)
    return write_arm(tmp_path)


def checked(folder):
    return list(check_folder(folder, ("arm.xml", "scene.xml", "arm.urdf")))


def wrong(folder):
    """File, code, element and attribute of each finding."""
    checks = checked(folder)
    return {(check.name.partition(":")[0], *row) for check in checks for row in problems([check])}


def test_good_files_pass_every_check_from_any_folder(folder, monkeypatch):
    """Files are looked for where the model lies, not where the program runs."""
    monkeypatch.chdir("/")
    assert wrong(folder) == set()
    assert {problem.code for problem in checked(folder)} >= TEXT
    mujoco.MjModel.from_xml_path(str(folder / "scene.xml"))


@pytest.mark.parametrize(
    "fault",
    [fault for fault in (*FAULTS, *IN_A_BUILD) if TEXT.issuperset(fault.codes)],
    ids=lambda fault: fault.title,
)
def test_fault_of_a_text_is_found_in_its_file_alone(folder, fault):
    planted = fault.change(folder, "arm")
    file = "arm.urdf" if fault.file == "bare urdf" else "arm.xml"
    assert (file, *fault.codes, *planted.elements, *planted.attributes) in wrong(folder)
    # A broken file is named by the scene that includes it, too.
    scene = {"scene.xml"} if fault.title == "bare mjcf: broken" else set()
    assert {name for name, *_ in wrong(folder)} == {file, *scene}
    if file == "arm.xml" and fault.kind != "nan":  # which MuJoCo only warns of
        with pytest.raises(ValueError, match="Error"):
            mujoco.MjModel.from_xml_path(str(folder / "arm.xml"))


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ('material="floor"', 'material="flour"', ("C-REFERENCE", 'geom "floor"', "material")),
        ('<geom name="floor"', '<geom name="upper"', ("C-NAME", 'geom "upper"', "name")),
        ('"arm.xml"', '"leg.xml"', ("C-XML", "include", "file")),
        ('"arm.xml"', '"scene.xml"', ("C-XML", "include", "file")),
    ],
)
def test_faults_of_a_scene_are_its_own(folder, old, new, expected):
    replace_last(folder / "scene.xml", old, new)
    assert ("scene.xml", *expected) in wrong(folder)
    assert {name for name, *_ in wrong(folder)} == {"scene.xml"}
    if expected[0] == "C-NAME":
        (finding,) = (item for check in checked(folder) for item in check.findings)
        assert "arm.xml, line" in finding.message


@pytest.mark.parametrize(
    ("name", "data"),
    [
        ("lower.stl", b""),
        ("lower.stl", STL[:-7]),
        ("lower.stl", STL[:60]),
        ("lower.stl", b"solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n"),
        ("lower.stl", STL[:100] + struct.pack("<f", float("nan")) + STL[104:]),
        ("other.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n"),
        ("other.obj", b"v 0 0 0\n"),
        ("other.obj", b"v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
        ("other.dae", b"<COLLADA><asset>"),
        ("other.glb", b"glTF" + struct.pack("<II", 2, 100) + b"\0" * 40),
    ],
)
def test_mesh_that_is_not_whole_is_found(folder, name, data):
    (folder / name).write_bytes(data)
    replace_last(folder / "arm.urdf", "lower.stl", name)
    assert ("arm.urdf", "C-ASSET", 'mesh of visual of link "lower"', "filename") in wrong(folder)


def test_file_that_no_model_names_is_a_warning(folder):
    (folder / "assets").mkdir()
    (folder / "assets" / "old.stl").write_bytes(STL)
    (check,) = (candidate for candidate in checked(folder) if not candidate.passed)
    assert (check.code, check.level) == ("C-ASSET-UNUSED", "warning")
    assert check.findings[0].element == "assets/old.stl"
    (folder / "arm.sdf").write_text("<sdf><uri>model://arm/assets/old.stl</uri></sdf>")
    assert all(check.passed for check in check_folder(folder, ("arm.xml", "arm.urdf"), ("arm.sdf",)))


def test_unknown_element_is_an_error_where_the_engine_refuses_it(folder):
    replace_last(folder / "arm.urdf", 'velocity="3"', 'velocty="3"')
    replace_last(folder / "arm.xml", 'range="-1.5 1.5"/>', 'rnage="-1.5 1.5"/>')
    levels = {check.name: check.level for check in checked(folder) if not check.passed}
    assert levels == {"arm.urdf: elements": "warning", "arm.xml: elements": "error"}


def test_finding_names_its_line(folder):
    replace_last(folder / "arm.xml", 'kp="20"', 'kp="ten"')
    (finding,) = (item for check in checked(folder) for item in check.findings)
    line = next(number for number, text in enumerate(MJCF.splitlines(), 1) if 'kp="20"' in text)
    assert f"(line {line})" in finding.message


def test_refusal_that_names_no_place_is_of_the_file(folder):
    assert located(folder / "arm.xml", "it is\nfull") == (Finding("arm.xml", "", "it is full"),)


def test_entities_are_no_xml_that_is_read(folder):
    (folder / "arm.urdf").write_text('<!DOCTYPE r [<!ENTITY a "b">]><robot name="&a;"/>')
    document, check = read_checked(folder / "arm.urdf")
    assert document is None
    assert not check.passed


@pytest.mark.parametrize(("way", "attributes"), [row for row in schema() if row[0]])
def test_every_element_that_mujoco_lists_is_known(way, attributes, tmp_path):
    tags = ["worldbody" if index == 0 and tag == "body" else tag for index, tag in enumerate(way)]
    text = "".join(f"<{tag}>" for tag in tags[:-1]) + f"<{tags[-1]}"
    if tags[-1] != "worldbody":
        text += "".join(f' {name}=""' for name in attributes)
    text += "/>" + "".join(f"</{tag}>" for tag in reversed(tags[:-1]))
    (tmp_path / "some.xml").write_text(f"<mujoco>{text}</mujoco>")
    (spelling,) = [
        check for check in check_document(read(tmp_path / "some.xml")) if check.code == "C-XML-KNOWN"
    ]
    assert spelling.passed, spelling.detail


MESH = '<mujoco><asset><mesh name="m" file="{}"/></asset></mujoco>'


def put(path, text):
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    return path


def test_sizes_are_those_of_texts_and_of_what_they_name(tmp_path):
    model = put(tmp_path / "m.xml", MESH.format("a.stl"))
    put(tmp_path / "a.stl", bytes(100))
    put(tmp_path / "b.stl", bytes(1000))
    sizes = admitted(model)
    assert (sizes.texts, sizes.assets) == (model.stat().st_size, 100)
    assert admitted(tmp_path) == sizes


def test_of_a_build_every_file_counts(tmp_path):
    put(tmp_path / "robot.json", "{}")
    (tmp_path / "assets").mkdir()
    put(tmp_path / "assets" / "b.stl", bytes(1000))
    assert admitted(tmp_path).assets == 1000


@pytest.mark.skipif(os.name == "nt", reason="it has no pipes")
@pytest.mark.parametrize("name", ["a.stl", "/dev/zero", "a.xml"])
def test_what_is_no_file_is_refused(tmp_path, name):
    text = f'<mujoco><include file="{name}"/></mujoco>' if name.endswith("xml") else MESH.format(name)
    model = put(tmp_path / "m.xml", text)
    if not name.startswith("/"):
        os.mkfifo(tmp_path / name)
    with pytest.raises(SourceError, match="only regular files are read"):
        admitted(model)


@pytest.mark.skipif(os.name == "nt", reason="it has no pipes")
def test_what_no_check_reads_may_be_anything(tmp_path):
    put(tmp_path / "m.xml", "<mujoco/>")
    os.mkfifo(tmp_path / "console")
    (tmp_path / "deeper").mkdir()
    os.mkfifo(tmp_path / "deeper" / "m.xml")
    assert admitted(tmp_path).texts == len("<mujoco/>")


@pytest.mark.parametrize(
    ("key", "most", "text", "words"),
    [
        ("MAX_XML_BYTES", 10, "<mujoco><worldbody/></mujoco>", "longer than"),
        ("MAX_MARKS", 3, "<mujoco><worldbody/></mujoco>" + "<!-- -->" * 3, "elements or tables"),
        ("MAX_ELEMENTS", 1, "<mujoco><worldbody/></mujoco>", "more than 1 elements"),
        ("MAX_TOTAL_BYTES", 10, "<mujoco><worldbody/></mujoco>", "more than"),
    ],
)
def test_what_is_too_large_is_refused(tmp_path, monkeypatch, key, most, text, words):
    model = put(tmp_path / "m.xml", text)
    admitted(model)
    monkeypatch.setattr(admission, key, most)
    with pytest.raises(SourceError, match=words):
        admitted(model)


def test_pixels_of_all_images_count(tmp_path):
    head = b"\x89PNG\r\n\x1a\n" + struct.pack(">I4sII", 13, b"IHDR", 6000, 6000)
    textures = "".join(f'<texture name="{name}" type="2d" file="{name}.png"/>' for name in "ab")
    model = put(tmp_path / "m.xml", f"<mujoco><asset>{textures}</asset></mujoco>")
    put(tmp_path / "a.png", head)
    admitted(model)
    put(tmp_path / "b.png", head)
    with pytest.raises(SourceError, match="pixels"):
        admitted(model)


def test_name_that_no_file_can_have_is_left_to_a_check(tmp_path):
    model = put(tmp_path / "m.xml", MESH.format("m" * 100_000))
    assert admitted(model).assets == 0


def test_models_in_models_are_looked_through_once_each(tmp_path):
    for first, other in ("ab", "ba"):
        put(
            tmp_path / f"{first}.xml", f'<mujoco><asset><model name="m" file="{other}.xml"/></asset></mujoco>'
        )
    assert admitted(tmp_path / "a.xml").texts == 2 * (tmp_path / "a.xml").stat().st_size
