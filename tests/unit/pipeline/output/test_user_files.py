"""What a user keeps in an output folder: carried over, or it stops the build; never lost."""

import json
import os
import socket
import stat
from pathlib import Path

import pytest

from linkwright.pipeline.errors import ConfigError, InTheWay
from linkwright.pipeline.output import location, manifest
from linkwright.pipeline.output.folder import FAILED, Output
from tests.support.kill import killed_at

OURS = b'{"linkwright-report": 1}'


def build(text, **more):
    return {"report.json": OURS, "arm.xml": text, "assets/a.stl": text, **more}


def content(folder):
    """Every entry below the folder, but for manifests and locks: path → bytes, or what else it is."""
    found = {}
    for top, below, files in os.walk(folder):
        below[:] = [name for name in below if name != ".linkwright"]
        for name in (*below, *files):
            path = Path(top, name)
            if name != manifest.NAME:
                found[str(path.relative_to(folder))] = what(path)
    return {path: one for path, one in sorted(found.items()) if one is not dir}


def what(path):
    mode = path.lstat().st_mode
    if stat.S_ISREG(mode):
        return path.read_bytes()
    if stat.S_ISLNK(mode):
        return str(path.readlink())
    if stat.S_ISDIR(mode):
        return dir if any(path.iterdir()) else "empty"
    return stat.S_IFMT(mode)


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
    (folder / "NOTES.md").write_text("mine")
    (folder / "runs" / "deep").mkdir(parents=True)
    (folder / "runs" / "deep" / "log").write_text("7")
    (folder / "assets" / "mine.stl").write_text("solid")
    (folder / "assets" / "sub").mkdir()
    (folder / "empty").mkdir()
    (folder / "link").symlink_to("NOTES.md")
    (folder / "dangling").symlink_to("/nowhere/at/all")
    (folder / "\udcff\n.bin").write_bytes(b"odd")
    os.mkfifo(folder / "pipe")
    with socket.socket(socket.AF_UNIX) as server:
        os.chdir(folder)
        server.bind("socket")
        os.chdir("/")
    (folder / "secret").write_text("x")
    (folder / "secret").chmod(0o600)
    return {path: one for path, one in content(folder).items() if path not in before}


def test_every_folder_begins_with_a_manifest_of_what_is_ours(output):
    named = json.loads((output.target / manifest.NAME).read_bytes())["files"]
    assert set(named) == set(build(b""))
    assert manifest.ours(output.target) == named
    assert [*manifest.others(output.target, named)] == []


def test_what_is_not_ours_is_carried_over_untouched_and_named_in_one_line(output, heard):
    mine = put_everything(output.target)
    before = {path: os.lstat(output.target / path) for path in mine}
    output.prepare()
    assert len(heard) == 1
    assert "not linkwright's: NOTES.md, assets/mine.stl, assets/sub, dangling, empty, link, pipe" in heard[0]
    assert "\n" not in heard[0]
    output.publish(build(b"2\n"))
    assert content(output.target) == build(b"2\n") | mine
    after = {path: os.lstat(output.target / path) for path in mine}
    assert {path: (one.st_ino, one.st_mode, one.st_mtime_ns) for path, one in after.items()} == {
        path: (one.st_ino, one.st_mode, one.st_mtime_ns) for path, one in before.items()
    }
    assert not (output.folder(".replaced")).exists()


def test_what_is_in_a_folder_that_the_build_no_longer_makes_stays_there(output):
    (output.target / "assets" / "mine.stl").write_text("solid")
    output.publish({"report.json": OURS})
    assert content(output.target) == {"report.json": OURS, "assets/mine.stl": b"solid"}


def changed(folder):
    (folder / "arm.xml").write_text("better")
    return "arm.xml was changed since it was built"


def a_folder_for_a_file(folder):
    (folder / "arm.xml").unlink()
    (folder / "arm.xml").mkdir()
    return "arm.xml was changed since it was built"


def a_link_for_a_file(folder):
    (folder / "arm.xml").rename(folder.parent / "elsewhere")
    (folder / "arm.xml").symlink_to(folder.parent / "elsewhere")
    return "arm.xml was changed since it was built"


def a_pipe_for_a_file(folder):
    (folder / "arm.xml").unlink()
    os.mkfifo(folder / "arm.xml")
    return "arm.xml was changed since it was built"


def a_file_where_a_new_one_goes(folder):
    (folder / "scene.xml").write_text("mine")
    return "scene.xml is not linkwright's"


def a_folder_where_a_new_file_goes(folder):
    (folder / "scene.xml").mkdir()
    return "scene.xml is not linkwright's"


def a_link_for_a_folder(folder):
    (folder / "assets").rename(folder.parent / "elsewhere")
    (folder / "assets").symlink_to(folder.parent / "elsewhere")
    return "assets is not linkwright's"


def a_build(folder):
    Output(folder / "variants" / "b").publish(build(b"inside"))
    return "variants is another build, or holds one (variants/b)"


def a_build_of_old(folder):
    (folder / "b").mkdir()
    (folder / "b" / "report.json").write_bytes(OURS)
    return "b is another build, or holds one (b)"


def a_build_in_a_folder_of_ours(folder):
    Output(folder / "assets" / "b").publish(build(b"inside"))
    return "assets/b is another build, or holds one (assets/b)"


def a_sweep(folder):
    (folder / "s").mkdir()
    (folder / "s" / "summary.json").write_text('{"linkwright-sweep": 1}')
    return "s is another build, or holds one (s)"


IN_THE_WAY = [
    changed,
    a_folder_for_a_file,
    a_link_for_a_file,
    a_pipe_for_a_file,
    a_file_where_a_new_one_goes,
    a_folder_where_a_new_file_goes,
    a_link_for_a_folder,
    a_build,
    a_build_of_old,
    a_build_in_a_folder_of_ours,
    a_sweep,
]
COMING = [*build(b""), "scene.xml"]


@pytest.mark.parametrize("put", IN_THE_WAY)
@pytest.mark.parametrize("suffix", ["", ".graph"])
def test_what_is_in_the_way_stops_a_build_before_it_starts_with_the_ways_out(output, put, suffix):
    output.publish(build(b"1\n"), suffix)
    shown = put(output.folder(suffix))
    before = content(output.target.parent)
    for act in (output.judge, output.prepare):
        with pytest.raises(ConfigError) as caught:
            act(suffix, COMING)
        assert shown in caught.value.message
        assert all(way in caught.value.hint for way in ("overwrite=true", "output=FOLDER", "move it"))
    assert content(output.target.parent) == before


@pytest.mark.parametrize("put", IN_THE_WAY)
def test_overwrite_moves_what_is_in_the_way_and_deletes_nothing(tmp_path, output, heard, put):
    (output.target / "NOTES.md").write_text("mine")
    path = put(output.target).partition(" ")[0]
    kept = {name: one for name, one in content(output.target).items() if name.startswith(path)}
    kept = kept or {path: what(output.target / path)}
    bold = Output(output.target, heard.append, overwrite=True)
    new = build(b"2\n", **{"scene.xml": b"s"})
    for _ in range(2):
        bold.prepare("", COMING)
        bold.publish(new)
    assert content(output.target) == {**new, "NOTES.md": b"mine"}
    found = content(tmp_path / "arm.replaced")
    assert {name: one for name, one in found.items() if name in kept} == kept
    assert [line for line in heard if f"arm.replaced/{path}" in line]


def test_what_was_replaced_before_is_never_overwritten(tmp_path, output):
    bold = Output(output.target, overwrite=True)
    for text in ("one", "two", "three"):
        (output.target / "assets" / "a.stl").write_text(text)
        bold.publish(build(b"2\n"))
    assert content(tmp_path / "arm.replaced") == {
        "assets/a.stl": b"one",
        "assets/a.stl.2": b"two",
        "assets/a.stl.3": b"three",
    }


def test_a_path_that_is_known_only_late_stops_at_the_swap_and_both_are_kept(output):
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


def test_line_ends_alone_and_deleted_files_are_no_matter(output):
    text = b"one\r\ntwo\nthree\n" * 200_000
    output.publish(build(text))
    (output.target / "arm.xml").write_bytes(text.replace(b"\r\n", b"\n").replace(b"\n", b"\r\n"))
    (output.target / "assets" / "a.stl").unlink()
    (output.target / "report.json").unlink()
    # Of a text whose own line ends are mixed, no change of line ends can be told from another.
    with pytest.raises(ConfigError, match="changed"):
        output.judge("", COMING)
    plain = text.replace(b"\r\n", b"\n")
    Output(output.target, overwrite=True).publish(build(plain))
    (output.target / "arm.xml").write_bytes(plain.replace(b"\n", b"\r\n"))
    (output.target / "assets" / "a.stl").unlink()
    (output.target / "report.json").unlink()
    output.prepare("", COMING)
    output.publish(build(b"2\n"))
    assert content(output.target) == build(b"2\n")


def test_a_folder_of_version_0_1_is_known_by_its_report_and_the_usual_names(output):
    digest = manifest.ours(output.target)["arm.xml"]
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
    "text",
    ["", "{", "[]", '{"linkwright-files": 1}', '{"linkwright-files": 1, "files": []}', "[" * 100_000],
)
def test_a_manifest_that_is_harmed_makes_nothing_ours(output, text):
    (output.target / manifest.NAME).write_text(text)
    with pytest.raises(ConfigError, match=r"arm\.xml is not linkwright's"):
        output.judge("", COMING)


def test_a_manifest_that_names_what_is_outside_has_no_effect_there(tmp_path, output):
    (tmp_path / "mine").write_text("mine")
    (tmp_path / "far").mkdir()
    (tmp_path / "far" / "a").write_text("mine")
    (output.target / "out").symlink_to(tmp_path / "far")
    own = dict.fromkeys(["../mine", str(tmp_path / "mine"), "out/a", "./arm.xml", "..", "."])
    manifest.write(output.target, own)
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
def test_what_others_put_beside_under_a_name_of_ours_is_moved_and_kept(tmp_path, heard, name, there):
    output = Output(tmp_path / "arm", heard.append)
    if there:
        output.publish(build(b"1\n"))
    (tmp_path / name).mkdir()
    (tmp_path / name / "mine").write_text("mine")
    (tmp_path / name / "empty").mkdir()
    output.prepare()
    output.publish(build(b"2\n"))
    assert content(output.target) == build(b"2\n")
    assert content(tmp_path / "arm.replaced") == {f"{name}/mine": b"mine", f"{name}/empty": "empty"}
    assert [line for line in heard if f"arm.replaced/{name}" in line]


def test_a_failed_folder_never_fails_a_good_build_and_keeps_what_is_not_ours(tmp_path, output, heard):
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
def test_what_is_no_folder_in_the_place_of_the_failed_one_never_fails_a_good_build(output, make):
    make(output.folder(FAILED))
    before = what(output.folder(FAILED))
    output.prepare()
    output.publish(build(b"2\n"))
    output.remove(FAILED)
    with pytest.raises(InTheWay):
        output.publish({"report.json": OURS}, FAILED)
    assert what(output.folder(FAILED)) == before
    assert content(output.target) == build(b"2\n")


@pytest.mark.parametrize(
    ("folder", "shown"),
    [
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
    ],
)
def test_a_place_that_no_output_can_have_is_refused_with_a_way_out(tmp_path, monkeypatch, folder, shown):
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
    (output.target / "NOTES.md").write_text("mine")
    (output.target / "assets" / "mine.stl").write_text("mine too")
    (output.target / "runs").mkdir()
    (output.target / "runs" / "log").write_text("7")
    (output.target / "link").symlink_to("NOTES.md")
    (output.target / "arm.xml").write_text("mine now")
    return {"NOTES.md": b"mine", "assets/mine.stl": b"mine too", "runs/log": b"7", "link": "NOTES.md"}


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
def test_a_kill_at_every_step_loses_nothing_of_the_users(tmp_path):
    mixed(Output(tmp_path / "warm" / "arm"), b"0")
    Output(tmp_path / "warm" / "arm", overwrite=True).publish(
        build(b"1")
    )  # so that late imports are no steps
    step, outcomes = 0, set()
    while True:
        step += 1
        top = tmp_path / str(step)
        output = Output(top / "arm", overwrite=True)
        mine = mixed(output, b"old")
        killed = killed_at(step, lambda output=output: output.publish(build(b"new", come=b"y")))
        # Wherever it was killed, all that is the user's is somewhere, whole.
        everything = [*content(top).values()]
        assert all(one in everything for one in (*mine.values(), b"mine now"))
        output.prepare()
        found, moved = content(output.target), content(top / "arm.replaced")
        new = found["arm.xml"] == b"new"
        outcomes.add(new)
        expected = build(b"new", come=b"y") if new else build(b"old", gone=b"x") | {"arm.xml": b"mine now"}
        assert found == expected | mine
        assert moved == ({"arm.xml": b"mine now"} if new else {})
        assert sorted(path.name for path in top.iterdir()) == [
            ".linkwright",
            "arm",
            *(["arm.replaced"] if new else []),
        ]
        if not killed:
            break
    assert step > 30
    assert outcomes == {True, False}


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
def test_a_kill_at_every_step_of_removing_loses_nothing_of_the_users(tmp_path):
    for step in range(1, 100):
        output = Output(tmp_path / str(step) / "arm")
        output.publish({"report.json": OURS, "build.log": b"1", "assets/a": b"2"}, FAILED)
        (output.folder(FAILED) / "NOTES.md").write_text("mine")
        killed = killed_at(step, lambda output=output: output.remove(FAILED))
        assert (output.folder(FAILED) / "NOTES.md").read_text() == "mine"
        output.remove(FAILED)
        assert content(output.folder(FAILED)) == {"NOTES.md": b"mine"}
        assert manifest.ours(output.folder(FAILED)) == {}
        if not killed:
            break
    assert not killed
