"""`linkwright.build`: the files, the report and the robot; what is written, printed and shown."""

from pathlib import Path

import mujoco
import pytest

import linkwright as package
from linkwright.pipeline.api.building import Build
from linkwright.pipeline.report import Report
from tests.support.command import called, environment, robot_files, tree


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
def test_a_build_in_memory_has_the_files_of_the_command_and_writes_nothing(folder, cache, capfd):
    keys = ("source=sample", "name=arm", "mesh=visual", "export=[urdf,mjcf,ros2,python]", "validate=quick")
    built = package.build(*keys)
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
def test_an_output_folder_is_written_and_progress_shown_if_asked(folder, capfd, more, keys):
    built = package.build("source=sample", "until=graph", *more, progress=True, **keys)
    assert robot_files(folder / "out.graph") == dict(built.files)
    assert built.report.folder == "out.graph"
    out, err = capfd.readouterr()
    assert (out, [line.split()[0] for line in err.splitlines()]) == ("", ["fetch", "graph"])


def test_a_build_that_fails_leaves_nothing(folder):
    (folder / "arm.urdf").write_text("<robot name='arm'><link/></robot>")
    before = tree(folder)
    with pytest.raises(package.SourceError) as caught:
        package.build("source=urdf", "source.path=arm.urdf")
    assert tree(folder) == before
    assert not any("report" in note for note in getattr(caught.value, "__notes__", ()))


def test_a_build_that_ends_before_the_graph_has_no_robot():
    built = package.build("source=sample", "until=fetch")
    assert (dict(built.files), built.outline) == ({}, "")
    with pytest.raises(package.LinkwrightError, match="ended before the graph stage"):
        _ = built.robot


def test_a_notebook_shows_outline_and_picture_with_names_escaped():
    report = Report("built", "<b>arm", "", "graph", 0, outline=("<script>alert(1)</script> & co",))
    shown = Build(report, {"graph.svg": b"<svg onload='x'/>"}, None)._repr_html_()
    assert "&lt;script&gt;alert(1)&lt;/script&gt; &amp; co" in shown
    assert shown.count("<") == len(["<p>", "</p>", "<pre>", "</pre>", "<img>"])
    assert 'src="data:image/svg+xml;base64,' in shown
    bare = Build(Report("built", "arm", "", "fetch", 0), {}, None)
    assert bare._repr_html_() == "<p>arm: built, 0 files</p>"
