"""Bad input, as users give it: one message, the right exit status, nothing half-written."""

import json
import os
import zipfile
from pathlib import Path

import pytest

from tests.fake_onshape import solids
from tests.fake_onshape.bundle import bundle_bytes
from tests.fake_onshape.document import Document
from tests.fake_onshape.sample import sample_document
from tests.fake_onshape.server import OnshapeServer
from tests.support.command import called, environment, linkwright, tree

WEB = "https://cad.onshape.com/documents/" + "a" * 24 + "/w/" + "b" * 24 + "/e/" + "c" * 24


def refused(
    here: Path, status: int, arguments: list[str], *output_text: str, environ: dict | None = None
) -> str:
    """Runs and expects this exit status and these words, once, without a traceback or an output."""
    done = called(here, *arguments, environ=environ)
    assert done.returncode == status, done.stdout + done.stderr
    assert "Traceback" not in done.stdout + done.stderr
    assert done.stderr.count("error:") == 1
    for words in output_text:
        assert words in done.stderr
    assert not [name for name in tree(here) if ".tmp" in name or ".old" in name]
    return done.stderr


@pytest.mark.parametrize(
    ("arguments", "output_text"),
    [
        (["mesh.colider=hull"], ["mesh.colider", "collider"]),
        (["ground.size=big"], ["ground.size", "big"]),
        (["ground.size=big", "validate.levle=quick"], ["ground.size", "validate.levle", "level"]),
        (["plugins=[mine]"], ["plugins", "there is no module mine"]),
        (["mesh=coadc"], ["mesh", "coacd", "hull"]),
        (["robot=nobody"], ["robot", "nobody", "sample"]),
        (["source=onshape"], ["source.url"]),
        (["source=onshape", "source.url=https://example.com/robot"], ["source.url", "/documents/"]),
        (["source=onshape", f"source.url={WEB}"], ["ONSHAPE_ACCESS_KEY"]),
        (["source=bundle", "source.path=nowhere.zip"], ["nowhere.zip"]),
        (["name=../x"], ["name"]),
        (["name=scene"], ["name", "scene.xml"]),
        (
            ["source=onshape", f"source.url={WEB}", "ground=foo", "foo=1"],
            ["ONSHAPE_ACCESS_KEY", "ground=foo", "foo"],
        ),
        (["source=onshape", "source.url=arm", "mesh.colider=hull"], ["source.url", "mesh.colider"]),
        (["hydra.verbose=true"], ["hydra.verbose"]),
        (["-m", "root=auto,free", "joints.*.effort=glob(*)"], ["joints.*.effort=glob(*)", "group"]),
        (["source=onshape", f"source.url={WEB}?a=b"], [f"\"source.url='{WEB}?a=b'\""]),
    ],
)
def test_what_is_known_beforehand_is_refused_with_2_and_leaves_nothing(
    tmp_path: Path, arguments: list[str], output_text: list[str]
) -> None:
    refused(tmp_path, 2, arguments, *output_text)
    assert not tree(tmp_path)


def small(**more: object) -> Document:
    """A document of one base, and with `arm` a second part that nothing holds."""
    document = Document("Small")
    studio = document.studio("Parts")
    root = document.assembly("Root")
    for name in ("Base", "Arm") if more.get("arm") else ("Base",):
        root.add(studio.part(name, solids.box(0.1, 0.1, 0.1), density=1000), **more.get("how", {}))
    return document


def over_http(
    here: Path, document: Document, *output_text: str, element: str | None = None, **more: str
) -> str:
    with OnshapeServer(document) as server:
        url = server.document_url()
        if element:
            url = url.rpartition("/e/")[0] + f"/e/{element}"
        environ = environment(here, **{**server.environ, **more})
        return refused(here, 1, ["source=onshape", f"source.url='{url}'"], *output_text, environ=environ)


def test_a_part_studio_is_no_assembly(tmp_path: Path) -> None:
    document = small()
    over_http(tmp_path, document, "assembly", element=document.studios[0].element)


def test_an_empty_assembly_is_named(tmp_path: Path) -> None:
    over_http(tmp_path, small(how={"suppressed": True}), "the assembly is empty")


def test_an_assembly_without_mates_is_reported_what_to_do(tmp_path: Path) -> None:
    over_http(tmp_path, small(arm=True), "no mates", "FASTENED")


def test_a_failed_build_reports_what_it_cost_what_it_read_and_where_its_report_is(tmp_path: Path) -> None:
    with OnshapeServer(small(arm=True)) as server:
        url = server.document_url()
        environ = environment(tmp_path, **server.environ)
        output_text = refused(
            tmp_path, 1, ["source=onshape", f"source.url='{url}'"], "no mates", environ=environ
        )
    lines = [line.strip() for line in output_text.splitlines()]
    assert "3 API calls made, 0 saved by the cache; 3 of this key counted this year" in lines
    assert f"source: {url}" in lines
    place = next(line.removeprefix("report: ") for line in lines if line.startswith("report: "))
    assert (tmp_path / place).is_file()
    report = json.loads((tmp_path / place).with_name("report.json").read_bytes())
    assert report["source"]["url"] == url
    assert report["calls"]["made"] == 3


def test_a_wrong_key_is_named_without_showing_it(tmp_path: Path) -> None:
    output_text = over_http(tmp_path, small(), "401", ONSHAPE_SECRET_KEY="not-the-secret")
    assert "not-the-secret" not in output_text
    left = b"".join(path.read_bytes() for path in tmp_path.rglob("*") if path.is_file())
    assert b"not-the-secret" not in left


def broken_bundle(kind: str) -> bytes:
    whole = bundle_bytes(small())
    if kind == "truncated":
        return whole[: len(whole) // 2]
    return b"this is no zip" if kind == "text" else whole


@pytest.mark.parametrize("kind", ["truncated", "text"])
def test_a_corrupt_bundle_is_one_message(tmp_path: Path, kind: str) -> None:
    (tmp_path / "bad.zip").write_bytes(broken_bundle(kind))
    refused(tmp_path, 1, ["source=bundle", "source.path=bad.zip"], "bad.zip")


def test_a_bundle_whose_reply_was_changed_is_refused(tmp_path: Path) -> None:
    (tmp_path / "good.zip").write_bytes(bundle_bytes(small()))
    with zipfile.ZipFile(tmp_path / "good.zip") as old, zipfile.ZipFile(tmp_path / "bad.zip", "w") as new:
        for name in old.namelist():
            body = old.read(name)
            new.writestr(name, body if name == "manifest.json" else body.replace(b"0.05", b"0.06"))
    refused(tmp_path, 1, ["source=bundle", "source.path=bad.zip"], "bad.zip", "digest")


def test_a_zip_that_climbs_out_of_its_folder_writes_nothing(tmp_path: Path) -> None:
    inside = tmp_path / "inside"
    inside.mkdir()
    with zipfile.ZipFile(inside / "evil.zip", "w") as archive:
        archive.writestr("manifest.json", "{}")
        archive.writestr("../evil.txt", "out")
    refused(inside, 1, ["source=bundle", "source.path=evil.zip"], "evil.zip", "../evil.txt")
    assert not (tmp_path / "evil.txt").exists()


@pytest.mark.slow
def test_a_failed_build_leaves_the_last_good_one_and_its_own_report(tmp_path: Path) -> None:
    bundle = tmp_path / "arm.zip"
    bundle.write_bytes(bundle_bytes(sample_document()))
    assert linkwright(tmp_path, "source=bundle", "source.path=arm.zip", "name=arm").returncode == 0
    before = (tmp_path / "outputs" / "arm" / "arm.urdf").read_bytes()
    bundle.write_bytes(bundle_bytes(small(arm=True)))
    refused(tmp_path, 1, ["source=bundle", "source.path=arm.zip", "name=arm"], "no mates")
    assert (tmp_path / "outputs" / "arm" / "arm.urdf").read_bytes() == before
    failed = json.loads((tmp_path / "outputs" / "arm.failed" / "report.json").read_text())
    assert failed["exit_status"] == 1
    bundle.write_bytes(bundle_bytes(sample_document()))
    assert linkwright(tmp_path, "source=bundle", "source.path=arm.zip", "name=arm").returncode == 0
    assert not (tmp_path / "outputs" / "arm.failed").exists()


@pytest.mark.skipif(not Path("/proc/self").is_dir(), reason="needs a folder in which nothing can be made")
@pytest.mark.parametrize("sweep", [[], ["-m", "root=auto,free"]], ids=["single", "sweep"])
def test_a_folder_in_which_nothing_can_be_made_is_one_message(tmp_path: Path, sweep: list[str]) -> None:
    refused(tmp_path, 1, [*sweep, "output=/proc/robot"], "/proc/robot", "cannot be written")


@pytest.mark.slow
def test_a_sweep_over_a_file_is_refused_before_its_jobs(tmp_path: Path) -> None:
    (tmp_path / "taken").write_text("mine")
    assert "job 0" not in refused(tmp_path, 2, ["-m", "root=auto,free", "output=taken"], "taken is a file")
    assert tree(tmp_path) == {"taken"}


def test_an_output_that_is_a_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "taken").write_text("mine")
    refused(tmp_path, 2, ["output=taken/robot"], "taken is a file")
    assert (tmp_path / "taken").read_text() == "mine"


@pytest.mark.parametrize(
    ("sweep", "output", "shown"),
    [
        ([], "'~'", "your home folder"),
        ([], "x" * 300, "too long"),
        (["-m", "root=auto,free"], ".", "the working folder"),
        (["-m", "root=auto,free"], "cache", "the cache folder"),
    ],
)
def test_an_output_that_would_take_the_place_of_what_the_user_works_in_is_refused(
    tmp_path: Path, sweep: list[str], output: str, shown: str
) -> None:
    (tmp_path / "home").mkdir()
    (tmp_path / "work").mkdir()
    environ = environment(tmp_path / "work", seeded=False, HOME=str(tmp_path / "home"))
    done = called(tmp_path / "work", *sweep, f"output={output}", environ=environ)
    assert done.returncode == 2
    assert shown in done.stderr
    assert "Traceback" not in done.stderr
    assert tree(tmp_path) == {"home", "work"}


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_an_unwritable_folder_is_one_message(tmp_path: Path) -> None:
    closed = tmp_path / "closed"
    closed.mkdir(mode=0o500)
    refused(tmp_path, 1, ["output=closed/robot"], "closed")


def test_a_failed_check_exits_with_3_and_the_build_is_there(tmp_path: Path) -> None:
    """Strict: the joint without limits is a warning, which is a failure then."""
    document = small()
    arm = document.root.add(document.studios[0].part("Arm", solids.box(0.1, 0.1, 0.1), density=1000))
    base = document.root.add(document.studios[0].parts[0])
    import numpy as np

    document.root.revolute("Elbow", (arm, np.eye(4)), (base, np.eye(4)))
    document.root.instances[0].suppressed = True
    document.changed()
    (tmp_path / "arm.zip").write_bytes(bundle_bytes(document))
    done = linkwright(tmp_path, "source=bundle", "source.path=arm.zip", "validate=strict")
    assert done.returncode == 3, done.stderr
    assert (tmp_path / "outputs" / "arm" / "arm.urdf").exists()
