"""`linkwright diff`: every difference of two robots is told, and none that is none."""

import copy
import json
import math
import re
import subprocess

import pytest

from linkwright.pipeline.changes.compare import compare
from linkwright.pipeline.cli import run
from linkwright.stages.robot.model.geom_form import ContactProperties
from linkwright.stages.robot.model.geometry import Exclude, Geometry, Shape, Touch
from linkwright.stages.robot.model.robot import Primitive
from tests.fake_onshape.sample import sample_document
from tests.support.building import plan_of, robot_of, write
from tests.support.robots import at

SENSORS = {"imu": {"frame": "tool", "type": "imu"}, "eye": {"frame": "tool", "type": "camera"}}

APART = ("source", "cad", "provenance", "unset", "estimated", "format", "version", "world")
"""What says where the robot comes from, what is read before the comparison, and where a part stands in the
assembly, which follows from the pose in its link and the saved values."""


BALL = Primitive("sphere", (0.01,), at(0.0, 0.0, 0.02), (0.1, 0.2, 0.3, 1.0))
HOLD = ContactProperties(friction=(1.0, 0.01, 0.0001), solref=(0.01, 1.0), condim=4, margin=0.001)
GEOMETRY = Geometry(
    (Shape("palm", "collision", None, None, 0, 0, 0.001, 4e-6, BALL, HOLD, None, 0),
     Shape("palm", "visual", None, (0.1, 0.2, 0.3, 1.0), 0, 0, 0.001, 4e-6, BALL),
     Shape("turret", "collision", None, None, 0, 0, 0.001, 4e-6, BALL),
     Shape("forearm", "collision", None, None, 0, 0, 0.001, 4e-6, BALL)),
    {},
    self_contact=True,
    excludes=(
        Exclude("turret", "forearm", "User", 0.0),
        Exclude("forearm", "palm", "Adjacent", 0.001, ((0, 0),)),
    ),
    touching=(Touch("turret", "palm", 0.002),),
)  # fmt: skip


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The sample with servos and sensors, exported."""
    here = tmp_path_factory.mktemp("diff") / "outputs" / "sample"
    plan = plan_of(sensors=SENSORS, actuators={"*": "position"}, keyframes={"up": {"lift": 0.03}})
    write(robot_of(sample_document(), plan), here, plan, GEOMETRY)
    return here


@pytest.fixture
def robot(folder):
    return json.loads((folder / "robot.json").read_text())


def row(robot, table, name):
    return next(entry for entry in robot[table] if entry["name"] == name)


def saved(robot, file):
    file.write_text(json.dumps(robot))
    return str(file)


def said(before, after):
    return [
        f"{difference.section} {difference.name} {difference.kind} {difference.text}"
        for difference in compare(before, after)
    ]


def leaves(value, path=()):
    """The paths of all values of a table that have none in them."""
    pairs = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, item in pairs:
        if key not in APART:
            yield from leaves(item, (*path, key))
    if not isinstance(value, dict | list):
        yield path


def other_than(value):
    if isinstance(value, bool):
        return not value
    if isinstance(value, int | float):
        return value + 0.37
    return "another" if value is None else f"{value}_2"


@pytest.mark.slow
def test_no_change_of_any_value_is_lost(robot):
    """Each value of robot.json in its turn, but those that only say where it comes from."""
    paths = [path for path in leaves(robot) if path[0] != "order"]
    assert len(paths) > 500
    changed = copy.deepcopy(robot)
    for path in paths:
        above = changed
        for key in path[:-1]:
            above = above[key]
        if path[-2:-1] == ("quat",) and sum(map(bool, above)) == 1 and above[path[-1]]:
            continue  # longer, it is the same orientation
        kept = above[path[-1]]
        above[path[-1]] = other_than(kept)
        assert compare(robot, changed), path
        above[path[-1]] = kept


def test_every_row_that_is_taken_out_is_told_by_its_name(robot):
    tables = [key for key, rows in robot.items() if isinstance(rows, list) and key != "files"]
    assert {"links", "joints", "loops", "relations", "frames", "actuators", "sensors"} <= set(tables)
    assert {"armatures", "keyframes", "shapes", "excludes", "touching"} <= set(tables)
    for table in tables:
        for index, element in enumerate(robot[table]):
            less = copy.deepcopy(robot)
            del less[table][index]
            name = (
                element.get("name") or element.get("follower") or element.get("dof") or element.get("joint")
            )
            name = name or " ".join(str(element[key]) for key in ("link", "role", "number") if key in element)
            name = name or f"{element['link_a']} and {element['link_b']}"
            for kind, pair in (("removed", (robot, less)), ("added", (less, robot))):
                changes = [change for change in compare(*pair) if change.section == table]
                assert {change.kind for change in changes if change.name == name} == {kind}, (table, name)


def test_robot_equals_itself_despite_rounding(robot):
    def shaken(value):
        if isinstance(value, float):
            return value * (1 + 1e-12)
        if isinstance(value, dict):
            return {key: shaken(item) for key, item in value.items()}
        return [shaken(item) for item in value] if isinstance(value, list) else value

    assert compare(robot, copy.deepcopy(robot)) == ()
    assert compare(robot, shaken(robot)) == ()
    turned = copy.deepcopy(robot)
    for joint in turned["joints"]:
        joint["origin"]["quat"] = [-part for part in joint["origin"]["quat"]]
    assert compare(robot, turned) == ()


def test_where_a_robot_comes_from_is_shown_but_is_no_difference(robot, tmp_path, capsys):
    later = copy.deepcopy(robot)
    later["source"]["microversion"] = "b" * 24
    first, other = saved(robot, tmp_path / "a.json"), saved(later, tmp_path / "b.json")
    assert run(["diff", first, other]) == 0
    out = capsys.readouterr().out
    assert f"microversion of the source: {robot['source']['microversion']} → {'b' * 24}" in out
    assert out.endswith("the same robot\n")


def test_changes_are_said_in_the_units_of_the_field(robot):
    after = copy.deepcopy(robot)
    row(after, "links", "forearm")["mass"] *= 1.25
    row(after, "links", "forearm")["com"][0] += 0.0032
    elbow = row(after, "joints", "elbow")
    elbow["dofs"][0]["limits"][1] = 1.9
    elbow["dofs"][0]["axis"] = [0.0, math.sin(0.5), math.cos(0.5)]
    elbow["origin"]["xyz"][1] += 0.012
    half = math.radians(3) / 2
    elbow["origin"]["quat"] = [math.cos(half), math.sin(half), 0.0, 0.0]
    row(after, "joints", "lift")["dofs"][0]["damping"] = 7.0
    before = row(robot, "joints", "elbow")
    assert before["origin"]["quat"] == [1.0, 0.0, 0.0, 0.0]
    assert before["dofs"][0]["axis"] == [0.0, 0.0, 1.0]
    text = "\n".join(said(robot, after))
    mass = row(robot, "links", "forearm")["mass"]
    assert f"mass {mass:.6g} → {1.25 * mass:.6g} kg (+25 %)" in text
    assert "center of mass moved by 3.2 mm" in text
    assert f"upper limit {before['dofs'][0]['limits'][1]:.6g} → 1.9 rad" in text
    assert "lower limit" not in text
    assert f"axis turned by {math.degrees(0.5):.3g} deg" in text
    assert "origin moved by 12 mm, turned by 3 deg" in text
    assert re.search(r"damping \S+ → 7 N s/m", text)


def test_renamed_links_and_moved_parts_are_recognised(robot):
    """And no joint, loop, part or actuator that names it is another for that."""
    text = json.dumps(robot).replace('"forearm"', '"lower_arm"').replace('"elbow"', '"my_elbow"')
    renamed = ["links lower_arm renamed was forearm", "joints my_elbow renamed was elbow"]
    assert said(robot, json.loads(text)) == renamed
    after = copy.deepcopy(robot)
    part = row(after, "links", "lift_column")["parts"].pop(1)
    row(after, "links", "turret")["parts"].append(part)
    assert said(robot, after) == ["parts Turntable <1> changed went from lift_column to turret"]


def test_what_is_new_of_shapes_and_poses_is_said_in_words(robot):
    after = copy.deepcopy(robot)
    after["shapes"][0]["area"] *= 1.5
    after["shapes"][0]["volume"] *= 1 + 1e-6  # of meshes in single precision
    after["shapes"][0]["primitive"]["pose"]["xyz"][0] += 0.001
    after["shapes"][1]["file"] = "palm.stl"
    up = next(keyframe for keyframe in after["keyframes"] if keyframe["name"] == "up")
    up["given"]["lift"], up["values"]["lift"] = 0.05, 0.05
    row(after, "loops", "rod_upper_pivot")["lever"] *= 2
    del after["excludes"][1]
    after["files"] = [*after["files"][1:], "robot.sdf"]
    text = "\n".join(said(robot, after))
    assert "shapes palm collision 0 changed area 0.001 → 0.0015 m²" in text
    assert "volume" not in text
    assert "shapes palm collision 0 changed primitive.pose moved by 1 mm" in text
    assert "shapes palm visual 0 changed file none → palm.stl" in text
    assert "keyframes up changed given value of lift 0.03 → 0.05" in text
    assert "keyframes up changed value of lift 0.03 → 0.05" in text
    assert "loops rod_upper_pivot changed lever" in text
    assert "excludes forearm and palm removed 1 mm deep at home" in text
    assert f"files: removed {robot['files'][0]}; added robot.sdf" in text
    assert len(said(robot, after)) == 8


def test_another_order_of_the_arrays_is_a_difference(robot):
    after = copy.deepcopy(robot)
    after["order"]["mjcf"]["actuators"].reverse()
    (text,) = said(robot, after)
    names = [actuator["name"] for actuator in robot["order"]["mjcf"]["actuators"]]
    assert f"{', '.join(names)} → {', '.join(reversed(names))}" in text


def test_changed_orders_are_listed_in_the_order_of_robot_json(robot):
    tables = robot["order"]["mjcf"]
    robot["order"], after = {}, copy.deepcopy(robot)
    for file in "hgfedcba":
        robot["order"][file] = tables
        after["order"][file] = {**tables, "actuators": tables["actuators"][::-1]}
    assert "".join(change.name for change in compare(robot, after)) == "hgfedcba"


def test_text_says_that_only_robot_json_is_compared(folder, robot, tmp_path, capsys):
    file = str(saved(robot, tmp_path / "one.json"))
    for places, shown in (((folder, folder), True), ((folder, file), True), ((file, file), False)):
        run(["diff", *map(str, places)])
        assert ("only robot.json of a folder is compared" in capsys.readouterr().out) == shown
    run(["diff", "--json", str(folder), str(folder)])
    assert "only" not in json.loads(capsys.readouterr().out)


def test_the_exit_status_says_how_it_ended(folder, robot, tmp_path, capsys):
    robot["total_mass"] = 7.0
    other = saved(robot, tmp_path / "other.json")
    assert run(["diff", str(folder), str(folder / "robot.json")]) == 0
    assert run(["diff", str(folder), other]) == 3
    capsys.readouterr()
    for name, text in {
        "list": "[]",
        "version": '{"format": "linkwright-robot", "version": 2}',
        "empty": '{"format": "linkwright-robot", "version": 1, "name": "x"}',
        "nul": "\x00",
    }.items():
        (tmp_path / name).write_text(text)
    for arguments, status, message in (
        ([folder], 2, "expected two robots, got 1"),
        (["--yaml", folder, other], 2, "there is no option --yaml"),
        (["--json", "--markdown", folder, other], 2, "exclude each other"),
        ([folder, tmp_path / "nothing"], 1, "no such file or folder"),
        ([folder, tmp_path], 1, "the folder has no robot.json"),
        ([folder, folder / "robot.urdf"], 1, "it is not JSON"),
        ([folder, "--", other], 2, "there is no option --"),
        ([folder, tmp_path / "list"], 1, "it is not a robot.json of Linkwright"),
        ([folder, tmp_path / "version"], 1, "its version is 2"),
        ([folder, tmp_path / "empty"], 1, "it has no links and no joints"),
        ([folder, tmp_path / "nul"], 1, "it is not JSON"),
    ):
        assert run(["diff", *map(str, arguments)]) == status, arguments
        assert message in capsys.readouterr().err, arguments


def git(folder, *words):
    command = ["git", "-c", "user.name=a", "-c", "user.email=a@b.c", *words]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=True).stdout.strip()


@pytest.fixture
def repository(folder, tmp_path):
    """A repository with the robot in `robots/arm`."""
    top = tmp_path / "repository"
    (top / "robots" / "arm").mkdir(parents=True)
    (top / "robots" / "arm" / "robot.json").write_bytes((folder / "robot.json").read_bytes())
    (top / ".gitattributes").write_text("*.json filter=trap diff=trap\n")
    git(top, "init", "-q")
    git(top, "add", ".")
    git(top, "commit", "-q", "-m", "one")
    return top


def test_a_revision_of_git_is_a_robot_too(repository, robot, monkeypatch, capsys):
    """By its path from the folder of the repository, and from here; a folder or a file."""
    robot["name"] = "arm"
    saved(robot, repository / "robots" / "arm" / "robot.json")
    for here, after, places in (
        (repository, "robots/arm", ("HEAD:robots/arm", "HEAD:robots/arm/robot.json", "HEAD:./robots/arm")),
        (repository / "robots", "arm", ("HEAD:arm", "HEAD:robots/arm", "HEAD:./arm/robot.json")),
        (repository / "robots" / "arm", ".", ("HEAD:.",)),
    ):
        monkeypatch.chdir(here)
        for before in places:
            assert run(["diff", before, after]) == 3
            assert "name robot → arm" in capsys.readouterr().out
    for wrong in ("HEAD:robots/leg", "nowhere:robots/arm", "HEAD:robots"):
        assert run(["diff", wrong, "."]) == 1
        assert "git has no robot there" in capsys.readouterr().err
    assert run(["diff", "--output=x:robots/arm", "."]) == 2


def test_git_runs_nothing_that_a_repository_names(repository, tmp_path, monkeypatch, capsys):
    """Not the helper of a remote that promises a missing file, no hook, filter, text converter or pager."""
    marks = tmp_path / "marks"
    marks.mkdir()
    blob = git(repository, "rev-parse", "HEAD:robots/arm/robot.json")
    for key, mark in {
        "remote.origin.url": "ext::sh -c {}", "filter.trap.smudge": "{}", "filter.trap.clean": "{}",
        "diff.trap.textconv": "{}", "diff.trap.command": "{}", "core.pager": "{}", "core.fsmonitor": "{}",
        "core.sshCommand": "{}", "credential.helper": "!{}", "alias.cat-file": "!{}",
    }.items():  # fmt: skip
        trap = f"touch {marks / key}"
        git(repository, "config", key, mark.format(trap.replace(" ", "% ") if "ext::" in mark else trap))
    for key, value in {
        "core.repositoryFormatVersion": "1", "extensions.partialClone": "origin",
        "remote.origin.promisor": "true", "protocol.ext.allow": "always",
    }.items():  # fmt: skip
        git(repository, "config", key, value)
    for hook in ("post-index-change", "reference-transaction", "post-checkout"):
        (repository / ".git" / "hooks" / hook).write_text(f"#!/bin/sh\ntouch {marks / hook}\n")
        (repository / ".git" / "hooks" / hook).chmod(0o755)
    monkeypatch.chdir(repository)
    assert run(["diff", "HEAD:robots/arm", "robots/arm"]) == 0
    (repository / ".git" / "objects" / blob[:2] / blob[2:]).unlink()
    assert run(["diff", "HEAD:robots/arm", "robots/arm"]) == 1
    assert "git has no robot there" in capsys.readouterr().err
    assert list(marks.iterdir()) == []


def test_programs_get_the_values(folder, robot, tmp_path, capsys):
    before = row(robot, "links", "palm")["mass"]
    row(robot, "links", "palm")["mass"] = 1.0
    assert run(["diff", "--json", str(folder), saved(robot, tmp_path / "b.json")]) == 3
    table = json.loads(capsys.readouterr().out)
    (change,) = table["changes"]
    assert (table["format"], table["alike"]) == ("linkwright-diff", False)
    assert (change["section"], change["name"], change["field"]) == ("links", "palm", "mass")
    assert (change["before"], change["after"]) == (before, 1.0)


def test_hostile_names_do_no_harm(robot, tmp_path, capsys):
    after = copy.deepcopy(robot)
    row(after, "links", "palm")["name"] = "a|b\n| `x` <img src=x> \x1b[31m"
    row(after, "links", "a|b\n| `x` <img src=x> \x1b[31m")["parts"] = []
    first, other = saved(robot, tmp_path / "a.json"), saved(after, tmp_path / "b.json")
    assert run(["diff", first, other]) == 3
    assert "\x1b" not in capsys.readouterr().out
    assert run(["diff", "--markdown", first, other]) == 3
    out = capsys.readouterr().out
    assert "\x1b" not in out
    assert "<img" not in out
    rows = [line for line in out.splitlines() if "img" in line]
    assert rows
    for line in rows:
        assert len(re.findall(r"(?<!\\)\|", line)) == 3, line
