"""What a user keeps in an output folder: carried over, or it stops the build; never lost."""

import contextlib
import json
import os
import socket
from pathlib import Path

import pytest

from linkwright.pipeline.errors import ConfigError, InTheWay
from linkwright.pipeline.output import location, manifest
from linkwright.pipeline.output.folder import FAILED, Output
from tests.support.kill import killed_at
from tests.support.outputs import OURS, build, content, content_of, shell


@pytest.fixture
def heard():
    return []


@pytest.fixture
def output(tmp_path, heard):
    made = Output(tmp_path / "arm", heard.append)
    made.publish(build(b"1\n"))
    return made


def put_everything(folder):
    """Puts one of each kind of thing into a folder; what `content` then says of it."""
    before = content(folder)
    shell(
        folder,
        "echo mine > NOTES.md; mkdir -p runs/deep assets/sub empty; echo 7 > runs/deep/log; mkfifo pipe",
    )
    shell(folder, "echo solid > assets/mine.stl; ln -s NOTES.md link; ln -s /nowhere/at/all dangling")
    shell(folder, "echo x > secret; chmod 600 secret")
    (folder / "\udcff\n.bin").write_bytes(b"odd")
    with socket.socket(socket.AF_UNIX) as server, contextlib.chdir(folder):
        server.bind("socket")
    return {path: value for path, value in content(folder).items() if path not in before}


def test_user_files_are_carried_over_and_named(output, heard):
    named = json.loads((output.target / manifest.NAME).read_bytes())["files"]
    assert set(named) == set(build(b""))
    assert manifest.written_files(output.target) == named
    assert [*manifest.foreign_or_changed(output.target, named)] == []
    users = put_everything(output.target)

    def facts():
        entries = {path: os.lstat(output.target / path) for path in users}
        return {path: (fact.st_ino, fact.st_mode, fact.st_mtime_ns) for path, fact in entries.items()}

    before = facts()
    output.prepare()
    (line,) = heard
    assert "not linkwright's: NOTES.md, assets/mine.stl, assets/sub, dangling, empty, link, pipe" in line
    assert "\n" not in line
    output.publish(build(b"2\n"))
    assert content(output.target) == build(b"2\n") | users
    assert facts() == before
    assert not output.folder(".replaced").exists()
    output.publish({"report.json": OURS})
    assert content(output.target) == {"report.json": OURS} | users, "also in a folder that is no longer made"


CHANGED = "arm.xml was changed since it was built"
INSIDE = "{} is another build, or holds one ({})"
IN_THE_WAY = {
    "a change": ("echo better > arm.xml", CHANGED),
    "a folder for a file": ("rm arm.xml; mkdir arm.xml", CHANGED),
    "a link for a file": ("mv arm.xml ../elsewhere; ln -s ../elsewhere arm.xml", CHANGED),
    "a pipe for a file": ("rm arm.xml; mkfifo arm.xml", CHANGED),
    "a file where a new one goes": ("echo mine > scene.xml", "scene.xml is not linkwright's"),
    "a folder where a new file goes": ("mkdir scene.xml", "scene.xml is not linkwright's"),
    "a link for a folder": ("mv assets ../else; ln -s ../else assets", "assets is not linkwright's"),
    "a build": ("cp -r . ../copy; mkdir runs; mv ../copy runs/b", INSIDE.format("runs", "runs/b")),
    "a build of old": (f"mkdir b; echo '{OURS.decode()}' > b/report.json", INSIDE.format("b", "b")),
    "a build in a folder of ours": (
        "cp -r . ../copy; mv ../copy assets/b",
        INSIDE.format("assets/b", "assets/b"),
    ),
    "a sweep": ("""mkdir s; echo '{"linkwright-sweep": 1}' > s/summary.json""", INSIDE.format("s", "s")),
}
COMING = [*build(b""), "scene.xml"]


@pytest.mark.parametrize("kind", IN_THE_WAY)
@pytest.mark.parametrize("suffix", ["", ".graph"])
def test_entry_in_the_way_stops_a_build_before_it_starts(output, kind, suffix):
    output.publish(build(b"1\n"), suffix)
    script, shown = IN_THE_WAY[kind]
    shell(output.folder(suffix), script)
    before = content(output.target.parent)
    for act in (output.judge, output.prepare):
        with pytest.raises(ConfigError) as caught:
            act(suffix, COMING)
        assert shown in caught.value.message
        assert all(way in caught.value.hint for way in ("overwrite=true", "output=FOLDER", "move it"))
    assert content(output.target.parent) == before


@pytest.mark.parametrize("kind", IN_THE_WAY)
def test_overwrite_moves_what_is_in_the_way_and_deletes_nothing(tmp_path, output, heard, kind):
    (output.target / "NOTES.md").write_text("mine")
    script, shown = IN_THE_WAY[kind]
    shell(output.target, script)
    path = shown.partition(" ")[0]
    kept = {name: value for name, value in content(output.target).items() if name.startswith(path)}
    kept = kept or {path: content_of(output.target / path)}
    bold = Output(output.target, heard.append, overwrite=True)
    new = build(b"2\n", **{"scene.xml": b"s"})
    for _ in range(2):
        bold.prepare("", COMING)
        bold.publish(new)
    assert content(output.target) == {**new, "NOTES.md": b"mine"}
    assert kept.items() <= content(tmp_path / "arm.replaced").items()
    assert [line for line in heard if f"arm.replaced/{path}" in line]


def test_what_was_replaced_before_is_never_overwritten(tmp_path, output):
    bold = Output(output.target, overwrite=True)
    for text in ("one", "two", "three"):
        (output.target / "assets" / "a.stl").write_text(text)
        bold.publish(build(b"2\n"))
    assert content(tmp_path / "arm.replaced") == {
        "assets/a.stl": b"one", "assets/a.stl.2": b"two", "assets/a.stl.3": b"three",
    }  # fmt: skip


def test_file_in_the_way_of_a_late_path_stops_the_swap(output):
    (output.target / "assets" / "b.stl").write_text("mine")
    output.prepare("", COMING)
    before = content(output.target)
    with pytest.raises(InTheWay, match=r"assets/b\.stl is not linkwright's"):
        output.publish(build(b"2\n", **{"assets/b.stl": b"new"}))
    assert content(output.target) == before


@pytest.mark.parametrize("coming", [COMING, [*COMING, "assets/*"]])
def test_a_file_where_a_folder_of_ours_goes_is_in_the_way(tmp_path, coming):
    Output(tmp_path / "arm").publish({"report.json": OURS})
    (tmp_path / "arm" / "assets").write_text("mine")
    with pytest.raises(ConfigError, match="assets is not linkwright's"):
        Output(tmp_path / "arm").judge("", coming)


def test_other_line_ends_and_deleted_files_are_no_change(output):
    plain = b"one\ntwo\nthree\n" * 200_000
    # Of a text whose own line ends are mixed, no change of line ends can be told from another.
    for text, same in ((plain.replace(b"one\n", b"one\r\n"), False), (plain, True)):
        Output(output.target, overwrite=True).publish(build(text))
        (output.target / "arm.xml").write_bytes(plain.replace(b"\n", b"\r\n"))
        shell(output.target, "rm assets/a.stl report.json")
        with contextlib.nullcontext() if same else pytest.raises(ConfigError, match="changed"):
            output.judge("", COMING)
    output.prepare("", COMING)
    output.publish(build(b"2\n"))
    assert content(output.target) == build(b"2\n")


def test_folder_of_version_0_1_is_known_by_its_report(output):
    digest = manifest.written_files(output.target)["arm.xml"]
    (output.target / manifest.NAME).unlink()
    report = {"linkwright-report": 1, "outputs": {"arm.xml": digest, "assets/a.stl": digest, "../x": digest}}
    (output.target / "report.json").write_text(json.dumps(report))
    (output.target / "build.log").write_text("whatever")
    (output.target / "NOTES.md").write_text("mine")
    output.prepare("", COMING)
    output.publish(build(b"2\n"))
    assert content(output.target) == build(b"2\n", **{"NOTES.md": b"mine"})
    (output.target / manifest.NAME).unlink()
    (output.target / "report.json").write_text(json.dumps(report))
    with pytest.raises(ConfigError, match=r"arm.xml was changed"):
        output.judge("", COMING)


@pytest.mark.parametrize(
    "text", ["", "{", "[]", '{"linkwright-files": 1}', '{"linkwright-files": 1, "files": []}', "[" * 100_000]
)
def test_a_manifest_that_is_harmed_makes_nothing_ours(output, text):
    (output.target / manifest.NAME).write_text(text)
    with pytest.raises(ConfigError, match=r"arm\.xml is not linkwright's"):
        output.judge("", COMING)


def test_manifest_has_no_effect_outside_its_folder(tmp_path, output):
    shell(tmp_path, "mkdir far; printf mine > far/a; printf mine > mine; ln -s ../far arm/out")
    paths = dict.fromkeys(["../mine", str(tmp_path / "mine"), "out/a", "./arm.xml", "..", "."])
    manifest.write(output.target, paths)
    Output(output.target, overwrite=True).publish(build(b"2\n"))
    assert (tmp_path / "mine").read_text() == (tmp_path / "far" / "a").read_text() == "mine"
    assert (output.target / "out").is_symlink()


def test_what_cannot_be_moved_stops_a_build_also_with_overwrite(output, monkeypatch):
    (output.target / "disk").mkdir()
    monkeypatch.setattr(Path, "is_mount", lambda path: path.name == "disk")
    for overwrite in (True, False):
        with pytest.raises(ConfigError, match="disk is not linkwright's, and cannot be moved") as caught:
            Output(output.target, overwrite=overwrite).judge()
        assert "overwrite" not in caught.value.hint


@pytest.mark.parametrize("name", [".arm.tmp", ".arm.old"])
@pytest.mark.parametrize("there", [True, False])
def test_sibling_under_a_name_of_ours_is_moved_and_kept(tmp_path, heard, name, there):
    output = Output(tmp_path / "arm", heard.append)
    if there:
        output.publish(build(b"1\n"))
    shell(tmp_path, f"mkdir -p {name}/empty; printf mine > {name}/mine")
    output.prepare()
    output.publish(build(b"2\n"))
    assert content(output.target) == build(b"2\n")
    assert content(tmp_path / "arm.replaced") == {f"{name}/mine": b"mine", f"{name}/empty": "empty"}
    assert [line for line in heard if f"arm.replaced/{name}" in line]


def test_failed_folder_never_fails_a_good_build(tmp_path, output, heard):
    output.publish({"report.json": OURS, "build.log": b"1\n", "report.html": b"1\n"}, FAILED)
    failed = output.folder(FAILED)
    (failed / "NOTES.md").write_text("mine")
    (failed / "empty").mkdir()
    (failed / "build.log").write_text("changed")
    output.prepare()
    output.publish(build(b"2\n"))
    output.remove(FAILED)
    left = {"NOTES.md": b"mine", "build.log": b"changed", "empty": "empty"}
    assert content(failed) == left
    with pytest.raises(InTheWay, match=r"build\.log is not linkwright's"):
        output.publish({"report.json": OURS, "build.log": b"3"}, FAILED)
    assert content(failed) == left
    output.publish({"report.json": OURS}, FAILED)
    assert content(failed) == {**left, "report.json": OURS}


@pytest.mark.parametrize("make", [lambda path: path.write_text("mine"), lambda path: path.symlink_to("arm")])
def test_file_for_the_failed_folder_fails_no_good_build(output, make):
    make(output.folder(FAILED))
    before = content_of(output.folder(FAILED))
    output.prepare()
    output.publish(build(b"2\n"))
    output.remove(FAILED)
    with pytest.raises(InTheWay):
        output.publish({"report.json": OURS}, FAILED)
    assert content_of(output.folder(FAILED)) == before
    assert content(output.target) == build(b"2\n")


@pytest.mark.parametrize(("folder", "shown"), [
    ("/", "cannot be an output folder"),
    ("~", "your home folder"),
    ("~nobody-of-that-name/arm", "nobody"),
    (".", "working folder"),
    ("..", "your home folder"),
    ("../../home/work", "working folder"),
    ("file", "is a file"),
    ("file/x", "is a file"),
    ("link-to-file/x", "is a file|Not a directory"),
    ("x" * 300, "too long"),
    ("out/" + "y" * 300 + "/x", "too long"),
    ("loop/x", "cannot be a folder"),
    ("a\0b", "null"),
    ("cache", "cache folder"),
    ("cache/cas", "in the cache folder"),
    ("cache/tmp/arm", "in the cache folder"),
    ("holds-cache", "holds the cache folder"),
    ("robots", "holds the source"),
    ("robots/arm", "holds the source"),
])  # fmt: skip
def test_impossible_place_is_refused_with_a_way_out(tmp_path, monkeypatch, folder, shown):
    here = tmp_path / "home" / "work"
    here.mkdir(parents=True)
    monkeypatch.chdir(here)
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    (here / "file").write_text("mine")
    (here / "link-to-file").symlink_to("file")
    (here / "loop").symlink_to("loop")
    before = sorted(tmp_path.rglob("*"))
    taken = {"the source": here / "robots" / "arm" / "arm.urdf"}
    cache = here / ("holds-cache/inside" if folder == "holds-cache" else "cache")
    with pytest.raises(ConfigError, match=shown) as caught:
        location.require_free(Output(folder).target, taken, cache)
    assert "output=" in caught.value.hint
    assert sorted(tmp_path.rglob("*")) == before


def test_the_home_folder_is_meant_by_its_sign(tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))
    assert Output("~/out/arm").target == tmp_path / "out" / "arm"


def mixed(output, text):
    """A build with files of the user's in it, of which some are changed; what must never be lost."""
    output.publish(build(text, gone=b"x"))
    shell(
        output.target, "printf mine > NOTES.md; printf too > assets/mine.stl; mkdir runs; printf 7 > runs/log"
    )
    shell(output.target, "ln -s NOTES.md link; printf 'mine now' > arm.xml")
    return {"NOTES.md": b"mine", "assets/mine.stl": b"too", "runs/log": b"7", "link": "NOTES.md"}


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
def test_kill_at_any_step_leaves_a_build_and_user_files(tmp_path):
    mixed(Output(tmp_path / "warm" / "arm"), b"0")
    # So that late imports are no steps.
    Output(tmp_path / "warm" / "arm", overwrite=True).publish(build(b"1"))
    step, outcomes, absent, killed, new = 0, set(), 0, True, build(b"new", come=b"y")
    while killed:
        step += 1
        top = tmp_path / str(step)
        output = Output(top / "arm", overwrite=True)
        users = mixed(output, b"old")
        output.target.chmod(0o700)
        killed = killed_at(step, lambda output=output: output.publish(new))
        # Wherever it was killed, all that is the user's is somewhere, whole.
        everything = [*content(top).values()]
        assert all(data in everything for data in (*users.values(), b"mine now"))
        absent += not output.target.exists()
        output.judge("", build(b""))
        output.prepare("", build(b""))
        swapped = content(output.target)["arm.xml"] == b"new"
        outcomes.add(swapped)
        expected = new if swapped else build(b"old", gone=b"x") | {"arm.xml": b"mine now"}
        assert content(output.target) == expected | users
        assert content(top / "arm.replaced") == ({"arm.xml": b"mine now"} if swapped else {})
        names = [".linkwright", "arm", *(["arm.replaced"] if swapped else [])]
        assert sorted(path.name for path in top.iterdir()) == names
        output.publish(new)
        assert content(output.target) == new | users
        assert output.target.stat().st_mode & 0o777 == 0o700
    assert step > 30
    assert outcomes == {True, False}, "the kills must fall before and after the swap"
    assert absent, "a kill must fall between the two renames"


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
def test_kill_at_any_step_of_removing_loses_no_user_file(tmp_path):
    for step in range(1, 100):
        output = Output(tmp_path / str(step) / "arm")
        output.publish({"report.json": OURS, "build.log": b"1", "assets/a": b"2"}, FAILED)
        (output.folder(FAILED) / "NOTES.md").write_text("mine")
        killed = killed_at(step, lambda output=output: output.remove(FAILED))
        assert (output.folder(FAILED) / "NOTES.md").read_text() == "mine"
        output.remove(FAILED)
        assert content(output.folder(FAILED)) == {"NOTES.md": b"mine"}
        assert manifest.written_files(output.folder(FAILED)) == {}
        if not killed:
            break
    assert not killed
