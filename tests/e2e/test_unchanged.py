"""An unchanged build is recognised as a whole, and nothing that changed is taken for unchanged."""

import json
import os
import re
import shutil
import sys
from collections.abc import Callable, Mapping
from contextlib import chdir
from hashlib import sha256
from pathlib import Path
from unittest.mock import patch

import pytest

import linkwright.pipeline.run.build
from linkwright.pipeline.caching.maintenance import collect, verify
from linkwright.pipeline.options import parse
from linkwright.pipeline.run import program, unchanged
from linkwright.pipeline.terminal.progress import Quiet
from tests.e2e.test_traps import ROBOT, URDF
from tests.support.command import called, environment, robot_files, run_in
from tests.unit.pipeline.test_cli import HEAVY

pytestmark = pytest.mark.slow

TETRAHEDRON = ("0 0 0", "1 0 0", "0 1 0", "0 0 1")
MOTOR = "title: Strong\nvalues: {effort: {value: 3, source: own, kind: measured}}\n"
MORE = """actuators: {"*": {motor: strong}}
elements: {mount: {into: {tag: worldbody}, formats: [mjcf], file: mount.xml}}
mass: {density: '${oc.env:DENSITY,1000}'}
"""
TIMES = re.compile(rb'(?m)(?<="seconds": )[\d.e-]+|^ +\d+\.\d{3}(?=  )|\b\d+\.\d\d(?= s\b|  | *<)')


def stl(height="1"):
    corners = [*TETRAHEDRON[:3], f"0 0 {height}"]
    faces = ((0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3))
    loops = ("".join(f"vertex {corners[corner]}\n" for corner in face) for face in faces)
    facets = "".join(f"facet normal 0 0 0\nouter loop\n{loop}endloop\nendfacet\n" for loop in loops)
    return f"solid block\n{facets}endsolid block\n"


@pytest.fixture
def here(tmp_path):
    files = {
        "arm.urdf": URDF,
        "parts/block.stl": stl(),
        "robot/arm.yaml": ROBOT + MORE,
        "motors/strong.yaml": MOTOR,
        "mount.xml": "<site name='cam'/>",
    }
    for path, text in files.items():
        (tmp_path / path).parent.mkdir(exist_ok=True)
        (tmp_path / path).write_text(text)
    return tmp_path


@pytest.fixture
def builds(monkeypatch):
    """The names of the robots whose builds ran their stages."""
    names: list[str] = []
    build_files = linkwright.pipeline.run.build.build_files

    def counted(plan, *args, **more):
        names.append(plan.name)
        return build_files(plan, *args, **more)

    monkeypatch.setattr(linkwright.pipeline.run.build, "build_files", counted)
    return names


def build(here, *arguments, **more):
    words = arguments or ("robot=arm", "until=graph")
    return called(here, *words, environ=environment(here, seeded=False, PWD=str(here), **more))


def left_by(here, done):
    """What a build said and left, without its times."""
    (folder,) = (here / "outputs").glob("[!.]*")
    files = {path.name: path.read_bytes() for path in folder.glob("[!.]*") if path.is_file()}
    contents = files | {"status": b"%d" % done.returncode}
    contents |= {"stdout": done.stdout.encode(), "stderr": done.stderr.encode()}
    return {name: TIMES.sub(b"0.0", data) for name, data in contents.items()}


@pytest.mark.parametrize(
    "arguments",
    [
        ("robot=arm", "until=graph"),
        ("robot=arm", "validate=strict"),
        ("source=sample", "mesh=visual", "export=[urdf,mjcf,sdf]"),
        ("robot=arm", "page.live=shared"),
    ],
    ids=" ".join,
)
def test_a_recognised_build_leaves_what_a_cached_build_leaves(here, builds, monkeypatch, arguments):
    page = {"LINKWRIGHT_PAGE": "whole"} if "page.live=shared" in arguments else {}
    build(here, *arguments, **page)
    with monkeypatch.context() as without:
        without.setattr(unchanged, "reuse", lambda *_: None)
        cached = left_by(here, build(here, *arguments, **page))
    assert left_by(here, again := build(here, *arguments, **page)) == cached
    assert again.returncode == (3 if "validate=strict" in arguments else 0)
    assert len(builds) == 2


def test_it_imports_neither_the_composer_nor_the_schema(here):
    heavy = [*HEAVY, "antlr4", "httpx"]
    code = (
        "import sys; from linkwright.pipeline.cli import main; status = main(['robot=arm', 'until=graph']); "
        f"print(status, sorted(set({heavy!r}) & set(sys.modules)), file=sys.stderr)"
    )
    environ = environment(here, seeded=False)
    _, again = (run_in(here, sys.executable, "-c", code, environ=environ) for _ in range(2))
    assert again.stderr.splitlines()[-1] == "0 []", again.stderr


def rewritten(path, text):
    return lambda here: ((here / path).parent.mkdir(exist_ok=True), (here / path).write_text(text))


CHANGES: Mapping[str, Callable[[Path], object]] = {
    "the robot's file": rewritten("robot/arm.yaml", f"{ROBOT}{MORE}# a remark\n"),
    "the source": rewritten("arm.urdf", URDF.replace('mass value="1"', 'mass value="2"')),
    "a mesh": rewritten("parts/block.stl", stl("2")),
    "a motor": rewritten("motors/strong.yaml", MOTOR.replace("3", "4")),
    "a file of elements": rewritten("mount.xml", "<site name='other'/>"),
    "an option of the user": rewritten("mesh/hull.yaml", "collider: hull\n"),
    "an experiment": rewritten("experiment/wide.yaml", "# @package _global_\n"),
    "a new .env": rewritten(".env", "ONSHAPE_ACCESS_KEY=another-key-of-mine\n"),
    "a mesh that is gone": lambda here: (here / "parts/block.stl").unlink(),
    "the folder of the output": lambda here: shutil.rmtree(here / "outputs"),
    "the cache": lambda here: shutil.rmtree(here / "cache"),
    "a link in place of a file": lambda here: (
        (here / "robot/arm.yaml").rename(here / "arm.yaml"),
        (here / "robot/arm.yaml").symlink_to(here / "arm.yaml"),
    ),
}


@pytest.mark.parametrize("change", CHANGES)
def test_a_change_of_any_file_is_noticed(here, builds, change):
    build(here, "robot=arm", "until=export")
    assert build(here, "robot=arm", "until=export").returncode == 0
    assert builds == ["arm"]
    CHANGES[change](here)
    build(here, "robot=arm", "until=export")
    assert len(builds) == 2


@pytest.mark.parametrize("name", ["DENSITY", "LINKWRIGHT_TRUST", "LINKWRIGHT_HOST", "ONSHAPE_SECRET_KEY"])
def test_a_change_of_a_variable_is_noticed(here, builds, name):
    build(here)
    build(here, NOBODY_READS="7")
    assert builds == ["arm"]
    build(here, **{name: "1200"})
    build(here, **{name: "1200"})
    assert builds == ["arm", "arm"]
    build(here, **{name: "1300"})
    assert len(builds) == 3


def test_another_command_is_another_build(here, builds):
    for words in (["robot=arm"], ["robot=arm", "root=fixed"], ["--config-dir", ".", "robot=arm"]):
        build(here, *words, "until=graph")
        build(here, *words, "until=graph")
    assert len(builds) == 3
    other = here / "other"
    shutil.copytree(here, other, ignore=shutil.ignore_patterns("outputs", "cache"))
    called(other, "robot=arm", "until=graph", environ=environment(here, seeded=False))
    assert len(builds) == 4
    # Another cache has a record of its own.
    words = ("robot=arm", "until=graph", "cache.dir=mine/cache")
    for count in (5, 5, 6):
        if count == 6:
            shutil.rmtree(here / "mine")
        build(here, *words)
        assert len(builds) == count


def test_a_change_of_the_program_or_of_a_library_is_noticed(here, builds, monkeypatch, tmp_path_factory):
    def noticed(count):
        build(here)
        build(here)
        assert len(builds) == count

    noticed(1)
    libraries = tmp_path_factory.mktemp("libraries")
    (libraries / "numpy-99.0.dist-info").mkdir()
    monkeypatch.setattr(sys, "path", [*sys.path, str(libraries)])
    noticed(2)
    (libraries / "numpy-99.0.dist-info").rename(libraries / "numpy-99.1.dist-info")
    noticed(3)
    code = tmp_path_factory.mktemp("code")
    for room in program.ROOMS:
        (code / room).mkdir()
        (code / room / "__init__.py").write_text("")
    monkeypatch.setattr(program, "__file__", str(code / "pipeline" / "run" / "program.py"))
    noticed(4)
    (code / "stages" / "__init__.py").write_text("VERSION = 2\n")
    noticed(5)


@pytest.mark.parametrize(
    "word",
    ["cache.mode=refresh", "cache.mode=bypass", "plugins=[json]", "name=a_${now:%Y}", "cache.dir='c d'"],
)
def test_a_build_that_is_not_known_by_its_answers_always_runs(here, builds, word):
    for _ in range(2):
        assert build(here, "robot=arm", "until=graph", word).returncode == 0
    assert len(builds) == 2


def test_the_files_of_the_user_are_kept_and_stop_it_as_ever(here, builds):
    build(here)
    folder = here / "outputs" / "arm.graph"
    (folder / "NOTES.md").write_text("mine")
    kept = build(here)
    assert "kept, since not linkwright's: NOTES.md" in kept.stderr
    assert (folder / "NOTES.md").read_text() == "mine"
    (folder / "report.html").unlink()
    assert build(here).returncode == 0
    assert (folder / "report.html").is_file()
    assert builds == ["arm"]
    (folder / "robot.json").write_text("{}")
    stopped = build(here)
    assert stopped.returncode == 2
    assert "robot.json was changed since it was built" in stopped.stderr
    assert (folder / "robot.json").read_text() == "{}"


def test_what_it_needs_is_in_the_cache_and_counts_as_used(here, builds):
    build(here, "robot=arm", "until=export")
    cache = here / "cache"
    assert verify(cache).records == 0
    old = 10_000.0

    def age():
        for path in (*cache.glob("ac/*/*"), *cache.glob("cas/*/*")):
            os.utime(path, (old, old))

    age()
    build(here, "robot=arm", "until=export")
    used = [path for path in cache.glob("ac/*/*") if path.stat().st_mtime > old]
    stages = {json.loads(path.read_bytes())["stage"] for path in used}
    assert stages == {"build", "fetch", "graph", "mesh", "export"}
    age()
    collect(cache, 0)
    build(here, "robot=arm", "until=export")
    assert builds == ["arm", "arm"]


def record_of(here):
    """The files of the build's record: that of the action, and the blob that says what is kept."""
    with_stage = {path: json.loads(path.read_bytes()) for path in (here / "cache").glob("ac/*/*.json")}
    path, record = next((path, record) for path, record in with_stage.items() if record["stage"] == "build")
    digest = record["outputs"]["record.json"]
    return path, here / "cache" / "cas" / digest[:2] / digest


def replace_record(here, text):
    """Makes `text` what is kept, with a digest that is right: who can write to a cache can do so."""
    path, blob = record_of(here)
    digest = sha256(text).hexdigest()
    place = blob.parents[1] / digest[:2] / digest
    place.parent.mkdir(exist_ok=True)
    place.write_bytes(text)
    record = json.loads(path.read_bytes())
    record["outputs"]["record.json"], record["sizes"]["record.json"] = digest, len(text)
    path.write_text(json.dumps(record))


def mutations(tree, values=(None, 3, "x", [], {}, [["x"]])):
    """Copies of a record, in each of which one of its values is another."""
    trees = []
    for name in tree:
        trees += [{**tree, name: value} for value in values]
        trees.append({key: value for key, value in tree.items() if key != name})
    return trees


def recognised(here):
    """Whether the build is recognised, as the command asks."""
    command = parse(["robot=arm", "until=graph"])
    environ = environment(here, seeded=False, PWD=str(here))
    with chdir(here), patch.dict(os.environ, environ, clear=True):
        return unchanged.reuse(unchanged.action_of(command), command, Quiet()) is not None


def test_a_damaged_or_hostile_record_never_makes_another_robot(here, builds):
    build(here)
    folder = here / "outputs" / "arm.graph"
    right, files = json.loads(record_of(here)[1].read_bytes()), robot_files(folder)
    assert recognised(here)
    outside = {**right["report"], "outputs": {"../x": "0"}}
    for tree in (*mutations(right), [], 3, {**right, "report": outside}):
        replace_record(here, json.dumps(tree).encode())
        recognised(here)
        assert robot_files(folder) == files
        assert sorted(path.name for path in here.iterdir() if path.is_dir()) == [
            "cache", "motors", "outputs", "parts", "robot",
        ]  # fmt: skip
        assert sorted(path.name for path in (here / "outputs").iterdir()) == [".linkwright", "arm.graph"]
    done = build(here)
    assert done.returncode == 0, done.stderr
    assert builds == ["arm", "arm"]


def test_a_record_that_names_another_folder_touches_nothing_there(here):
    build(here)
    (here / "mine").mkdir()
    (here / "mine" / "thesis.tex").write_text("mine")
    right = json.loads(record_of(here)[1].read_bytes())
    for folder in ("mine", str(here), "new", "~", "/"):
        replace_record(here, json.dumps({**right, "folder": folder, "suffix": ""}).encode())
        assert not recognised(here)
    assert [path.name for path in (here / "mine").iterdir()] == ["thesis.tex"]
    assert not (here / "new").exists()


def test_no_key_is_in_the_record(here):
    build(here, ONSHAPE_ACCESS_KEY="a-very-secret-key", DENSITY="1234.5")
    assert unchanged.action_of(parse([])).key
    for path in (here / "cache").rglob("*"):
        if path.is_file():
            assert b"a-very-secret-key" not in path.read_bytes()
