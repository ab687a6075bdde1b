"""The robots of the gallery pass every check in strict mode, and move as docs/guide/moving.md shows."""

import runpy
import sys

import mujoco
import numpy as np
import pytest

from tests.fake_onshape.gallery import DOCUMENTS
from tests.support.command import called, environment, report_of
from tests.support.places import PROJECT

pytestmark = pytest.mark.slow

EXAMPLES = PROJECT / "docs" / "guide" / "examples"
LINES = 40
"""Most lines of an example."""


@pytest.fixture(scope="module")
def built(tmp_path_factory, shared_cache):
    """Builds robots in strict mode; name → folder."""

    def build(name):
        here = tmp_path_factory.mktemp(name)
        environ = environment(here, seeded=False, LINKWRIGHT_CACHE=str(shared_cache))
        called(here, f"robot={name}", "validate=strict", "page.preview=none", environ=environ, status=0)
        return here / "outputs" / name

    return build


@pytest.fixture
def example(monkeypatch, capsys):
    """Runs an example with a scene; returns its output, and (time, *measure(data)) after each step."""

    def run(name, folder, measure):
        rows, step = [], mujoco.mj_step

        def observed(model, data):
            step(model, data)
            rows.append((data.time, *measure(data)))

        monkeypatch.setattr(mujoco, "mj_step", observed)
        monkeypatch.setattr(sys, "argv", [name, str(folder / "scene.xml")])
        runpy.run_path(str(EXAMPLES / name), run_name="__main__")
        return capsys.readouterr().out, np.array(rows)

    return run


@pytest.mark.parametrize("name", DOCUMENTS)
def test_each_robot_builds_offline_and_passes_every_check(name, built):
    report = report_of(built(name))
    assert report["calls"]["made"] == 0
    assert [check["name"] for check in report["checks"] if not check["passed"]] == []


def test_the_quadruped_trots_two_metres_and_does_not_fall(built, example):
    printed, rows = example(
        "trot.py", built("quadruped"), lambda data: (*data.body("trunk").xpos, data.body("trunk").xmat[8])
    )
    time, x, _, z, upright = rows.T
    assert np.isfinite(rows).all()
    assert time[-1] <= 10.01
    assert x[-1] >= 2.0
    assert float(printed.split()[0]) == pytest.approx(x[-1], abs=0.01)
    assert upright.min() > 0.95, "cosine of its tilt"
    assert np.ptp(z) < 0.05, "how far its height varies [m]"


def test_the_arm_follows_a_circle_within_five_millimetres(built, example):
    printed, rows = example("follow_path.py", built("sample"), lambda data: data.site("tool").xpos)
    time, tool = rows[:, 0], rows[:, 1:]
    centre = tool[0] - (0, 0, 0.05)
    flat = tool[:, 0] - centre[0]
    off = np.hypot(np.hypot(tool[:, 1] - centre[1], tool[:, 2] - centre[2]) - 0.05, flat)
    turned = np.unwrap(np.arctan2(tool[:, 1] - centre[1], tool[:, 2] - centre[2]))
    assert off.max() <= 0.005
    assert turned[-1] == pytest.approx(2 * np.pi, abs=0.1), "all the way round"
    assert float(printed.split()[2]) <= 5.0
    assert time[-1] == pytest.approx(6.0, abs=0.01)


def test_an_example_is_short():
    lengths = {path.name: len(path.read_text().splitlines()) for path in EXAMPLES.glob("*.py")}
    assert lengths
    assert {name: lines for name, lines in lengths.items() if lines > LINES} == {}
