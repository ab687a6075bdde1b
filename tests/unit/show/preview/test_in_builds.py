"""The picture of a whole build: in its folder, its page and its last line; and none that is out of date."""

import base64
import json
import threading

import pytest

from linkwright.pipeline.config.plan import Plan
from linkwright.pipeline.errors import LinkwrightError
from linkwright.pipeline.output import manifest
from linkwright.pipeline.run.build import build
from linkwright.pipeline.terminal.closing import closing_lines
from linkwright.stages.show.preview import ENDED, PICTURE, ask
from tests.support.pictures import pixels_of, robot_in

URDF = """<robot name="arm"><link name="base"><visual><geometry><box size="0.2 0.2 0.05"/></geometry></visual>
    <inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="arm"><visual><origin xyz="0 0 0.3"/><geometry><box size="0.1 0.1 0.6"/></geometry>
    <material name="red"><color rgba="0.9 0.1 0.1 1"/></material></visual>
    <inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="hinge" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
</robot>"""


@pytest.fixture
def make(tmp_path, whole_page):
    (tmp_path / "arm.urdf").write_text(URDF)

    def run(**more):
        tree = {
            "name": "arm",
            "source": {"kind": "urdf", "path": str(tmp_path / "arm.urdf")},
            "output": str(tmp_path / "out"),
            "cache": {"dir": str(tmp_path / "cache")},
            "until": "export",
        }
        return build(Plan.parse(tree | more))

    return run


def test_build_leaves_its_picture_and_none_is_out_of_date(make, tmp_path, monkeypatch):
    out = tmp_path / "out"
    first = make()
    data = (out / PICTURE).read_bytes()
    assert robot_in(pixels_of(data)).mean() > 0.02
    assert (first.preview, PICTURE in first.outputs) == (PICTURE, False)
    assert closing_lines(first)[-1] == f"arm: {out} (report.html, preview.png)"
    page = (out / "report.html").read_text()
    assert f'href="{PICTURE}"' in page
    inside = page.partition("data:image/png;base64,")[2].partition('"')[0]
    assert robot_in(pixels_of(base64.b64decode(inside))).mean() > 0.02
    # From the cache, nothing is drawn again.
    monkeypatch.setattr(ask, "pictures_of", lambda *_, **__: pytest.fail("it is in the cache"))
    make()
    assert (out / PICTURE).read_bytes() == data
    assert PICTURE in json.loads((out / ".linkwright.json").read_text())["files"]
    # A failed build has none, and that of before stays.
    with pytest.raises(LinkwrightError):
        make(joints={"nothing": {"damping": 1}})
    assert not (tmp_path / "out.failed" / PICTURE).exists()
    assert (out / PICTURE).read_bytes() == data
    assert make(until="graph").preview == ""
    assert not (tmp_path / "out.graph" / PICTURE).exists()
    # Without a picture, that of before goes.
    last = make(page={"preview": "none"})
    assert (last.preview, (out / PICTURE).exists()) == ("", False)
    assert closing_lines(last)[-1] == f"arm: {out}"


@pytest.mark.parametrize("formats", [["urdf"], ["mjcf"]])
def test_one_format_is_enough(make, formats):
    assert make(export={name: {} for name in formats}).preview == PICTURE


def test_accident_fails_no_build_and_is_reported(make, tmp_path, monkeypatch):
    monkeypatch.setattr(
        ask, "pictures_of", lambda *_, **__: {ENDED: b'{"why": "drawing it crashed (SIGSEGV)"}'}
    )
    report = make()
    assert (report.status, report.preview) == ("built", "")
    (diagnostic,) = (diagnostic for diagnostic in report.diagnostics if diagnostic.code == "I-PREVIEW")
    assert "SIGSEGV" in diagnostic.message
    assert not (tmp_path / "out" / PICTURE).exists()


@pytest.mark.parametrize("end", [KeyboardInterrupt(), LinkwrightError("the checks failed")], ids=repr)
def test_picture_is_drawn_beside_checks_and_ends_with_a_build(make, monkeypatch, end):
    begun, halted = threading.Event(), threading.Event()

    def slowly(look, kind, halt):
        begun.set()
        halt.wait(60)
        halted.set()
        return {ENDED: b'{"why": "drawing it was interrupted"}'}

    def checks(*_):
        assert begun.wait(10)
        assert not halted.is_set()
        raise end

    monkeypatch.setattr(ask, "pictures_of", slowly)
    monkeypatch.setattr("linkwright.pipeline.stages.stage.validate", checks)
    with pytest.raises(type(end)):
        make(until="validate")
    assert halted.is_set()


def test_picture_of_the_user_in_the_way_is_not_replaced(make, tmp_path):
    own = tmp_path / "out" / PICTURE
    own.parent.mkdir()
    manifest.write(tmp_path / "out", {})
    own.write_bytes(b"by the user")
    with pytest.raises(LinkwrightError, match=PICTURE):
        make()
    assert own.read_bytes() == b"by the user"
    make(page={"preview": "none"})
    assert own.read_bytes() == b"by the user"
