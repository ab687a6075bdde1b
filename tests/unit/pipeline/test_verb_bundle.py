"""`linkwright bundle`: packs what a build read, and builds the same robot from it."""

import json
import os
import shutil
import socket
import zipfile
from pathlib import Path

import numpy as np
import pytest

from linkwright.pipeline.cli import run
from linkwright.pipeline.config.plan import Plan
from linkwright.pipeline.run.build import build
from tests.fake_onshape import solids
from tests.fake_onshape.document import Document
from tests.fake_onshape.sample import sample_document
from tests.fake_onshape.server import Fault, OnshapeServer
from tests.support.command import robot_files

pytestmark = pytest.mark.e2e

USER = "zaphod-beeblebrox"


def make(output, source, environ=None, until="export", **keys):
    """Builds into a folder below the working one, without colliders, which take long; the folder."""
    tree = {"name": "arm", "source": source, "output": output, "until": until, **keys}
    tree["mesh"] = {"collider": "visual"}
    build(Plan.parse(tree), environ=dict(os.environ) if environ is None else environ)
    return Path(output)


@pytest.fixture
def here(tmp_path, monkeypatch):
    """An empty working folder with a cache of its own."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("LINKWRIGHT_CACHE", str(tmp_path / "cache"))
    return tmp_path


@pytest.fixture(scope="module")
def live(tmp_path_factory):
    """A folder with a build over HTTP in `outputs/arm` and its cache in `cache`."""
    here = tmp_path_factory.mktemp("live")
    with OnshapeServer(sample_document(), keys=("acc-distinct", "sec-distinct")) as server:
        source = {"kind": "onshape", "url": server.document_url()}
        environ = {**server.environ, "LINKWRIGHT_CACHE": str(here / "cache"), "USER": USER}
        make(str(here / "outputs" / "arm"), source, environ)
    return here


@pytest.fixture
def built(live, here):
    """A copy of it in the working folder."""
    shutil.copytree(live, here, dirs_exist_ok=True)
    return here


def assert_same_build(again, first):
    assert robot_files(again) == robot_files(first)
    reports = [json.loads((place / "report.json").read_text()) for place in (again, first)]
    assert reports[0]["bundle"] == reports[1]["bundle"]
    assert reports[0]["calls"]["made"] == 0


def test_bundle_builds_the_same_bytes_elsewhere(built, tmp_path_factory, monkeypatch, capsys):
    assert run(["bundle", "arm", "arm.zip"]) == 0
    assert "arm.zip: 9 replies" in capsys.readouterr().out
    elsewhere = tmp_path_factory.mktemp("elsewhere")
    shutil.move("arm.zip", elsewhere)
    monkeypatch.chdir(elsewhere)
    monkeypatch.setenv("LINKWRIGHT_CACHE", str(elsewhere / "cache"))
    assert_same_build(make("again", {"kind": "bundle", "path": "arm.zip"}), built / "outputs" / "arm")


def desk():
    """A fixed top with a sliding leg of a linked document; its part studio has more than is used."""
    document = Document("Desk")
    wood = document.studio("Wood")
    desk = document.assembly("Desk")
    top = desk.add(wood.part("Top", solids.box(1, 0.5, 0.02), density=700), fixed=True)
    for number in range(40):
        wood.part(f"Offcut {number}", solids.cylinder(0.02, 0.1 + 0.001 * number), density=700)
    leg = desk.add(document.library("Legs").studio("Legs").part("Leg", solids.box(0.1, 0.1, 1), density=700))
    desk.slider("Lift", (leg, np.eye(4)), (top, np.eye(4)), value=0.1, limits=(0, 0.5))
    return document


@pytest.mark.parametrize(("how", "asked"), [
    ("a workspace", "partId="), ("a version", "/v/"), ("limits by features", "/features"),
    ("triangles by glTF", "/gltf"),
])  # fmt: skip
def test_whatever_a_build_had_to_ask_for_its_bundle_has(here, how, asked):
    with OnshapeServer(desk(), newest=16 if how == "limits by features" else 17) as server:
        if how == "triangles by glTF":
            refusal = Fault(406, b'{"message": "Not acceptable"}')
            server.fault = lambda method, target, number: refusal if "/tessellatedfaces" in target else None
        source = {"kind": "onshape", "url": server.document_url("v" if how == "a version" else "w")}
        make("outputs/arm", source, {**os.environ, **server.environ})
        assert any(asked in target for _, target, _ in server.calls)
    assert run(["bundle", "arm", "arm.zip"]) == 0
    again = make("again", {"kind": "bundle", "path": "arm.zip"}, cache={"dir": "another"})
    assert_same_build(again, Path("outputs/arm"))


def test_bundles_of_one_build_have_the_same_bytes(built, tmp_path_factory):
    assert run(["bundle", "arm", "one.zip"]) == 0
    assert run(["bundle", str(built / "outputs" / "arm"), "two.zip"]) == 0
    make("replayed", {"kind": "bundle", "path": "one.zip"}, cache={"dir": "other-cache"})
    assert run(["bundle", "replayed", "three.zip"]) == 0
    assert Path("one.zip").read_bytes() == Path("two.zip").read_bytes() == Path("three.zip").read_bytes()


def test_bundle_has_neither_key_user_host_nor_place(built):
    assert run(["bundle", "arm", "arm.zip"]) == 0
    shown = [b"acc-distinct", b"sec-distinct", USER.encode(), b"127.0.0.1", str(built).encode()]
    shown += [socket.gethostname().encode(), os.path.expanduser("~").encode()]  # noqa: PTH111
    with zipfile.ZipFile("arm.zip") as archive:
        contents = [archive.read(info) + info.filename.encode() + info.extra for info in archive.infolist()]
        assert all(info.date_time == (1980, 1, 1, 0, 0, 0) for info in archive.infolist())
        assert archive.comment == b""
    assert [secret for secret in shown if any(secret in content for content in contents)] == []


def test_a_build_that_failed_can_be_bundled_if_its_fetch_ended(here, capsys):
    with pytest.raises(Exception, match="nothing-like-it"):
        make("bad", {"kind": "sample"}, root={"select": "nothing-like-it"})
    assert run(["bundle", "bad.failed", "bad.zip"]) == 0
    make("good", {"kind": "bundle", "path": "bad.zip"}, until="graph")
    Path("broken.zip").write_text("no zip")
    with pytest.raises(Exception, match="not a zip file"):
        make("worse", {"kind": "bundle", "path": "broken.zip"})
    assert run(["bundle", "worse.failed", "worse.zip"]) == 1
    assert "ended before everything was fetched" in capsys.readouterr().err


@pytest.mark.parametrize("lost", ["all", "a reply", "harmed"])
def test_inputs_that_the_cache_lacks_are_reported(built, capsys, lost):
    assert run(["bundle", "arm", "arm.zip", "cache.dir=nowhere"]) == 1
    assert "nowhere: the cache lacks inputs" in capsys.readouterr().err
    shutil.copytree("cache", "elsewhere")
    if lost == "all":
        shutil.rmtree("cache")
    else:
        blobs = [path for path in Path("cache/cas").rglob("*") if path.is_file()]
        reply = next(path for path in blobs if b'"rootAssembly"' in path.read_bytes())
        reply.chmod(0o644)
        reply.write_bytes(b"{") if lost == "harmed" else reply.unlink()
    assert run(["bundle", "arm", "arm.zip"]) == 1
    shown = capsys.readouterr().err
    assert f"{built / 'cache'}: the cache lacks inputs of outputs/arm" in shown
    assert "cache.dir=FOLDER" in shown
    assert not Path("arm.zip").exists()
    assert run(["bundle", "arm", "arm.zip", "cache.dir=elsewhere"]) == 0


def test_an_older_bundle_is_replaced_and_nothing_else_is(built, capsys):
    Path("arm.txt").write_text("mine")
    assert run(["bundle", "arm", "arm.txt"]) == 2
    assert "exists and is not a bundle" in capsys.readouterr().err
    assert Path("arm.txt").read_text() == "mine"
    assert run(["bundle", "arm", "arm.zip"]) == 0
    first = Path("arm.zip").read_bytes()
    assert run(["bundle", "arm", "arm.zip"]) == 0
    assert Path("arm.zip").read_bytes() == first
    assert not [path for path in Path().iterdir() if path.name.startswith(".arm.zip")]


@pytest.mark.parametrize(("arguments", "shown"), [
    ([], "got 0 arguments"),
    (["arm"], "got 1 argument"),
    (["arm", "a.zip", "b.zip"], "got 3 arguments"),
    (["--fast", "arm", "a.zip"], "there is no option --fast"),
    (["arm", "a.zip", "cache.dir="], "expected a folder"),
    (["leg", "a.zip"], "there is no build in outputs/leg or leg"),
    (["arm", "no/such/a.zip"], "there is no folder no/such"),
])  # fmt: skip
def test_wrong_usage_is_reported_and_ends_with_2(built, capsys, arguments, shown):
    assert run(["bundle", *arguments]) == 2
    assert shown in capsys.readouterr().err
    assert not list(Path().glob("*.zip"))


def test_a_build_that_stands_beside_under_another_name_is_named(here, capsys):
    make("outputs/arm", {"kind": "sample"}, until="fetch")
    assert run(["bundle", "arm", "arm.zip"]) == 2
    assert "there is outputs/arm.fetch: name it" in capsys.readouterr().err
    assert run(["bundle", "arm.fetch", "arm.zip"]) == 0
