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


def test_a_build_leaves_its_picture_names_it_and_a_cached_one_draws_nothing(make, tmp_path, monkeypatch):
    first = make()
    data = (tmp_path / "out" / PICTURE).read_bytes()
    assert robot_in(pixels_of(data)).mean() > 0.02
    assert first.preview == PICTURE
    assert PICTURE not in first.outputs
    assert closing_lines(first)[-1] == f"arm: {tmp_path / 'out'} (report.html, preview.png)"
    page = (tmp_path / "out" / "report.html").read_text()
    assert f'href="{PICTURE}"' in page
    inside = page.partition("data:image/png;base64,")[2].partition('"')[0]
    assert robot_in(pixels_of(base64.b64decode(inside))).mean() > 0.02
    monkeypatch.setattr(ask, "drawn", lambda *_, **__: pytest.fail("it is in the cache"))
    make()
    assert (tmp_path / "out" / PICTURE).read_bytes() == data
    listed = json.loads((tmp_path / "out" / ".linkwright.json").read_text())["files"]
    assert PICTURE in listed


def test_without_one_none_of_before_stays(make, tmp_path):
    make()
    last = make(page={"preview": "none"})
    assert not (tmp_path / "out" / PICTURE).exists()
    assert last.preview == ""
    assert closing_lines(last)[-1] == f"arm: {tmp_path / 'out'}"


@pytest.mark.parametrize("formats", [["urdf"], ["mjcf"]])
def test_one_format_is_enough(make, tmp_path, formats):
    assert make(export={name: {} for name in formats}).preview == PICTURE


def test_an_accident_fails_no_build_and_is_told(make, tmp_path, monkeypatch):
    monkeypatch.setattr(ask, "drawn", lambda *_, **__: {ENDED: b'{"why": "drawing it crashed (SIGSEGV)"}'})
    report = make()
    assert (report.status, report.preview) == ("built", "")
    (found,) = (one for one in report.diagnostics if one.code == "I-PREVIEW")
    assert "SIGSEGV" in found.message
    assert not (tmp_path / "out" / PICTURE).exists()


@pytest.mark.parametrize(
    "end", [KeyboardInterrupt, LinkwrightError("the checks failed")], ids=["Ctrl-C", "error"]
)
def test_it_is_drawn_beside_the_checks_and_ends_with_the_build(make, monkeypatch, end):
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

    monkeypatch.setattr(ask, "drawn", slowly)
    monkeypatch.setattr("linkwright.pipeline.stages.stage.validate", checks)
    with pytest.raises(type(end) if isinstance(end, Exception) else end):
        make(until="validate")
    assert halted.is_set()


def test_a_failed_build_has_none_and_that_of_before_stays(make, tmp_path):
    make()
    kept = (tmp_path / "out" / PICTURE).read_bytes()
    with pytest.raises(LinkwrightError):
        make(joints={"nothing": {"damping": 1}})
    assert not (tmp_path / "out.failed" / PICTURE).exists()
    assert (tmp_path / "out" / PICTURE).read_bytes() == kept


def test_a_build_that_stops_before_the_export_has_none(make, tmp_path):
    assert make(until="graph").preview == ""
    assert not (tmp_path / "out.graph" / PICTURE).exists()


def test_a_picture_of_the_users_own_in_the_way_is_not_replaced(make, tmp_path):
    (tmp_path / "out").mkdir()
    manifest.write(tmp_path / "out", {})
    (tmp_path / "out" / PICTURE).write_bytes(b"mine")
    with pytest.raises(LinkwrightError, match=PICTURE):
        make()
    assert (tmp_path / "out" / PICTURE).read_bytes() == b"mine"
    make(page={"preview": "none"})
    assert (tmp_path / "out" / PICTURE).read_bytes() == b"mine"
