"""The output folder: which a build may replace, how it is swapped whole, and who may use it afterwards."""

import json
import os
import stat
import tempfile
from pathlib import Path

import pytest

from linkwright.pipeline.cli import run
from linkwright.pipeline.errors import ConfigError, InTheWay, OutputError
from linkwright.pipeline.lock import FOLDER as LOCKS
from linkwright.pipeline.output import manifest
from linkwright.pipeline.output.folder import FAILED, Output
from linkwright.pipeline.output.manifest import is_build
from tests.support.outputs import OURS, build, content, shell
from tests.support.stand_in_builds import Recorder

BUILD = build(b"1")
ROOT = hasattr(os, "geteuid") and os.geteuid() == 0
SOMEBODY = 12345


def everything(folder):
    """Mode, inode and bytes of each entry below a folder but locks, by path."""
    facts = {}
    for path in sorted(folder.rglob("*")):
        status, name = path.lstat(), str(path.relative_to(folder))
        data = path.read_bytes() if stat.S_ISREG(status.st_mode) else None
        facts[name] = status.st_mode, status.st_ino, data
    return {name: fact for name, fact in facts.items() if not name.startswith(".linkwright")}


def access(folder):
    status = folder.stat()
    return stat.S_IMODE(status.st_mode), status.st_uid, status.st_gid


KEYS_OF_A_USER = "echo private > id"
A_BUILD = f"mkdir arm; echo '{OURS.decode()}' > arm/report.json"
OF_OTHERS = {
    "keys of a user": KEYS_OF_A_USER,
    "a folder": "mkdir -p deep/er",
    "a broken manifest": f"echo '{{' > {manifest.NAME}",
    "a manifest of another program": f"""echo '{{"files": {{}}}}' > {manifest.NAME}""",
    "a report of another program": """echo '{"status": "built"}' > report.json""",
    "a link to a report": f"echo '{OURS.decode()}' > ../mine.json; ln -s ../mine.json report.json",
    "a build inside": A_BUILD,
}


@pytest.mark.parametrize("kind", OF_OTHERS)
@pytest.mark.parametrize("overwrite", [False, True])
@pytest.mark.parametrize("suffix", ["", ".graph", FAILED])
def test_a_full_folder_that_no_build_made_is_refused_and_stays(tmp_path, kind, overwrite, suffix):
    folder = tmp_path / f"full{suffix}"
    folder.mkdir(mode=0o700)
    shell(folder, OF_OTHERS[kind])
    before = everything(tmp_path)
    output = Output(tmp_path / "full", overwrite=overwrite)
    for act in (output.judge, output.prepare):
        with pytest.raises(ConfigError, match="is not empty, and no build made it") as caught:
            act(suffix)
        assert "output=outputs/arm" in caught.value.hint
        assert "elsewhere" in caught.value.hint
    with pytest.raises(InTheWay, match="no build made it"):
        output.publish(BUILD, suffix)
    output.remove(FAILED)
    assert everything(tmp_path) == before


@pytest.mark.parametrize("script", [KEYS_OF_A_USER, A_BUILD])
@pytest.mark.parametrize("swept", [False, True])
@pytest.mark.parametrize("more", [[], ["overwrite=true"]])
def test_the_refusal_comes_before_the_first_stage_or_job(tmp_path, monkeypatch, capsys, script, swept, more):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "full").mkdir()
    shell(tmp_path / "full", script)
    before, build = everything(tmp_path), Recorder()
    words = ["source=sample", "output=full", "until=export", *more]
    status = run(["-m", "root=auto,free", *words], build) if swept else run(words)
    assert (status, build.plans) == (2, [])
    assert "full is not empty, and no build made it" in capsys.readouterr().err
    assert everything(tmp_path) == before


@pytest.mark.parametrize(
    "kind", ["missing", "empty", "only locks", "a build", "of 0.1", "without its report"]
)
@pytest.mark.parametrize("overwrite", [False, True])
def test_a_new_an_empty_and_our_own_folder_is_replaced(tmp_path, kind, overwrite):
    output = Output(tmp_path / "arm", overwrite=overwrite)
    if kind in ("a build", "without its report"):
        output.publish(BUILD)
    if kind == "only locks":
        Output(output.target / "arm").publish(BUILD)
        Output(output.target / "arm").remove("")
    scripts = {"empty": "mkdir arm", "of 0.1": A_BUILD, "without its report": "rm arm/report.json"}
    shell(tmp_path, scripts.get(kind, ""))
    output.judge("", BUILD)
    output.prepare("", BUILD)
    output.publish(BUILD)
    assert (tmp_path / "arm" / "arm.xml").read_bytes() == b"1"


def test_failed_folder_with_user_files_stays_ours(tmp_path):
    output = Output(tmp_path / "arm")
    output.publish({"report.json": OURS}, FAILED)
    notes = output.folder(FAILED) / "NOTES.md"
    notes.write_text("mine")
    output.remove(FAILED)
    output.remove(FAILED)
    assert manifest.written_files(output.folder(FAILED)) == {}
    output.publish({"report.json": OURS}, FAILED)
    assert notes.read_text() == "mine"
    notes.unlink()
    output.remove(FAILED)
    assert not output.folder(FAILED).exists()


def test_what_is_in_the_way_never_moves_into_a_folder_of_others(tmp_path):
    (tmp_path / "arm.replaced").mkdir()
    shell(tmp_path / "arm.replaced", KEYS_OF_A_USER)
    before = everything(tmp_path / "arm.replaced")
    bold = Output(tmp_path / "arm", overwrite=True)
    for text in ("one", "two"):
        bold.publish(BUILD)
        (tmp_path / "arm" / "arm.xml").write_text(text)
    bold.publish(BUILD)
    assert everything(tmp_path / "arm.replaced") == before
    moved = tmp_path / "arm.replaced.2"
    assert [(moved / name).read_text() for name in ("arm.xml", "arm.xml.2")] == ["one", "two"]


@pytest.mark.parametrize("mode", [0o700, 0o750, 0o711, 0o2775, 0o1777])
@pytest.mark.parametrize("kind", ["empty", "a build"])
@pytest.mark.parametrize("suffix", ["", ".graph"])
def test_the_mode_of_an_output_stays(tmp_path, mode, kind, suffix):
    output = Output(tmp_path / "arm")
    folder = output.folder(suffix)
    if kind == "empty":
        folder.mkdir()
    else:
        Output(folder).publish(BUILD)
    folder.chmod(mode)
    before = access(folder)
    for _ in range(2):
        output.prepare(suffix, BUILD)
        output.publish(BUILD, suffix)
        assert access(folder) == before


def test_the_mode_of_a_folder_that_a_link_names_stays(tmp_path):
    shell(tmp_path, "mkdir -m 700 real; ln -s real arm")
    Output(tmp_path / "arm").publish(BUILD)
    assert access(tmp_path / "real")[0] == 0o700


def test_siblings_are_as_private_as_the_output(tmp_path, monkeypatch):
    output = Output(tmp_path / "arm", overwrite=True)
    output.publish(BUILD)
    output.target.chmod(0o700)
    output.publish({"report.json": OURS}, FAILED)
    (output.target / "arm.xml").write_text("mine")
    modes, write = [], manifest.write

    def watched(folder, files):
        modes.append(access(folder)[0])
        write(folder, files)

    monkeypatch.setattr(manifest, "write", watched)
    output.publish(BUILD)
    assert set(modes) == {0o700}
    assert [access(output.folder(end))[0] for end in ("", FAILED, ".replaced")] == [0o700] * 3


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
def test_folder_is_opened_to_no_other_group():
    with tempfile.TemporaryDirectory() as folder:
        Path(folder).chmod(0o777)
        output = Output(Path(folder) / "arm")
        output.target.mkdir()
        os.chown(output.target, SOMEBODY, SOMEBODY)
        output.target.chmod(0o777)
        process = os.fork()
        if not process:
            try:
                os.setgroups([])
                os.setgid(SOMEBODY + 1)
                os.setuid(SOMEBODY + 1)
                output.publish(BUILD)
                os._exit(0)
            finally:
                os._exit(1)
        assert os.waitpid(process, 0)[1] == 0
        assert access(output.target) == (0o707, SOMEBODY + 1, SOMEBODY + 1)


def test_home_root_and_working_folder_are_refused(tmp_path, monkeypatch, capsys):
    home = tmp_path / "home" / "user"
    work = home / "work"
    work.mkdir(parents=True)
    monkeypatch.setenv("HOME", str(home))
    monkeypatch.chdir(work)
    for folder in (tmp_path, tmp_path / "home", home, work):
        (folder / "report.json").write_bytes(OURS)
        (folder / manifest.NAME).write_text(
            json.dumps({manifest.MARK_KEY: 1, "files": {"report.json": None}})
        )
    before = everything(tmp_path)
    for named in ("/", "~", ".", "..", "../..", str(tmp_path), "~/work/../work", "x/.."):
        for more in ([], ["overwrite=true"]):
            assert run(["source=sample", f"output='{named}'", "until=fetch", *more]) == 2
            assert "  → " in capsys.readouterr().err
    assert everything(tmp_path) == before


def beside(folder):
    return sorted(path.name for path in folder.parent.iterdir() if path.name != LOCKS)


@pytest.fixture
def output(tmp_path):
    """A folder with a build in it."""
    made = Output(tmp_path / "out" / "arm")
    made.publish(build(b"1"))
    return made


def test_folder_has_exactly_the_published_files(tmp_path):
    output = Output(tmp_path / "deep" / "arm")
    assert not is_build(output.target)
    output.prepare()
    for files in (build(b"1", extra=b"x"), build(b"2")):
        assert output.publish(files) == tmp_path / "deep" / "arm"
        assert content(output.target) == files
        assert beside(output.target) == ["arm"]
        assert is_build(output.target)


def test_link_to_an_empty_folder_stays_a_link(tmp_path):
    real, link = tmp_path / "real" / "arm", tmp_path / "arm"
    real.mkdir(parents=True)
    link.symlink_to(real)
    Output(link).publish(build(b"1"))
    assert link.is_symlink()
    assert content(real) == build(b"1")


def test_file_and_root_are_no_output_folder(tmp_path):
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
def test_last_build_stays_in_a_read_only_parent(output):
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
def test_last_build_stays_when_a_path_is_wrong(output, path, words):
    with pytest.raises(OutputError, match=words):
        output.publish(build(b"2") | {path: b"x"})
    assert content(output.target) == build(b"1")
    assert beside(output.target) == ["arm"]
