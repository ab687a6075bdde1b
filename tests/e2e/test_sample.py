"""The sample as a user builds it: bytes, calls, the cache, and kill -9 at any moment."""

import json
import random
import shutil
import subprocess
import time
from pathlib import Path

import pytest

from linkwright.stages.export.writers import WRITERS
from tests.fake_onshape.sample import sample_document
from tests.fake_onshape.server import OnshapeServer
from tests.support.command import COMMAND, RUN_FACTS, environment, linkwright, robot_files

PLAIN = ("robot=sample", "mesh=visual", f"export=[{','.join(WRITERS)}]")
"""The sample in every format, without colliders, which take most of the time of a build."""


def report(folder: Path) -> dict:
    return json.loads((folder / "report.json").read_text())


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder where plain `linkwright` has been run once."""
    here = tmp_path_factory.mktemp("sample")
    done = linkwright(here)
    assert done.returncode == 0, done.stderr
    return here


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """The files of the plain sample."""
    here = tmp_path_factory.mktemp("plain")
    done = linkwright(here, *PLAIN)
    assert done.returncode == 0, done.stderr
    return robot_files(here / "outputs" / "sample")


def test_without_arguments_the_sample_is_built_and_valid(built: Path) -> None:
    found = report(built / "outputs" / "sample")
    assert found["status"] == "built"
    assert [check for check in found["checks"] if not check["passed"] and check["level"] == "error"] == []
    assert {stage["name"] for stage in found["stages"]} == {"fetch", "graph", "mesh", "export", "validate"}
    names = {path.name for path in (built / "outputs" / "sample").iterdir()}
    assert names >= {"sample.urdf", "sample.xml", "scene.xml", "assets", "robot.json", "report.json"}


def test_the_files_alone_show_that_they_are_right(built: Path) -> None:
    """Without the documents of the build: only the robot's own files count."""
    folder = built / "alone"
    shutil.copytree(built / "outputs" / "sample", folder)
    for name in (*RUN_FACTS, "preview.png"):
        (folder / name).unlink(missing_ok=True)
    done = linkwright(built, "check", "alone")
    assert done.returncode == 0, done.stdout
    assert "FAILED" not in done.stdout
    mesh = next(iter((folder / "assets").iterdir()))
    mesh.unlink()
    done = linkwright(built, "check", "alone")
    assert done.returncode == 3
    assert f'file "assets/{mesh.name}"' in done.stdout


def test_the_sample_has_no_diagnostic_but_of_contacts_its_loop_and_what_a_urdf_lacks(built: Path) -> None:
    codes = [diagnostic["code"] for diagnostic in report(built / "outputs" / "sample")["diagnostics"]]
    of_formats = ["I-URDF-ARMATURE", "I-URDF-LOOP", "I-SRDF-PARTLY"]
    assert codes == ["I-ALWAYS-CONTACT", *of_formats, "I-ACTUATOR"]


def test_the_sample_passes_all_its_checks(built: Path) -> None:
    """Also those that only warn: the fingers stop where their pads meet."""
    checks = report(built / "outputs" / "sample")["checks"]
    assert [check["name"] for check in checks if not check["passed"]] == []


def test_a_second_build_runs_no_stage_and_gives_the_same_bytes(built: Path) -> None:
    before = robot_files(built / "outputs" / "sample")
    done = linkwright(built)
    assert done.returncode == 0
    assert all(stage["cached"] for stage in report(built / "outputs" / "sample")["stages"])
    assert robot_files(built / "outputs" / "sample") == before


@pytest.mark.slow
def test_hash_seed_process_and_bypass_change_no_byte(built: Path, tmp_path: Path) -> None:
    environ = environment(tmp_path, PYTHONHASHSEED="4711")
    done = linkwright(tmp_path, "cache.mode=bypass", environ=environ, timeout=600)
    assert done.returncode == 0, done.stderr
    assert robot_files(tmp_path / "outputs" / "sample") == robot_files(built / "outputs" / "sample")


@pytest.mark.slow
def test_hash_seed_and_bypass_change_no_byte_of_the_rest(plain: dict[str, bytes], tmp_path: Path) -> None:
    arguments = [*PLAIN, "cache.mode=bypass"]
    done = linkwright(tmp_path, *arguments, environ=environment(tmp_path, PYTHONHASHSEED="0"))
    assert done.returncode == 0, done.stderr
    assert robot_files(tmp_path / "outputs" / "sample") == plain


def test_over_http_the_same_bytes_come_with_one_plus_two_p_calls(
    plain: dict[str, bytes], tmp_path: Path
) -> None:
    document = sample_document()
    with OnshapeServer(document) as server:
        done = linkwright(
            tmp_path,
            *PLAIN,
            "source=onshape",
            f"source.url='{server.document_url()}'",
            environ=environment(tmp_path, **server.environ),
        )
        calls = server.count
    assert done.returncode == 0, done.stderr
    studios = {
        place.instance.source.studio.element
        for place in document.truth.places.values()
        if place.instance.is_part
    }
    assert calls == 1 + 2 * len(studios)
    assert report(tmp_path / "outputs" / "sample")["calls"]["made"] == calls
    assert robot_files(tmp_path / "outputs" / "sample") == plain


@pytest.mark.parametrize("kills", [2, pytest.param(10, marks=pytest.mark.slow)])
def test_killed_at_any_moment_the_next_build_is_whole(
    plain: dict[str, bytes], tmp_path: Path, kills: int
) -> None:
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
        done = linkwright(tmp_path, *PLAIN)
        assert done.returncode == 0, done.stderr
        assert robot_files(tmp_path / "outputs" / "sample") == plain
        left = {path.name for path in (tmp_path / "outputs").iterdir() if path.name != ".linkwright"}
        assert left == {"sample"}
    assert killed >= kills // 4


@pytest.mark.slow
def test_what_the_user_put_into_the_output_is_kept_or_stops_the_next_build(tmp_path):
    assert linkwright(tmp_path).returncode == 0
    folder = tmp_path / "outputs" / "sample"
    (folder / "NOTES.md").write_text("mine")
    again = linkwright(tmp_path)
    assert again.returncode == 0
    assert "kept, since not linkwright's: NOTES.md" in again.stderr
    with (folder / "scene.xml").open("a") as file:
        file.write("<!-- mine -->")
    mine = (folder / "scene.xml").read_bytes()
    stopped = linkwright(tmp_path)
    assert stopped.returncode == 2
    assert "scene.xml was changed since it was built" in stopped.stderr
    assert (folder / "scene.xml").read_bytes() == mine
    forced = linkwright(tmp_path, "overwrite=true")
    assert forced.returncode == 0
    assert "was in the way, and was moved to outputs/sample.replaced/scene.xml" in forced.stderr
    assert (tmp_path / "outputs" / "sample.replaced" / "scene.xml").read_bytes() == mine
    assert (folder / "scene.xml").read_bytes() != mine
    assert (folder / "NOTES.md").read_text() == "mine"
