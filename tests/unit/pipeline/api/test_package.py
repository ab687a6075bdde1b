"""The package `linkwright`: its names, its imports, and what `linkwright.build` returns, writes and shows."""

from pathlib import Path

import mujoco
import pytest

import linkwright
from linkwright.pipeline import errors
from linkwright.pipeline.api.building import Build
from linkwright.pipeline.report import Report
from tests.support.command import called, environment, robot_files, tree
from tests.support.places import PROJECT, ROOMS
from tests.support.processes import python


@pytest.fixture(scope="module")
def cache(tmp_path_factory):
    return tmp_path_factory.mktemp("cache")


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch, cache):
    here = tmp_path / "here"
    here.mkdir()
    monkeypatch.chdir(here)
    monkeypatch.setenv("LINKWRIGHT_CACHE", str(cache))
    return here


@pytest.mark.e2e
def test_build_in_memory_has_the_files_of_the_command(folder, cache, capfd):
    keys = ("source=sample", "name=arm", "mesh=visual", "export=[urdf,mjcf,ros2,python]", "validate=quick")
    built = linkwright.build(*keys)
    assert capfd.readouterr() == ("", "")
    assert list(folder.iterdir()) == []
    assert (built.report.status, built.report.folder) == ("built", "")
    assert called(folder, *keys, environ=environment(folder, LINKWRIGHT_CACHE=str(cache))).returncode == 0
    assert dict(built.files) == robot_files(folder / "outputs" / "arm")
    assert built.outline.startswith("arm: 11 links, 10 joints")
    passed = f"{sum(check.passed for check in built.report.checks)} of {len(built.report.checks)}"
    assert repr(built) == f"<linkwright.Build arm: built, {passed} checks passed, {len(built.files)} files>"
    for file in ("arm.xml", "scene.xml"):
        model = mujoco.MjModel.from_xml_string(built.files[file].decode(), built.assets)
        assert model.joint("elbow").id >= 0


@pytest.mark.parametrize(
    ("more", "keys"), [((), {"output": Path("out")}), (["output=out"], {})], ids=["argument", "key"]
)
def test_output_and_progress_are_there_if_requested(folder, capfd, more, keys):
    built = linkwright.build("source=sample", "until=graph", *more, progress=True, **keys)
    assert robot_files(folder / "out.graph") == dict(built.files)
    assert built.report.folder == "out.graph"
    out, err = capfd.readouterr()
    assert (out, [line.split()[0] for line in err.splitlines()]) == ("", ["fetch", "graph"])


def test_a_build_that_fails_leaves_nothing(folder):
    (folder / "arm.urdf").write_text("<robot name='arm'><link/></robot>")
    before = tree(folder)
    with pytest.raises(linkwright.SourceError) as caught:
        linkwright.build("source=urdf", "source.path=arm.urdf")
    assert tree(folder) == before
    assert not any("report" in note for note in getattr(caught.value, "__notes__", ()))


def test_a_build_that_ends_before_the_graph_has_no_robot():
    built = linkwright.build("source=sample", "until=fetch")
    assert (dict(built.files), built.outline) == ({}, "")
    with pytest.raises(linkwright.LinkwrightError, match="ended before the graph stage"):
        _ = built.robot


def test_notebook_shows_outline_and_picture_escaped():
    report = Report("built", "<b>arm", "", "graph", 0, outline=("<script>alert(1)</script> & co",))
    shown = Build(report, {"graph.svg": b"<svg onload='x'/>"}, None)._repr_html_()
    assert "&lt;script&gt;alert(1)&lt;/script&gt; &amp; co" in shown
    assert shown.count("<") == len(["<p>", "</p>", "<pre>", "</pre>", "<img>"])
    assert 'src="data:image/svg+xml;base64,' in shown
    bare = Build(Report("built", "arm", "", "fetch", 0), {}, None)
    assert bare._repr_html_() == "<p>arm: built, 0 files</p>"


NAMES = """
AssemblyError AuthError Build CacheError Check CompiledModel ConfigError DecompositionFailed Diagnostic
Disconnected Dof EmptyMesh ExportError Finding Frame InTheWay Joint Link LinkwrightError MeshError MissingMass
NoRoot NotFound Offline OutputError ProtocolError QuotaExhausted RateLimited Report Robot SecretFound
SourceError ValidationFailed __version__ build
"""


def test_the_names_are_these_and_every_error_is_among_them():
    assert Path(linkwright.__file__).with_name("py.typed").is_file()
    assert sorted(linkwright.__all__) == sorted(NAMES.split())
    assert all(getattr(linkwright, name) is not None for name in linkwright.__all__)
    types = {name: value for name, value in vars(errors).items() if isinstance(value, type)}
    assert {name for name, value in types.items() if issubclass(value, Exception)} <= set(NAMES.split())
    with pytest.raises(AttributeError, match="module 'linkwright' has no attribute 'bild'"):
        _ = linkwright.bild


def test_import_loads_the_package_alone(tmp_path):
    code = (
        "import sys; import linkwright; loaded = set(sys.modules); from linkwright import *\n"
        "print({name for name in loaded if name.startswith(('linkwright.', 'numpy', 'yaml'))})\n"
        "print(set(linkwright.__all__) <= set(dir(linkwright)), build is linkwright.build)\n"
    )
    done = python("-c", code, cwd=tmp_path)
    assert done.stdout == "set()\nTrue True\n", done.stderr


def test_rooms_are_imported_by_their_installed_names():
    """Not by those of the folders, and nothing of the public face, which imports the rooms."""
    paths = [path for top in ROOMS for path in PROJECT.joinpath(top).rglob("*.py")]
    assert [path for path in paths if "pipeline.package" in path.read_text(encoding="utf-8")] == []


@pytest.mark.e2e
def test_modules_beside_the_robot_may_have_our_names(tmp_path):
    """A user's project has `conf`, `pipeline` and `stages` of its own: scripts import these, and build."""
    for name in ("conf", "stages"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "__init__.py").write_text(f"MINE = '{name}'\n")
    (tmp_path / "pipeline.py").write_text("MINE = 'pipeline'\n")
    (tmp_path / "script.py").write_text(
        "import conf, linkwright, pipeline, stages\n"
        "robot = linkwright.build('source=sample', 'until=graph').robot\n"
        "print(conf.MINE, pipeline.MINE, stages.MINE, len(robot.links))\n"
    )
    environ = {"HOME": str(tmp_path), "LINKWRIGHT_CACHE": str(tmp_path / "cache")}
    done = python("script.py", cwd=tmp_path, **environ)
    assert done.stdout.startswith("conf pipeline stages 1"), done.stderr
