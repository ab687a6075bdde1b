"""The page of the sample as a build writes it, opened from disk."""

import json

import mujoco
import numpy as np
import pytest

from tests.browser.words import complaints, opened, slide, text, word
from tests.support.command import environment, linkwright

pytestmark = pytest.mark.slow

LARGEST = 5e6
"""Bytes of the sample's page."""


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """The folder of a build of the sample, held by its actuators."""
    here = tmp_path_factory.mktemp("sample")
    live = environment(here, LINKWRIGHT_PAGE="whole")
    done = linkwright(here, "source=sample", "actuators=position", "name=arm", environ=live)
    assert done.returncode == 0, done.stderr
    return here / "outputs" / "arm"


@pytest.fixture
def page(browser, built):
    """The page in the browser, as when it is opened."""
    opened(browser, built / "report.html")
    assert word(browser).startswith("Simulating"), word(browser)
    return browser


@pytest.fixture(scope="module")
def model(built):
    return mujoco.MjModel.from_xml_path(str(built / "scene.xml"))


def test_it_opens_from_disk_without_a_request_or_a_complaint(browser, built):
    browser.open(built / "report.html")
    assert complaints(browser) == []
    assert list(browser.requests()) == [(built / "report.html").as_uri()]
    assert (built / "report.html").stat().st_size < LARGEST


def test_it_stays_at_home(page, model):
    """For five seconds, within 0.02 rad (and m), with its loop closed; Python's MuJoCo measures the loop."""
    page.run("linkwright.view.pause(); linkwright.view.reset()")
    home = page.run("return linkwright.qpos()")
    data = mujoco.MjData(model)
    for _ in range(5):
        qpos = page.run("return linkwright.step(1)")
        np.testing.assert_allclose(qpos, home, atol=0.02)
        data.qpos[:] = qpos
        mujoco.mj_kinematics(model, data)
        assert gaps(model, data).max() < 1e-4


def gaps(model, data):
    """How far the sites of each loop are apart [m]."""
    loops = [i for i in range(model.neq) if int(model.eq_type[i]) == int(mujoco.mjtEq.mjEQ_CONNECT)]
    pairs = [(model.eq_obj1id[i], model.eq_obj2id[i]) for i in loops]
    assert pairs
    return np.array([np.linalg.norm(data.site_xpos[a] - data.site_xpos[b]) for a, b in pairs])


POSE = """
linkwright.view.pause();
linkwright.view.reset();
const qpos = linkwright.pose(...arguments);
return [qpos, linkwright.header.bodies.map((_, body) => linkwright.matrix(body))];
"""


def test_every_slider_keeps_the_loop_closed_and_shows_the_pose(page, model):
    data = mujoco.MjData(model)
    for joint in range(model.njnt):
        name = model.joint(joint).name
        low, high = model.jnt_range[joint]
        for share in (0.2, 0.8):
            target = low + share * (high - low)
            qpos, drawn = page.run(POSE, name, target)
            data.qpos[:] = qpos
            mujoco.mj_kinematics(model, data)
            assert gaps(model, data).max() < 1e-6, name
            fingers = [data.joint(f"{side}_finger").qpos[0] for side in ("left", "right")]
            assert sum(fingers) == pytest.approx(0, abs=1e-6)
            np.testing.assert_allclose(np.array(drawn)[:, 12:15], data.xpos, atol=1e-6)


def test_a_slider_turns_the_right_link_by_the_right_angle(page, model):
    """The shoulder's yaw carries the whole arm; the base and the lift stay."""
    page.run("linkwright.view.pause(); linkwright.view.reset()")
    read = "return linkwright.header.bodies.map((_, body) => linkwright.matrix(body))"
    before = [np.reshape(matrix, (4, 4)).T[:3, :3] for matrix in page.run(read)]
    value = page.run("return linkwright.qpos()")[model.joint("shoulder_yaw").qposadr[0]]
    slide(page, "shoulder_yaw", value - 0.7)
    page.run("linkwright.view.update()")
    after = [np.reshape(matrix, (4, 4)).T[:3, :3] for matrix in page.run(read)]
    for name, angle in [("base_plate", 0), ("lift_column", 0), ("turret", 0.7), ("palm", 0.7)]:
        body = model.body(name).id
        turned = after[body] @ before[body].T
        assert np.arctan2(turned[0, 1], turned[0, 0]) == pytest.approx(angle, abs=1e-6), name


def test_links_show_their_parts(page, built):
    robot = json.loads((built / "robot.json").read_text())
    names = page.run("return linkwright.header.links.map((it) => it.name)")
    assert sorted(names) == sorted(link["name"] for link in robot["links"])
    page.run("linkwright.view.pick(linkwright.header.bodies.findIndex((it) => it.name === 'forearm'))")
    card = text(page, ".live-card")
    assert card.startswith("forearm")
    assert "CAD part" in card
    assert "collider" in card


def test_the_whole_report_fits(page):
    for width in (1280, 400):
        page.size(width, 900)
        assert page.run("return document.documentElement.scrollWidth") <= width
