"""The sample as a user builds it: bytes, calls, the cache, and kill -9 at any moment."""

import random
import shutil
import subprocess
import time

import pytest

from linkwright.stages.export.writers import WRITERS
from tests.fake_onshape.sample import sample_document
from tests.fake_onshape.server import OnshapeServer
from tests.support.command import COMMAND, RUN_FACTS, called, environment, linkwright, report_of, robot_files

PLAIN = ("robot=sample", "mesh=visual", f"export=[{','.join(WRITERS)}]")
"""The sample in every format, without colliders, which take most of the time of a build."""


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """A folder where plain `linkwright` has been run once."""
    here = tmp_path_factory.mktemp("sample")
    linkwright(here, status=0)
    return here


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    """The files of the plain sample."""
    here = tmp_path_factory.mktemp("plain")
    linkwright(here, *PLAIN, status=0)
    return robot_files(here / "outputs" / "sample")


def test_sample_is_built_without_arguments_and_passes_its_checks(built):
    """Also those that only warn: the fingers stop where their pads meet."""
    folder = built / "outputs" / "sample"
    report = report_of(folder)
    assert report["status"] == "built"
    assert [check["name"] for check in report["checks"] if not check["passed"]] == []
    assert {stage["name"] for stage in report["stages"]} == {"fetch", "graph", "mesh", "export", "validate"}
    names = {path.name for path in folder.iterdir()}
    assert names >= {"sample.urdf", "sample.xml", "scene.xml", "assets", "robot.json", "report.json"}
    # Of contacts, its loop, and what other formats lack; of nothing else.
    codes = ["I-ALWAYS-CONTACT", "I-URDF-ARMATURE", "I-URDF-LOOP", "I-SRDF-PARTLY", "I-ACTUATOR"]
    assert [diagnostic["code"] for diagnostic in report["diagnostics"]] == codes


def test_the_files_alone_show_that_they_are_right(built):
    """Without the documents of the build: only the robot's own files count."""
    folder = built / "alone"
    shutil.copytree(built / "outputs" / "sample", folder, ignore=shutil.ignore_patterns(*RUN_FACTS))
    assert "FAILED" not in called(built, "check", "alone", status=0).stdout
    mesh = next(iter((folder / "assets").iterdir()))
    mesh.unlink()
    assert f'file "assets/{mesh.name}"' in called(built, "check", "alone", status=3).stdout


def test_a_second_build_runs_no_stage_and_gives_the_same_bytes(built):
    before = robot_files(built / "outputs" / "sample")
    linkwright(built, status=0)
    assert all(stage["cached"] for stage in report_of(built / "outputs" / "sample")["stages"])
    assert robot_files(built / "outputs" / "sample") == before


@pytest.mark.slow
def test_hash_seed_process_and_bypass_change_no_byte(built, tmp_path):
    environ = environment(tmp_path, PYTHONHASHSEED="4711")
    linkwright(tmp_path, "cache.mode=bypass", environ=environ, status=0)
    assert robot_files(tmp_path / "outputs" / "sample") == robot_files(built / "outputs" / "sample")


@pytest.mark.slow
def test_hash_seed_and_bypass_change_no_byte_of_the_rest(plain, tmp_path):
    arguments = [*PLAIN, "cache.mode=bypass"]
    linkwright(tmp_path, *arguments, environ=environment(tmp_path, PYTHONHASHSEED="0"), status=0)
    assert robot_files(tmp_path / "outputs" / "sample") == plain


@pytest.mark.slow
def test_over_http_the_same_bytes_come_with_one_plus_two_p_calls(plain, tmp_path):
    document = sample_document()
    with OnshapeServer(document) as server:
        source = ["source=onshape", f"source.url='{server.document_url()}'"]
        linkwright(tmp_path, *PLAIN, *source, environ=environment(tmp_path, **server.environ), status=0)
        calls = server.count
    parts = [place.instance for place in document.truth.places.values() if place.instance.is_part]
    assert calls == 1 + 2 * len({part.source.studio.element for part in parts})
    assert report_of(tmp_path / "outputs" / "sample")["calls"]["made"] == calls
    assert robot_files(tmp_path / "outputs" / "sample") == plain


@pytest.mark.parametrize("kills", [2, pytest.param(10, marks=pytest.mark.slow)])
def test_killed_at_any_moment_the_next_build_is_whole(plain, tmp_path, kills):
    """Kills of the installed command, each followed by a normal build."""
    moments = random.Random(7)
    killed = 0
    for _ in range(kills):
        victim = subprocess.Popen(
            [str(COMMAND), *PLAIN, "cache.mode=refresh"],
            cwd=tmp_path,
            env=environment(tmp_path),
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        time.sleep(moments.uniform(0.05, 2.5))
        victim.kill()
        killed += victim.wait() != 0
        linkwright(tmp_path, *PLAIN, status=0)
        assert robot_files(tmp_path / "outputs" / "sample") == plain
        left = {path.name for path in (tmp_path / "outputs").iterdir() if path.name != ".linkwright"}
        assert left == {"sample"}
    assert killed >= kills // 4


@pytest.mark.slow
def test_users_files_in_the_output_are_kept_or_stop_the_build(tmp_path):
    linkwright(tmp_path, status=0)
    folder = tmp_path / "outputs" / "sample"
    (folder / "NOTES.md").write_text("mine")
    again = linkwright(tmp_path, status=0)
    assert "kept, since not linkwright's: NOTES.md" in again.stderr
    with (folder / "scene.xml").open("a") as file:
        file.write("<!-- mine -->")
    edited = (folder / "scene.xml").read_bytes()
    stopped = linkwright(tmp_path, status=2)
    assert "scene.xml was changed since it was built" in stopped.stderr
    assert (folder / "scene.xml").read_bytes() == edited
    forced = linkwright(tmp_path, "overwrite=true", status=0)
    assert "was in the way, and was moved to outputs/sample.replaced/scene.xml" in forced.stderr
    assert (tmp_path / "outputs" / "sample.replaced" / "scene.xml").read_bytes() == edited
    assert (folder / "scene.xml").read_bytes() != edited
    assert (folder / "NOTES.md").read_text() == "mine"
