"""The output folder: swapped whole, mended after a kill, never someone else's."""

import os

import pytest

from linkwright.pipeline.errors import ConfigError, OutputError
from linkwright.pipeline.lock import FOLDER as LOCKS
from linkwright.pipeline.output.folder import FAILED, Output
from linkwright.pipeline.output.manifest import NAME, is_build
from tests.support.kill import killed_at

OURS = b'{"linkwright-report": 1}'


def build(text, **more):
    return {"report.json": OURS, "arm.urdf": text, "assets/a.stl": text, **more}


def content(folder):
    files = [path for path in sorted(folder.rglob("*")) if path.is_file() and path.name != NAME]
    return {str(path.relative_to(folder)): path.read_bytes() for path in files}


def beside(folder):
    return sorted(path.name for path in folder.parent.iterdir() if path.name != LOCKS)


def test_publishing_makes_the_folder_with_exactly_the_files(tmp_path):
    output = Output(tmp_path / "deep" / "arm")
    output.prepare()
    assert output.publish(build(b"1")) == tmp_path / "deep" / "arm"
    assert content(output.target) == build(b"1")
    assert beside(output.target) == ["arm"]


def test_publishing_again_replaces_the_whole_content(tmp_path):
    output = Output(tmp_path / "arm")
    output.publish(build(b"1", extra=b"x"))
    output.publish(build(b"2"))
    assert content(output.target) == build(b"2")
    assert beside(output.target) == ["arm"]


def test_an_empty_folder_may_be_used(tmp_path):
    (tmp_path / "arm").mkdir()
    Output(tmp_path / "arm").publish(build(b"1"))
    assert content(tmp_path / "arm") == build(b"1")


def test_a_file_in_the_place_of_the_folder_is_refused(tmp_path):
    (tmp_path / "arm").write_bytes(b"mine")
    with pytest.raises(ConfigError, match="is a file"):
        Output(tmp_path / "arm").prepare()
    assert (tmp_path / "arm").read_bytes() == b"mine"


def test_the_root_of_the_file_system_is_no_output_folder():
    with pytest.raises(ConfigError, match="output"):
        Output("/")


def test_a_link_to_a_folder_stays_a_link(tmp_path):
    real, link = tmp_path / "real" / "arm", tmp_path / "arm"
    real.mkdir(parents=True)
    link.symlink_to(real)
    Output(link).publish(build(b"1"))
    assert link.is_symlink()
    assert content(real) == build(b"1")


def test_a_place_that_cannot_be_written_is_named_in_one_message(tmp_path):
    (tmp_path / "file").write_bytes(b"")
    output = Output(tmp_path / "made" / "arm")
    (tmp_path / "made").symlink_to(tmp_path / "file")
    with pytest.raises(OutputError, match="cannot be written") as caught:
        output.prepare()
    assert str(tmp_path / "made" / "arm") in str(caught.value)


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may write everywhere")
def test_a_parent_that_may_not_be_written_is_an_output_error_and_keeps_the_last_build(tmp_path):
    output = Output(tmp_path / "out" / "arm")
    output.publish(build(b"1"))
    output.target.parent.chmod(0o555)
    try:
        with pytest.raises(OutputError, match="cannot be written"):
            output.publish(build(b"2"))
    finally:
        output.target.parent.chmod(0o755)
    assert content(output.target) == build(b"1")


@pytest.mark.parametrize("path", ["../x", "/x", "a/../../x"])
def test_a_file_outside_the_folder_is_never_written(tmp_path, path):
    output = Output(tmp_path / "out" / "arm")
    output.publish(build(b"1"))
    with pytest.raises(OutputError, match="no path inside"):
        output.publish(build(b"2") | {path: b"x"})
    assert content(output.target) == build(b"1")
    assert beside(output.target) == ["arm"]


def test_an_error_while_writing_leaves_the_last_build_and_nothing_else(tmp_path):
    output = Output(tmp_path / "arm")
    output.publish(build(b"1"))
    with pytest.raises(OutputError):
        output.publish({"a": b"file", "a/b": b"below a file"})
    assert content(output.target) == build(b"1")
    assert beside(output.target) == ["arm"]


def test_siblings_lie_beside_and_are_removed_only_if_ours(tmp_path):
    output = Output(tmp_path / "arm")
    output.publish(build(b"1"))
    output.publish({"report.json": OURS}, FAILED)
    assert beside(output.target) == ["arm", "arm.failed"]
    output.remove(FAILED)
    assert beside(output.target) == ["arm"]
    (tmp_path / "arm.failed").mkdir()
    (tmp_path / "arm.failed" / "mine").write_bytes(b"")
    output.remove(FAILED)
    assert (tmp_path / "arm.failed" / "mine").exists()
    (tmp_path / "link.failed").symlink_to(tmp_path / "arm")
    Output(tmp_path / "link").remove(FAILED)
    assert content(output.target) == build(b"1")


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
def test_a_kill_at_every_step_leaves_the_old_or_the_new_build_whole(tmp_path):
    Output(tmp_path / "warm" / "arm").publish(build(b"0"))  # so that late imports are no steps
    old, new = build(b"old" * 1000, gone=b"x"), build(b"new" * 1000, come=b"y")
    step, outcomes, absent = 0, set(), 0
    while True:
        step += 1
        output = Output(tmp_path / str(step) / "arm")
        output.publish(old)
        if not killed_at(step, lambda output=output: output.publish(new)):
            break
        absent += not output.target.exists()
        output.prepare()
        assert content(output.target) in (old, new)
        outcomes.add(content(output.target) == new)
        assert beside(output.target) == ["arm"]
        output.publish(new)
        assert content(output.target) == new
    assert step > 20
    assert outcomes == {True, False}, "the kills must fall before and after the swap"
    assert absent, "one kill must fall between the two renames"


def test_ours_is_what_holds_our_report(tmp_path):
    assert not is_build(tmp_path)
    (tmp_path / "report.json").write_bytes(OURS)
    assert is_build(tmp_path)
