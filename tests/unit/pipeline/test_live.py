"""The view of the robot in a build: made once, kept, and never the reason of a failure."""

import json

import pytest

from linkwright.pipeline.config.plan import Plan
from linkwright.pipeline.run.build import build
from linkwright.pipeline.show import live as made
from linkwright.stages.show.live.pack import read_pack

INERTIA = '<inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/>'
FOOT = '<geometry><box size="0.2 0.2 0.1"/></geometry>'
ARM = f"""<robot name="arm">
  <link name="base"><visual>{FOOT}</visual><collision>{FOOT}</collision>
    <inertial><mass value="2"/>{INERTIA}</inertial></link>
  <link name="upper"><visual><geometry><box size="0.05 0.05 0.3"/></geometry></visual>
    <inertial><origin xyz="0 0 0.15"/><mass value="1"/>{INERTIA}</inertial></link>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><origin xyz="0 0 0.1"/>
    <axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="5" velocity="2"/></joint>
</robot>"""
SCENE = "linkwright.stages.show.live.scene.pack_of"

pytestmark = [pytest.mark.slow, pytest.mark.e2e, pytest.mark.usefixtures("whole_page")]


@pytest.fixture
def plan(tmp_path):
    (tmp_path / "arm.urdf").write_text(ARM)
    keys = {"name": "arm", "source": {"kind": "urdf", "path": str(tmp_path / "arm.urdf")}}
    keys |= {"root": {"base": "fixed"}, "validate": {"level": "quick"}}
    keys |= {"output": str(tmp_path / "arm"), "cache": {"dir": str(tmp_path / "cache")}}
    return lambda **more: Plan.parse({**keys, **more})


@pytest.fixture
def shown(monkeypatch):
    """What the pages of the builds show of the robot."""
    views = []
    monkeypatch.setattr("linkwright.pipeline.run.state.with_view", lambda _, live: views.append(live) or b"")
    return views


def test_the_view_is_made_once_and_then_comes_from_the_cache(plan, shown, monkeypatch):
    first = build(plan())
    with monkeypatch.context() as patched:
        patched.setattr(SCENE, lambda *_: pytest.fail("it is in the cache"))
        second = build(plan())
    assert [stage.name for stage in first.stages] == [stage.name for stage in second.stages]
    assert shown[0].pack == shown[1].pack
    header, _ = read_pack(shown[0].pack)
    assert [joint["name"] for joint in header["joints"]] == ["shoulder"]
    assert (shown[0].engine, shown[0].engine_path, shown[0].files) == ("whole", "", {})
    # Another number of triangles makes the view again, and no stage.
    assert all(stage.cached for stage in build(plan(page={"faces": 5})).stages)
    assert read_pack(shown[2].pack)[0]["thinned"] is None, "boxes have no triangles"


@pytest.mark.parametrize("error", [ValueError("no such mesh"), RuntimeError("a bug"), MemoryError()])
def test_view_that_cannot_be_made_fails_no_build(error, plan, monkeypatch, tmp_path):
    def fail(*_):
        raise error

    monkeypatch.setattr(SCENE, fail)
    report = build(plan())
    assert report.exit_status == 0
    (diagnostic,) = [diagnostic for diagnostic in report.diagnostics if diagnostic.code == made.CODE]
    assert str(error) in diagnostic.message
    assert diagnostic.message in (tmp_path / "arm" / "build.log").read_text()


def test_view_is_tried_again_after_an_accident_alone(plan, monkeypatch):
    tried = []

    def fail(*_):
        tried.append(1)
        raise errors.pop()

    errors = [ValueError("no"), RuntimeError("an accident")]
    monkeypatch.setattr(SCENE, fail)
    messages = [build(plan()).diagnostics[-1].message for _ in range(3)]
    assert len(tried) == 2
    assert [message.rpartition(": ")[2] for message in messages] == ["an accident", "no", "no"]


def test_an_engine_beside_the_page_is_a_file_of_the_build(plan, monkeypatch, tmp_path):
    monkeypatch.setattr(made, "engine_file", lambda: b"engine")
    build(plan(page={"live": "shared"}))
    folder = tmp_path / "arm"
    assert (folder / made.ENGINE_FILE).read_bytes() == b"engine"
    assert made.ENGINE_FILE in json.loads((folder / ".linkwright.json").read_text())["files"]
    build(plan(page={"live": "kinematics"}))
    assert not (folder / made.ENGINE_FILE).exists(), "it is ours, so it is removed where it is not needed"


def test_the_jobs_of_a_sweep_share_the_engine_of_its_folder(plan, shown, tmp_path):
    build(plan(output=str(tmp_path / "sweep" / "a" / "b")), sweep=tmp_path / "sweep")
    build(plan(output=str(tmp_path / "sweep" / "c"), page={"live": "kinematics"}), sweep=tmp_path / "sweep")
    assert [(page.engine, page.engine_path, dict(page.files)) for page in shown] == [
        ("shared", "../../linkwright-engine.js", {}),
        ("none", "", {}),
    ]


def test_a_build_without_export_and_a_plain_page_have_no_view(plan, shown, monkeypatch):
    build(plan(until="graph"))
    monkeypatch.setenv("LINKWRIGHT_PAGE", "plain")
    build(plan())
    assert shown == [made.NOTHING, made.NOTHING]
    monkeypatch.setenv("LINKWRIGHT_PAGE", "whole")
    for _ in range(2):
        build(plan(export={"urdf": {}}))
    assert [page.engine for page in shown[2:]] == ["none", "none"], "such a robot cannot be simulated"
    assert read_pack(shown[3].pack)[0]["no_engine"]
