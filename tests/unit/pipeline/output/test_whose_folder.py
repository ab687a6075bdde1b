"""Which folder a build may replace: a new one, an empty one, its own; and who may use it afterwards."""

import json
import os
import stat
import tempfile
from pathlib import Path

import pytest

from linkwright.pipeline.cli import run
from linkwright.pipeline.errors import ConfigError, InTheWay
from linkwright.pipeline.output import manifest
from linkwright.pipeline.output.folder import FAILED, Output
from linkwright.pipeline.report import Report
from tests.support.kill import killed_at

OURS = b'{"linkwright-report": 1}'
BUILD = {"report.json": OURS, "arm.xml": b"1", "assets/a.stl": b"1"}
ROOT = hasattr(os, "geteuid") and os.geteuid() == 0
SOMEBODY = 12345


def everything(folder: Path) -> dict[str, object]:
    """Mode, inode and bytes of each entry below a folder, by path."""
    found: dict[str, object] = {}
    for path in sorted(folder.rglob("*")):
        status = path.lstat()
        data = path.read_bytes() if stat.S_ISREG(status.st_mode) else None
        found[str(path.relative_to(folder))] = (status.st_mode, status.st_ino, data)
    return found


def access(folder: Path) -> tuple[int, int, int]:
    status = folder.stat()
    return stat.S_IMODE(status.st_mode), status.st_uid, status.st_gid


def keys_of_a_user(folder: Path) -> None:
    (folder / "id").write_text("private")


def one_folder(folder: Path) -> None:
    (folder / "deep" / "er").mkdir(parents=True)


def a_broken_manifest(folder: Path) -> None:
    (folder / manifest.NAME).write_text("{")


def a_manifest_of_another_program(folder: Path) -> None:
    (folder / manifest.NAME).write_text('{"files": {}}')


def a_report_of_another_program(folder: Path) -> None:
    (folder / "report.json").write_text('{"status": "built"}')


def a_link_to_a_report(folder: Path) -> None:
    (folder.parent / "mine.json").write_bytes(OURS)
    (folder / "report.json").symlink_to(folder.parent / "mine.json")


def a_build_inside(folder: Path) -> None:
    Output(folder / "arm").publish(BUILD)


OF_OTHERS = [
    keys_of_a_user,
    one_folder,
    a_broken_manifest,
    a_manifest_of_another_program,
    a_report_of_another_program,
    a_link_to_a_report,
    a_build_inside,
]


@pytest.mark.parametrize("put", OF_OTHERS)
@pytest.mark.parametrize("overwrite", [False, True])
@pytest.mark.parametrize("suffix", ["", ".graph", FAILED])
def test_a_full_folder_that_no_build_made_is_refused_and_stays_as_it_was(tmp_path, put, overwrite, suffix):
    folder = tmp_path / f"full{suffix}"
    folder.mkdir(mode=0o700)
    put(folder)
    before = everything(tmp_path)
    output = Output(tmp_path / "full", overwrite=overwrite)
    for act in (output.judge, output.prepare):
        with pytest.raises(ConfigError, match="is not empty, and no build made it") as caught:
            act(suffix)
        assert "output=outputs/arm" in caught.value.hint
        assert "elsewhere" in caught.value.hint
    with pytest.raises(InTheWay, match="no build made it"):
        output.publish(BUILD, suffix)
    after = {path: one for path, one in everything(tmp_path).items() if not path.startswith(".linkwright")}
    assert after == {path: one for path, one in before.items() if not path.startswith(".linkwright")}


@pytest.mark.parametrize("put", [keys_of_a_user, a_build_inside])
def test_the_refusal_comes_before_the_first_stage(tmp_path, monkeypatch, capsys, put):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "full").mkdir()
    put(tmp_path / "full")
    before = everything(tmp_path)
    for more in ([], ["overwrite=true"]):
        assert run(["source=sample", "output=full", "until=export", *more]) == 2
        assert "full is not empty, and no build made it" in capsys.readouterr().err
        assert everything(tmp_path) == before


@pytest.mark.parametrize("more", [[], ["overwrite=true"]])
def test_so_is_that_of_a_sweep(tmp_path, monkeypatch, capsys, more):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "full").mkdir()
    keys_of_a_user(tmp_path / "full")
    before = everything(tmp_path)
    plans = []

    def build(plan):
        plans.append(plan)
        return Report("built", plan.name, str(plan.folder), plan.until, 0)

    assert run(["-m", "source=sample", "root=auto,free", "output=full", *more], build) == 2
    assert "full is not empty, and no build made it" in capsys.readouterr().err
    assert plans == []
    assert everything(tmp_path) == before


def missing(folder: Path) -> None:
    folder.parent.mkdir(parents=True, exist_ok=True)


def empty(folder: Path) -> None:
    folder.mkdir()


def only_locks(folder: Path) -> None:
    Output(folder / "arm").publish(BUILD)
    Output(folder / "arm").remove("")


def a_build(folder: Path) -> None:
    Output(folder).publish(BUILD)


def a_build_of_0_1(folder: Path) -> None:
    folder.mkdir()
    (folder / "report.json").write_bytes(OURS)


def a_build_without_its_report(folder: Path) -> None:
    a_build(folder)
    (folder / "report.json").unlink()


@pytest.mark.parametrize(
    "put", [missing, empty, only_locks, a_build, a_build_of_0_1, a_build_without_its_report]
)
@pytest.mark.parametrize("overwrite", [False, True])
def test_a_new_an_empty_and_our_own_folder_is_replaced(tmp_path, put, overwrite):
    put(tmp_path / "arm")
    output = Output(tmp_path / "arm", overwrite=overwrite)
    output.judge("", BUILD)
    output.prepare("", BUILD)
    output.publish(BUILD)
    assert (tmp_path / "arm" / "arm.xml").read_bytes() == b"1"


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
def test_a_swap_that_was_cut_short_is_mended_at_each_step(tmp_path):
    Output(tmp_path / "warm").publish(BUILD)  # so that late imports are no steps
    step = 0
    while True:
        step += 1
        output = Output(tmp_path / str(step) / "arm")
        output.publish(BUILD)
        output.target.chmod(0o700)
        (output.target / "NOTES.md").write_text("mine")
        killed = killed_at(step, lambda output=output: output.publish(BUILD | {"arm.xml": b"2"}))
        output.judge("", BUILD)
        output.prepare("", BUILD)
        output.publish(BUILD | {"arm.xml": b"3"})
        assert (output.target / "arm.xml").read_bytes() == b"3"
        assert (output.target / "NOTES.md").read_text() == "mine"
        assert access(output.target)[0] == 0o700
        if not killed:
            break
    assert step > 20


def test_the_failed_folder_with_files_of_the_user_stays_linkwrights(tmp_path):
    output = Output(tmp_path / "arm")
    output.publish({"report.json": OURS}, FAILED)
    (output.folder(FAILED) / "NOTES.md").write_text("mine")
    output.remove(FAILED)
    output.remove(FAILED)
    assert manifest.ours(output.folder(FAILED)) == {}
    output.publish({"report.json": OURS}, FAILED)
    assert (output.folder(FAILED) / "NOTES.md").read_text() == "mine"
    (output.folder(FAILED) / "NOTES.md").unlink()
    output.remove(FAILED)
    assert not output.folder(FAILED).exists()


def test_what_is_in_the_way_never_moves_into_a_folder_of_others(tmp_path):
    (tmp_path / "arm.replaced").mkdir()
    keys_of_a_user(tmp_path / "arm.replaced")
    before = everything(tmp_path / "arm.replaced")
    bold = Output(tmp_path / "arm", overwrite=True)
    for text in ("one", "two"):
        bold.publish(BUILD)
        (tmp_path / "arm" / "arm.xml").write_text(text)
    bold.publish(BUILD)
    assert everything(tmp_path / "arm.replaced") == before
    moved = tmp_path / "arm.replaced.2"
    assert [(moved / name).read_text() for name in ("arm.xml", "arm.xml.2")] == ["one", "two"]


MODES = [0o700, 0o750, 0o711, 0o2775, 0o1777]


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("put", [empty, a_build])
@pytest.mark.parametrize("suffix", ["", ".graph"])
def test_the_mode_of_an_output_stays(tmp_path, mode, put, suffix):
    output = Output(tmp_path / "arm")
    folder = output.folder(suffix)
    put(folder)
    folder.chmod(mode)
    before = access(folder)
    for _ in range(2):
        output.prepare(suffix, BUILD)
        output.publish(BUILD, suffix)
        assert access(folder) == before


def test_the_mode_of_a_folder_that_a_link_names_stays(tmp_path):
    (tmp_path / "real").mkdir()
    (tmp_path / "real").chmod(0o700)
    (tmp_path / "arm").symlink_to(tmp_path / "real")
    Output(tmp_path / "arm").publish(BUILD)
    assert access(tmp_path / "real")[0] == 0o700


def test_the_folder_of_a_failure_and_what_is_moved_are_as_private_as_the_output(tmp_path):
    output = Output(tmp_path / "arm", overwrite=True)
    output.publish(BUILD)
    output.target.chmod(0o700)
    output.publish({"report.json": OURS}, FAILED)
    (output.target / "arm.xml").write_text("mine")
    output.publish(BUILD)
    assert [access(output.folder(end))[0] for end in ("", FAILED, ".replaced")] == [0o700] * 3


def test_a_new_folder_is_private_while_it_is_written(tmp_path, monkeypatch):
    output = Output(tmp_path / "arm")
    output.publish(BUILD)
    output.target.chmod(0o700)
    seen = []
    write = manifest.write

    def watched(folder, own):
        seen.append(access(folder)[0])
        write(folder, own)

    monkeypatch.setattr(manifest, "write", watched)
    output.publish(BUILD)
    assert seen == [0o700]


@pytest.mark.skipif(not ROOT, reason="only root may give files away")
def test_the_owner_of_an_output_stays(tmp_path):
    output = Output(tmp_path / "arm")
    output.target.mkdir(mode=0o700)
    os.chown(output.target, SOMEBODY, SOMEBODY)
    for _ in range(2):
        output.prepare("", BUILD)
        output.publish(BUILD)
        assert access(output.target) == (0o700, SOMEBODY, SOMEBODY)
        owners = {path.lstat().st_uid for path in output.target.rglob("*")}
        assert owners == {SOMEBODY}, "the owner can remove what the build wrote"


@pytest.mark.skipif(not ROOT, reason="only root can act as another user")
def test_a_user_who_cannot_give_a_folder_away_opens_it_to_no_other_group():
    with tempfile.TemporaryDirectory() as folder:
        Path(folder).chmod(0o777)
        output = Output(Path(folder) / "arm")
        output.target.mkdir()
        os.chown(output.target, SOMEBODY, SOMEBODY)
        output.target.chmod(0o777)
        assert _published_by(SOMEBODY + 1, output)
        assert access(output.target) == (0o707, SOMEBODY + 1, SOMEBODY + 1)


def _published_by(user: int, output: Output) -> bool:
    """Whether a build by a user, in a process of its own, wrote the output."""
    pid = os.fork()
    if not pid:
        try:
            os.setgroups([])
            os.setgid(user)
            os.setuid(user)
            output.publish(BUILD)
            os._exit(0)
        finally:
            os._exit(1)
    return os.waitpid(pid, 0)[1] == 0


def test_home_root_the_working_folder_and_their_parents_are_refused_even_where_a_build_was(
    tmp_path, monkeypatch, capsys
):
    home = tmp_path / "home" / "user"
    work = home / "work"
    work.mkdir(parents=True)
    monkeypatch.setenv("HOME", str(home))
    monkeypatch.chdir(work)
    for folder in (tmp_path, tmp_path / "home", home, work):
        (folder / "report.json").write_bytes(OURS)
        (folder / manifest.NAME).write_text(json.dumps({manifest.MARK: 1, "files": {"report.json": None}}))
    before = everything(tmp_path)
    for named in ("/", "~", ".", "..", "../..", str(tmp_path), "~/work/../work", "x/.."):
        for more in ([], ["overwrite=true"]):
            assert run(["source=sample", f"output='{named}'", "until=fetch", *more]) == 2
            assert "  → " in capsys.readouterr().err
    assert everything(tmp_path) == before
