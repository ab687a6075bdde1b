"""Which files the checks may read: regular ones, of bounded sizes and counts."""

import os
import struct
from pathlib import Path

import pytest

from linkwright.stages.robot.errors import SourceError
from linkwright.stages.validate.reading import admission
from linkwright.stages.validate.reading.admission import admitted

MESH = '<mujoco><asset><mesh name="m" file="{}"/></asset></mujoco>'


def put(path: Path, text: str | bytes) -> Path:
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
        ("LARGEST_TEXT", 10, "<mujoco><worldbody/></mujoco>", "longer than"),
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


def test_the_pixels_of_all_images_count(tmp_path):
    head = b"\x89PNG\r\n\x1a\n" + struct.pack(">I4sII", 13, b"IHDR", 6000, 6000)
    textures = "".join(f'<texture name="{name}" type="2d" file="{name}.png"/>' for name in "ab")
    model = put(tmp_path / "m.xml", f"<mujoco><asset>{textures}</asset></mujoco>")
    put(tmp_path / "a.png", head)
    admitted(model)
    put(tmp_path / "b.png", head)
    with pytest.raises(SourceError, match="pixels"):
        admitted(model)


def test_a_name_that_no_file_can_have_is_left_to_a_check(tmp_path):
    model = put(tmp_path / "m.xml", MESH.format("m" * 100_000))
    assert admitted(model).assets == 0


def test_models_in_models_are_looked_through_once_each(tmp_path):
    for first, other in ("ab", "ba"):
        put(
            tmp_path / f"{first}.xml", f'<mujoco><asset><model name="m" file="{other}.xml"/></asset></mujoco>'
        )
    assert admitted(tmp_path / "a.xml").texts == 2 * (tmp_path / "a.xml").stat().st_size
