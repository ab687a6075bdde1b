"""`linkwright view`: MuJoCo's viewer with the scene of a build."""

import json
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest

from linkwright.pipeline.errors import ConfigError, OutputError
from linkwright.pipeline.output.manifest import REPORT_KEY
from linkwright.pipeline.verbs import view
from tests.fake_onshape.sample import sample_document
from tests.support.building import plan_of, robot_of, write
from tests.support.command import COMMAND, environment

SHOWN = {"DISPLAY": ":7"}


@pytest.fixture
def built(tmp_path, monkeypatch):
    """The working folder, with the sample in `outputs/arm`, as a build leaves it."""
    folder = tmp_path / "outputs" / "arm"
    write(robot_of(sample_document()), folder, plan_of())
    (folder / "report.json").write_text(json.dumps({REPORT_KEY: 1}))
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def windows(monkeypatch):
    """What was opened, in place of windows."""
    import mujoco.viewer

    opened = []
    monkeypatch.setattr(mujoco.viewer, "launch", lambda model, data: opened.append((model, data)))
    return opened


def test_the_robot_is_opened_at_home(built, windows):
    assert view.run(["arm"], SHOWN, "linux") == 0
    assert view.run(["outputs/arm"], {"WAYLAND_DISPLAY": "wayland-0"}, "linux") == 0
    assert view.run(["arm"], {}, "win32") == 0
    for model, data in windows:
        assert data.qpos.tolist() == model.key("home").qpos.tolist()
        assert data.qpos.any()
        assert model.body("palm").id > 0
    scene = "<mujoco><worldbody><body><geom size='1'/></body></worldbody></mujoco>"
    (built / "outputs/arm/scene.xml").write_text(scene)
    assert view.run(["arm"], SHOWN, "linux") == 0
    assert len(windows) == 4, "one without home is opened as it is"


def test_page_or_package_is_named_without_a_window(built, windows, monkeypatch):
    import mujoco.viewer

    def refuse(*_):
        raise mujoco.FatalError("could not initialize GLFW")

    def refused(environ, message, hint):
        with pytest.raises(OutputError, match=message) as error:
            view.run(["arm"], environ, "linux")
        assert hint in str(error.value.hint)

    refused({"DISPLAY": ""}, "there is no display", "outputs/arm/report.html")
    assert windows == []
    monkeypatch.setattr(mujoco.viewer, "launch", refuse)
    refused(SHOWN, "could not initialize GLFW", "report.html")
    monkeypatch.setitem(sys.modules, "mujoco.viewer", None)
    refused(SHOWN, "viewer is not installed", "pip install mujoco")


def test_a_mac_runs_it_by_mjpython(built, windows, monkeypatch, tmp_path):
    """The stand-in for mjpython is a Python that runs what it is told and leaves a mark."""
    bin_ = tmp_path / "bin"
    bin_.mkdir()
    (bin_ / "mjpython").write_text(f'#!/bin/sh\necho "$@" > {tmp_path}/asked\n')
    (bin_ / "mjpython").chmod(0o755)
    monkeypatch.setattr(sys, "executable", str(bin_ / "python"))
    assert view.run(["arm"], {}, "darwin") == 0
    assert (tmp_path / "asked").read_text().strip() == f"-c {view._MJPYTHON_CODE} outputs/arm/scene.xml"
    assert windows == []
    (bin_ / "mjpython").write_text("#!/bin/sh\nexit 7\n")
    assert view.run(["arm"], {}, "darwin") == 1
    (bin_ / "mjpython").unlink()
    monkeypatch.setenv("PATH", str(bin_))
    with pytest.raises(OutputError, match="mjpython is missing"):
        view.run(["arm"], {}, "darwin")


def test_wrong_usage_and_builds_that_are_not_there_are_told(built):
    for arguments in ([], ["arm", "leg"], ["--fast"]):
        with pytest.raises(ConfigError, match="expected one build"):
            view.run(arguments, SHOWN, "linux")
    with pytest.raises(ConfigError, match="there is no build in outputs/leg or leg"):
        view.run(["leg"], SHOWN, "linux")
    (built / "outputs/arm/scene.xml").unlink()
    with pytest.raises(OutputError, match=r"the build has no scene\.xml"):
        view.run(["arm"], SHOWN, "linux")


@pytest.mark.slow
@pytest.mark.skipif(not shutil.which("Xvfb"), reason="there is no Xvfb, a display without a screen")
def test_a_window_stays_open_on_a_real_display(built):
    with subprocess.Popen(["Xvfb", ":97", "-screen", "0", "640x480x24"], stderr=subprocess.DEVNULL) as screen:
        try:
            for _ in range(100):
                if Path("/tmp/.X11-unix/X97").exists():
                    break
                time.sleep(0.1)
            environ = environment(built, seeded=False, DISPLAY=":97")
            with subprocess.Popen([COMMAND, "view", "arm"], cwd=built, env=environ) as viewer:
                time.sleep(8)
                assert viewer.poll() is None
                viewer.kill()
        finally:
            screen.kill()
