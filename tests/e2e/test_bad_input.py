"""Bad input, as users give it: one message, the right exit status, nothing half-written.

The likeliest mistakes, each with its whole message, are in `test_mistakes.py`.
"""

import os
import zipfile

import numpy as np
import pytest

from tests.fake_onshape import solids
from tests.fake_onshape.bundle import bundle_bytes
from tests.fake_onshape.document import Document
from tests.fake_onshape.sample import sample_document
from tests.fake_onshape.server import OnshapeServer
from tests.support.command import called, environment, linkwright, report_of, tree

WEB = "https://cad.onshape.com/documents/" + "a" * 24 + "/w/" + "b" * 24 + "/e/" + "c" * 24


def refused(here, status, arguments, *words, environ=None):
    """Runs and expects this exit status and these words, once, without a traceback or an output."""
    done = called(here, *arguments, environ=environ, status=status)
    assert "Traceback" not in done.stdout + done.stderr
    assert done.stderr.count("error:") == 1
    assert [word for word in words if word not in done.stderr] == []
    assert not [name for name in tree(here) if ".tmp" in name or ".old" in name]
    return done.stderr


ONSHAPE = ["source=onshape", f"source.url={WEB}"]
KNOWN_BEFOREHAND = [
    (["mesh.colider=hull"], "mesh.colider", "collider"),
    (["ground.size=big"], "ground.size", "big"),
    (["ground.size=big", "validate.levle=quick"], "ground.size", "validate.levle", "level"),
    (["plugins=[mine]"], "plugins", "there is no module mine"),
    (["source=onshape"], "source.url"),
    (["source=onshape", "source.url=https://example.com/robot"], "source.url", "/documents/"),
    (["source=bundle", "source.path=nowhere.zip"], "nowhere.zip"),
    (["name=../x"], "name"),
    (["name=scene"], "name", "scene.xml"),
    ([*ONSHAPE, "ground=foo", "foo=1"], "ONSHAPE_ACCESS_KEY", "ground=foo", "foo"),
    (["source=onshape", "source.url=arm", "mesh.colider=hull"], "source.url", "mesh.colider"),
    (["hydra.verbose=true"], "hydra.verbose"),
    (["-m", "root=auto,free", "joints.*.effort=glob(*)"], "joints.*.effort=glob(*)", "group"),
    (["output=/proc/robot"], "/proc/robot", "cannot be written"),
    (["-m", "root=auto,free", "output=/proc/robot"], "/proc/robot", "cannot be written"),
]


@pytest.mark.parametrize("row", KNOWN_BEFOREHAND, ids=lambda row: " ".join(row[0]))
def test_what_is_known_beforehand_is_refused_and_leaves_nothing(tmp_path, row):
    arguments, *words = row
    refused(tmp_path, 1 if "/proc" in arguments[-1] else 2, arguments, *words)
    assert not tree(tmp_path)


def small(**more):
    """A document of one base, and with `arm` a second part that nothing holds."""
    document = Document("Small")
    studio = document.studio("Parts")
    root = document.assembly("Root")
    for name in ("Base", "Arm") if more.get("arm") else ("Base",):
        root.add(studio.part(name, solids.box(0.1, 0.1, 0.1), density=1000), **more.get("how", {}))
    return document


def over_http(here, document, *words, **more):
    with OnshapeServer(document) as server:
        url = server.document_url()
        environ = environment(here, **{**server.environ, **more})
        return url, refused(here, 1, ["source=onshape", f"source.url='{url}'"], *words, environ=environ)


def test_an_empty_assembly_is_one_message(tmp_path):
    over_http(tmp_path, small(how={"suppressed": True}), "the assembly is empty")


def test_failed_build_reports_its_calls_files_and_report(tmp_path):
    url, message = over_http(tmp_path, small(arm=True), "no mates", "FASTENED")
    lines = [line.strip() for line in message.splitlines()]
    assert "3 API calls made, 0 saved by the cache; 3 counted for this key this year" in lines
    assert f"source: {url}" in lines
    place = next(line.removeprefix("report: ") for line in lines if line.startswith("report: "))
    assert (tmp_path / place).is_file()
    report = report_of((tmp_path / place).parent)
    assert report["source"]["url"] == url
    assert report["calls"]["made"] == 3


def test_a_wrong_key_is_named_without_showing_it(tmp_path):
    _, message = over_http(tmp_path, small(), "401", ONSHAPE_SECRET_KEY="not-the-secret")
    assert "not-the-secret" not in message
    left = b"".join(path.read_bytes() for path in tmp_path.rglob("*") if path.is_file())
    assert b"not-the-secret" not in left


@pytest.mark.parametrize("cut", [lambda data: data[: len(data) // 2], lambda data: b"this is no zip"])
def test_a_corrupt_bundle_is_one_message(tmp_path, cut):
    (tmp_path / "bad.zip").write_bytes(cut(bundle_bytes(small())))
    refused(tmp_path, 1, ["source=bundle", "source.path=bad.zip"], "bad.zip")


def test_a_bundle_whose_reply_was_changed_is_refused(tmp_path):
    (tmp_path / "good.zip").write_bytes(bundle_bytes(small()))
    with zipfile.ZipFile(tmp_path / "good.zip") as old, zipfile.ZipFile(tmp_path / "bad.zip", "w") as new:
        for name in old.namelist():
            body = old.read(name)
            new.writestr(name, body if name == "manifest.json" else body.replace(b"0.05", b"0.06"))
    refused(tmp_path, 1, ["source=bundle", "source.path=bad.zip"], "bad.zip", "digest")


def test_a_zip_that_climbs_out_of_its_folder_writes_nothing(tmp_path):
    inside = tmp_path / "inside"
    inside.mkdir()
    with zipfile.ZipFile(inside / "evil.zip", "w") as archive:
        archive.writestr("manifest.json", "{}")
        archive.writestr("../evil.txt", "out")
    refused(inside, 1, ["source=bundle", "source.path=evil.zip"], "evil.zip", "../evil.txt")
    assert not (tmp_path / "evil.txt").exists()


@pytest.mark.slow
def test_a_failed_build_leaves_the_last_good_one_and_its_own_report(tmp_path):
    bundle = tmp_path / "arm.zip"
    bundle.write_bytes(bundle_bytes(sample_document()))
    linkwright(tmp_path, "source=bundle", "source.path=arm.zip", "name=arm", status=0)
    before = (tmp_path / "outputs" / "arm" / "arm.urdf").read_bytes()
    bundle.write_bytes(bundle_bytes(small(arm=True)))
    refused(tmp_path, 1, ["source=bundle", "source.path=arm.zip", "name=arm"], "no mates")
    assert (tmp_path / "outputs" / "arm" / "arm.urdf").read_bytes() == before
    assert report_of(tmp_path / "outputs" / "arm.failed")["exit_status"] == 1
    bundle.write_bytes(bundle_bytes(sample_document()))
    linkwright(tmp_path, "source=bundle", "source.path=arm.zip", "name=arm", status=0)
    assert not (tmp_path / "outputs" / "arm.failed").exists()


@pytest.mark.slow
def test_a_sweep_over_a_file_is_refused_before_its_jobs(tmp_path):
    (tmp_path / "taken").write_text("mine")
    assert "job 0" not in refused(tmp_path, 2, ["-m", "root=auto,free", "output=taken"], "taken is a file")
    assert tree(tmp_path) == {"taken"}


def test_an_output_that_is_a_file_is_refused(tmp_path):
    (tmp_path / "taken").write_text("mine")
    refused(tmp_path, 2, ["output=taken/robot"], "taken is a file")
    assert (tmp_path / "taken").read_text() == "mine"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["output='~'"], "your home folder"),
        (["output=" + "x" * 300], "too long"),
        (["-m", "root=auto,free", "output=."], "the working folder"),
        (["-m", "root=auto,free", "output=cache"], "the cache folder"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_an_output_in_the_place_of_what_the_user_works_in_is_refused(tmp_path, arguments, words):
    (tmp_path / "home").mkdir()
    (tmp_path / "work").mkdir()
    environ = environment(tmp_path / "work", seeded=False, HOME=str(tmp_path / "home"))
    refused(tmp_path / "work", 2, arguments, words, environ=environ)
    assert tree(tmp_path) == {"home", "work"}


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_an_unwritable_folder_is_one_message(tmp_path):
    closed = tmp_path / "closed"
    closed.mkdir(mode=0o500)
    refused(tmp_path, 1, ["output=closed/robot"], "closed")


def test_a_failed_check_exits_with_3_and_the_build_is_there(tmp_path):
    """Strict: the joint without limits is a warning, which is a failure then."""
    document = small()
    arm = document.root.add(document.studios[0].part("Arm", solids.box(0.1, 0.1, 0.1), density=1000))
    base = document.root.add(document.studios[0].parts[0])
    document.root.revolute("Elbow", (arm, np.eye(4)), (base, np.eye(4)))
    document.root.instances[0].suppressed = True
    document.changed()
    (tmp_path / "arm.zip").write_bytes(bundle_bytes(document))
    linkwright(tmp_path, "source=bundle", "source.path=arm.zip", "validate=strict", status=3)
    assert (tmp_path / "outputs" / "arm" / "arm.urdf").exists()
