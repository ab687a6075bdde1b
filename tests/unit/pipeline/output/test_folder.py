"""The output folder: swapped whole, mended after a kill, never someone else's."""

import os

import pytest

from linkwright.pipeline.errors import ConfigError, OutputError
from linkwright.pipeline.lock import FOLDER as LOCKS
from linkwright.pipeline.output.folder import FAILED, Output
from linkwright.pipeline.output.manifest import is_build
from tests.support.outputs import OURS, build, content


def beside(folder):
    return sorted(path.name for path in folder.parent.iterdir() if path.name != LOCKS)


@pytest.fixture
def output(tmp_path):
    """A folder with a build in it."""
    made = Output(tmp_path / "out" / "arm")
    made.publish(build(b"1"))
    return made


def test_publishing_makes_the_folder_with_exactly_the_files_and_replaces_all(tmp_path):
    output = Output(tmp_path / "deep" / "arm")
    assert not is_build(output.target)
    output.prepare()
    for files in (build(b"1", extra=b"x"), build(b"2")):
        assert output.publish(files) == tmp_path / "deep" / "arm"
        assert content(output.target) == files
        assert beside(output.target) == ["arm"]
        assert is_build(output.target)


def test_an_empty_folder_may_be_used_and_a_link_to_a_folder_stays_a_link(tmp_path):
    real, link = tmp_path / "real" / "arm", tmp_path / "arm"
    real.mkdir(parents=True)
    link.symlink_to(real)
    Output(link).publish(build(b"1"))
    assert link.is_symlink()
    assert content(real) == build(b"1")


def test_a_file_and_the_root_of_the_file_system_are_no_output_folder(tmp_path):
    (tmp_path / "arm").write_bytes(b"mine")
    with pytest.raises(ConfigError, match="is a file"):
        Output(tmp_path / "arm").prepare()
    assert (tmp_path / "arm").read_bytes() == b"mine"
    with pytest.raises(ConfigError, match="output"):
        Output("/")


def test_a_place_that_cannot_be_written_is_named_in_one_message(tmp_path):
    (tmp_path / "file").write_bytes(b"")
    output = Output(tmp_path / "made" / "arm")
    (tmp_path / "made").symlink_to(tmp_path / "file")
    with pytest.raises(OutputError, match="cannot be written") as caught:
        output.prepare()
    assert str(tmp_path / "made" / "arm") in str(caught.value)


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may write everywhere")
def test_a_parent_that_may_not_be_written_is_an_error_and_keeps_the_last_build(output):
    output.target.parent.chmod(0o555)
    try:
        with pytest.raises(OutputError, match="cannot be written"):
            output.publish(build(b"2"))
    finally:
        output.target.parent.chmod(0o755)
    assert content(output.target) == build(b"1")


@pytest.mark.parametrize(("path", "words"), [
    ("../x", "not a path inside"), ("/x", "not a path inside"), ("a/../../x", "not a path inside"),
    ("arm.xml/b", "written"),
])  # fmt: skip
def test_a_file_outside_the_folder_or_below_a_file_leaves_the_last_build(output, path, words):
    with pytest.raises(OutputError, match=words):
        output.publish(build(b"2") | {path: b"x"})
    assert content(output.target) == build(b"1")
    assert beside(output.target) == ["arm"]


def test_siblings_are_removed_only_if_ours(output):
    output.publish({"report.json": OURS}, FAILED)
    assert beside(output.target) == ["arm", "arm.failed"]
    output.remove(FAILED)
    assert beside(output.target) == ["arm"]
    failed = output.folder(FAILED)
    failed.mkdir()
    (failed / "mine").write_bytes(b"")
    output.remove(FAILED)
    assert (failed / "mine").exists()
    failed.with_name("link.failed").symlink_to(output.target)
    Output(failed.with_name("link")).remove(FAILED)
    assert content(output.target) == build(b"1")
