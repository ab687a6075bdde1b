"""The build with the real stages: bytes, calls, the cache, and what a cached build imports."""

import json
import os
import subprocess
import sys

import pytest

from linkwright.pipeline.config.plan import Plan
from linkwright.pipeline.errors import LinkwrightError
from linkwright.pipeline.run.build import build
from tests.fake_onshape.bundle import bundle_bytes
from tests.fake_onshape.sample import sample_document
from tests.fake_onshape.server import OnshapeServer
from tests.support.places import PROJECT

RUN_FACTS = {".linkwright.json", "report.json", "report.html", "build.log", "config.yaml"}


@pytest.fixture(scope="module")
def document():
    return sample_document()


@pytest.fixture(scope="module")
def archive(document, tmp_path_factory):
    path = tmp_path_factory.mktemp("bundle") / "arm.zip"
    path.write_bytes(bundle_bytes(document))
    return path


def plan(place, source, **more):
    """Without colliders, which take most of a build's time."""
    return Plan.parse(
        {
            "name": "arm",
            "source": source,
            "mesh": {"collider": "visual"},
            "output": str(place / "arm"),
            "cache": {"dir": str(place / "cache")},
            **more,
        }
    )


def robot_files(folder):
    files = {str(p.relative_to(folder)): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}
    return {name: data for name, data in files.items() if name not in RUN_FACTS}


def test_http_and_bundle_give_the_same_bytes_and_a_second_build_costs_one_call(document, archive, tmp_path):
    from_zip = build(plan(tmp_path / "zip", {"kind": "bundle", "path": str(archive)}), environ={})
    assert from_zip.exit_status == 0
    with OnshapeServer(document) as server:
        asked = plan(tmp_path / "http", {"kind": "onshape", "url": server.document_url()})
        first = build(asked, environ=server.environ)
        cold = server.count
        assert (first.calls["made"], first.calls["saved"]) == (cold, 0)
        assert first.calls["counted_this_year"] == cold
        served = {"api": "v16", "definition_api": "v17", "release": "1.218.0"}
        assert first.calls["served"] == served
        second = build(asked, environ=server.environ)
        assert server.count - cold == 1
        assert (second.calls["made"], second.calls["saved"]) == (1, cold)
        assert second.calls["counted_this_year"] == cold + 1
        assert second.calls["remaining"]["currentmicroversion"] < 400
        assert second.calls["served"] == {"api": "v16", "release": "1.218.0"}
        assert second.calls["waited"] == 0
        pinned = plan(tmp_path / "http", {"kind": "onshape", "url": server.document_url("m")})
        server.reset()
        third = build(pinned, environ=server.environ)
        assert server.count == 0
    assert cold % 2 == 1
    assert [stage.cached for stage in second.stages] == [False, True, True, True, True]
    assert third.outputs == second.outputs == first.outputs == from_zip.outputs
    assert robot_files(tmp_path / "http" / "arm") == robot_files(tmp_path / "zip" / "arm")


def test_bypass_and_the_cache_give_the_same_bytes(archive, tmp_path):
    source = {"kind": "bundle", "path": str(archive)}
    cached = build(plan(tmp_path, source), environ={})
    bypassed = build(plan(tmp_path / "two", source, cache={"mode": "bypass"}), environ={})
    assert bypassed.outputs == cached.outputs
    assert not any(stage.cached for stage in bypassed.stages)


NOT_YET = ("shapes", "colliders", "self_contact", "excludes", "touching", "scene", "srdf")
"""Tables of robot.json that a build makes after its graph."""


def test_until_graph_leaves_the_same_robot_json_as_the_whole_build(archive, tmp_path):
    source = {"kind": "bundle", "path": str(archive)}
    build(plan(tmp_path, source), environ={})
    build(plan(tmp_path, source, until="graph"), environ={})
    left = robot_files(tmp_path / "arm.graph")
    assert set(left) == {"robot.json", "graph.svg"}
    whole = json.loads((tmp_path / "arm" / "robot.json").read_bytes())
    # There are no shapes yet, no scene, and no files whose order or names it could tell.
    assert all(whole.pop(key) is not None for key in NOT_YET)
    assert set(whole.pop("order")) == {"mjcf", "urdf"}
    assert {*whole.pop("files")} == robot_files(tmp_path / "arm").keys() - {"robot.json", "graph.svg"}
    assert left["robot.json"].decode() == json.dumps(whole, indent=2, ensure_ascii=False) + "\n"


def test_a_corrupt_bundle_fails_with_exit_status_1_and_keeps_the_last_build(archive, tmp_path):
    good = build(plan(tmp_path, {"kind": "bundle", "path": str(archive)}), environ={})
    corrupt = tmp_path / "corrupt.zip"
    corrupt.write_bytes(archive.read_bytes()[:5000])
    with pytest.raises(LinkwrightError) as caught:
        build(plan(tmp_path, {"kind": "bundle", "path": str(corrupt)}), environ={})
    assert "corrupt.zip" in str(caught.value)
    assert (tmp_path / "arm.failed" / "report.json").exists()
    assert set(robot_files(tmp_path / "arm")) == set(good.outputs)


def test_a_fully_cached_build_imports_nothing_heavy(archive, tmp_path, whole_page):
    source = {"kind": "bundle", "path": str(archive)}
    build(plan(tmp_path, source), environ={})
    code = (
        "import sys\n"
        "from linkwright.pipeline.run.build import build\n"
        "from linkwright.pipeline.config.plan import Plan\n"
        f"data = {plan(tmp_path, source).tree()!r}\n"
        "report = build(Plan.parse(data), environ={})\n"
        "assert all(stage.cached for stage in report.stages)\n"
        "heavy = 'numpy scipy trimesh mujoco networkx lxml httpx hydra'.split()\n"
        "print([name for name in heavy if name in sys.modules])"
    )
    environ = {**os.environ, "PYTHONPATH": str(PROJECT)}
    run = subprocess.run(
        [sys.executable, "-c", code], env=environ, capture_output=True, text=True, check=True
    )
    assert run.stdout.strip() == "[]"
