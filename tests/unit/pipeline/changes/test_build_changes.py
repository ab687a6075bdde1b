"""What a build changes about the last build in its folder."""

import json

import pytest

from linkwright.pipeline.changes.build_changes import MAX_ROBOT_CHANGES, compare_builds
from linkwright.pipeline.changes.compare import compare
from linkwright.pipeline.digest import sha256
from linkwright.pipeline.output import manifest
from linkwright.pipeline.page.changed import changes_section
from linkwright.pipeline.page.head import difference
from linkwright.pipeline.run.build import build, build_files
from linkwright.pipeline.secrets import Secrets
from linkwright.stages.robot.check import Check
from linkwright.stages.robot.errors import AssemblyError
from tests.support.building import plan_of
from tests.support.page_reader import Reader

HOSTILE = "</script><img src=x onerror=alert(1)>"


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """The sample's robot.json, and other files."""
    plan = plan_of(cache={"dir": str(tmp_path_factory.mktemp("cache"))}, until="graph")
    return {**build_files(plan, in_memory=True).files, "sample.urdf": b"<robot/>", "scene.xml": b"<mujoco/>"}


@pytest.fixture
def last(tmp_path, files):
    """A folder in which these files are."""
    folder = tmp_path / "out"
    folder.mkdir()
    for path, data in files.items():
        (folder / path).write_bytes(data)
    manifest.write(folder, {**digests(files), "report.html": None, "report.json": "ab" * 32})
    return folder


def digests(files):
    return {path: sha256(data) for path, data in files.items()}


def changed_robot(files, change):
    robot = json.loads(files["robot.json"])
    change(robot)
    return {**files, "robot.json": json.dumps(robot).encode()}


def text(changes):
    return Reader(changes_section(changes, Secrets({})).encode()).text


def test_the_first_build_and_one_that_changes_nothing_say_so(tmp_path, last, files):
    first = compare_builds(tmp_path / "none", digests(files), files)
    assert first.first
    assert "first build here" in text(first)
    same = compare_builds(last, digests(files), files)
    assert same.unchanged
    assert "Nothing: each of the robot's files is as it was" in text(same)
    assert changes_section(None, Secrets({})) == ""


def test_what_is_equal_by_its_digest_is_not_read(last, files):
    (last / "robot.json").write_bytes(b"no JSON")
    assert compare_builds(last, digests(files), files).unchanged
    manifest.write(last, {**digests(files), "preview.png": "cd" * 32})
    assert compare_builds(last, digests(files), files, ["preview.png"]).unchanged
    other = {**files, "new.txt": b"x"}
    assert compare_builds(last, digests(other), other, ["preview.png"]).files == ("new: new.txt",)


def test_differences_are_those_of_linkwright_diff(last, files):
    def heavier(robot):
        robot["links"][0]["mass"] *= 2
        robot["joints"][1]["dofs"][0]["limits"] = [-1.0, 1.0]

    def all_parts(robot):
        for part in (part for link in robot["links"] for part in link["parts"]):
            part["mass"] += 1.0

    new = changed_robot(files, heavier)
    changes = compare_builds(last, digests(new), new)
    both = [json.loads(entry["robot.json"]) for entry in (files, new)]
    assert len(changes.robot) == len(compare(*both)) == 2
    for said in ("link base_plate", "mass 1.4374 → 2.87479 kg (+100 %)", "joint shoulder_yaw", "lower limit"):
        assert said in text(changes)
    assert changes.files == ("other content: robot.json",)
    new = changed_robot(files, all_parts)
    changes = compare_builds(last, digests(new), new)
    assert (len(changes.robot), changes.more) == (MAX_ROBOT_CHANGES, 28 - MAX_ROBOT_CHANGES)
    assert f"and {28 - MAX_ROBOT_CHANGES} more differences" in text(changes)


def test_checks_that_changed_their_verdict_are_named(last, files):
    names = {"a.xml: mass": True, "a.xml: reach": False, "a.xml: runs": True, "a.xml: gone": False}
    report = {"checks": [{"name": name, "passed": passed} for name, passed in names.items()]}
    (last / "report.json").write_text(json.dumps(report))
    now = {"a.xml: mass": False, "a.xml: reach": True, "a.xml: runs": True, "a.xml: new": False}
    checks = [Check(name, passed, "") for name, passed in now.items()]
    new = changed_robot(files, lambda robot: robot.update(mass=1.0))
    changed_files = compare_builds(last, digests(new), new, checks=checks).files
    assert changed_files[:2] == ("no longer passed: a.xml: mass", "passed again: a.xml: reach")
    assert compare_builds(last, digests(files), files, checks=checks).unchanged
    (last / "report.json").write_text("[]")
    assert compare_builds(last, digests(new), new, checks=checks).files == changed_files[2:]


def test_files_that_came_went_and_differ_are_named(last, files):
    new = {"robot.json": files["robot.json"], "scene.xml": b"<a/>", "sample.usda": b"", "assets/a.stl": b""}
    changed_files = compare_builds(last, digests(new), new).files
    assert changed_files[0] == "new: sample.usda, 1 file in folders"
    assert changed_files[1].startswith("gone: ")
    assert "sample.urdf" in changed_files[1]
    assert changed_files[2] == "other content: scene.xml"
    assert "The robot is the same; its files are not" in text(compare_builds(last, digests(new), new))


@pytest.mark.parametrize("broken", [b"", b"[]", b"{}", b'{"links": 3}', b'{"name": "x", "links": [1]}'])
def test_a_last_build_that_cannot_be_read_fails_nothing(last, files, broken):
    new = changed_robot(files, lambda robot: robot.update(mass=1.0))
    (last / "robot.json").write_bytes(broken)
    changes = compare_builds(last, digests(new), new)
    assert "cannot be compared" in changes.failure
    assert "cannot be compared" in text(changes)
    assert "is the same;" not in text(changes)
    assert difference(changes) == "the previous build cannot be compared"


def test_names_and_secrets_break_out_nowhere(last, files):
    def renamed(robot):
        robot["links"][0]["parts"][0]["name"] = f"{HOSTILE} s3cr3t-value"
        robot["source"]["document"] = "s3cr3t-value"

    new = changed_robot(files, renamed)
    changes = compare_builds(last, digests(new), new)
    html = changes_section(changes, Secrets({"ONSHAPE_SECRET_KEY": "s3cr3t-value"}))
    assert "<img" not in html
    assert "s3cr3t" not in html
    assert HOSTILE in Reader(html.encode()).text.replace("\n", "")
    assert "document of the source" in text(changes)


def test_a_build_says_it_and_a_failed_build_does_not(tmp_path):
    def built(**more):
        plan = plan_of(
            cache={"dir": str(tmp_path / "cache")}, until="graph", output=str(tmp_path / "out"), **more
        )
        build(plan)
        return Reader((tmp_path / "out.graph" / "report.html").read_bytes()).text

    assert "first build here" in built()
    assert "each of the robot's files is as it was" in built()
    heavier = built(mass={"parts": {"Base plate*": {"mass": 2.0}}})
    assert "Changed since the previous build" in heavier
    assert "link base_plate" in heavier
    with pytest.raises(AssemblyError):
        built(joints={"nosuch": {"damping": 1.0}})
    failed = Reader((tmp_path / "out.failed" / "report.html").read_bytes()).text
    assert "E-GLOB" in failed
    assert "previous build" not in failed
