"""The build with the real stages: bytes, calls, the cache, and what a cached build imports."""

import json

import pytest

from linkwright.pipeline.config.plan import Plan
from linkwright.pipeline.run.build import build
from tests.fake_onshape.bundle import bundle_bytes
from tests.fake_onshape.sample import sample_document
from tests.fake_onshape.server import OnshapeServer
from tests.support.command import robot_files
from tests.support.processes import python

pytestmark = pytest.mark.e2e


@pytest.fixture(scope="module")
def document():
    return sample_document()


@pytest.fixture(scope="module")
def source(document, tmp_path_factory):
    """A bundle of the sample."""
    path = tmp_path_factory.mktemp("bundle") / "arm.zip"
    path.write_bytes(bundle_bytes(document))
    return {"kind": "bundle", "path": str(path)}


@pytest.fixture(scope="module")
def built(source, tmp_path_factory):
    """A folder with a build of the bundle in `arm` and its cache in `cache`, and the report."""
    folder = tmp_path_factory.mktemp("built")
    return folder, build(plan(folder, source), environ={})


def plan(place, source, **more):
    """Without colliders, which take most of a build's time."""
    keys = {"name": "arm", "source": source, "mesh": {"collider": "visual"}, "output": str(place / "arm")}
    return Plan.parse({**keys, "cache": {"dir": str(place / "cache")}, **more})


def test_http_and_bundle_give_the_same_bytes(document, built, tmp_path):
    place, from_zip = built
    assert from_zip.exit_status == 0
    with OnshapeServer(document) as server:
        asked = plan(tmp_path, {"kind": "onshape", "url": server.document_url()})
        first = build(asked, environ=server.environ)
        cold = server.count
        assert cold % 2 == 1
        calls = {"made": cold, "saved": 0, "counted_this_year": cold}
        calls["served"] = {"api": "v16", "definition_api": "v17", "release": "1.218.0"}
        assert first.calls.items() >= calls.items()
        second = build(asked, environ=server.environ)
        assert server.count - cold == 1
        calls = {"made": 1, "saved": cold, "counted_this_year": cold + 1, "waited": 0}
        calls["served"] = {"api": "v16", "release": "1.218.0"}
        assert second.calls.items() >= calls.items()
        assert second.calls["remaining"]["currentmicroversion"] < 400
        server.reset()
        pinned = plan(tmp_path, {"kind": "onshape", "url": server.document_url("m")})
        third = build(pinned, environ=server.environ)
        assert server.count == 0
    assert [stage.cached for stage in second.stages] == [False, True, True, True, True]
    assert third.outputs == second.outputs == first.outputs == from_zip.outputs
    assert robot_files(tmp_path / "arm") == robot_files(place / "arm")


NOT_YET = ("shapes", "colliders", "self_contact", "excludes", "touching", "scene", "srdf")
"""Tables of robot.json that a build makes after its graph."""


def test_until_graph_leaves_the_robot_json_of_the_whole_build(source, built):
    place, _ = built
    build(plan(place, source, until="graph"), environ={})
    left = robot_files(place / "arm.graph")
    assert set(left) == {"robot.json", "graph.svg"}
    whole = json.loads((place / "arm" / "robot.json").read_bytes())
    # There are no shapes yet, no scene, and no files whose order or names it could tell.
    assert all(whole.pop(key) is not None for key in NOT_YET)
    assert set(whole.pop("order")) == {"mjcf", "urdf"}
    assert {*whole.pop("files")} == robot_files(place / "arm").keys() - {"robot.json", "graph.svg"}
    assert left["robot.json"].decode() == json.dumps(whole, indent=2, ensure_ascii=False) + "\n"


def test_a_fully_cached_build_imports_nothing_heavy(source, built, whole_page):
    place, _ = built
    build(plan(place, source), environ={})
    code = (
        "import sys\n"
        "from linkwright.pipeline.run.build import build\n"
        "from linkwright.pipeline.config.plan import Plan\n"
        f"data = {plan(place, source).tree()!r}\n"
        "report = build(Plan.parse(data), environ={})\n"
        "assert all(stage.cached for stage in report.stages)\n"
        "heavy = 'numpy scipy trimesh mujoco networkx lxml httpx hydra'.split()\n"
        "print([name for name in heavy if name in sys.modules])"
    )
    done = python("-c", code)
    assert done.stdout.strip() == "[]", done.stderr
