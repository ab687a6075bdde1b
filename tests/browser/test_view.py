"""The view in a browser, on models of a few lines: what it shows is what MuJoCo computes."""

import mujoco
import numpy as np
import pytest

from tests.browser.models import ALL_JOINTS, FOUR_BAR, SLIDER_CRANK, chain, model_of, small_pack
from tests.browser.words import complaints, slide, word

pytestmark = pytest.mark.slow


def poses(model, qpos):
    data = mujoco.MjData(model)
    data.qpos[:] = qpos
    mujoco.mj_kinematics(model, data)
    return data


def random_qpos(model, random):
    qpos = random.uniform(-1.5, 1.5, model.nq)
    mujoco.mj_normalizeQuat(model, qpos)
    return qpos


def test_it_opens_from_disk_without_a_request_or_a_complaint(browser, page_of):
    page = page_of(small_pack(ALL_JOINTS))
    browser.open(page)
    assert browser.run("return linkwright.info().engine"), word(browser)
    assert complaints(browser) == []
    assert list(browser.requests()) == [page.as_uri()]


def test_poses_are_those_of_mujoco(browser, page_of):
    model = model_of(ALL_JOINTS)
    browser.open(page_of(small_pack(ALL_JOINTS), "none"))
    random = np.random.default_rng(17)
    for _ in range(20):
        qpos = random_qpos(model, random)
        placed = browser.run("return linkwright.kinematics(arguments[0])", qpos.tolist())
        data = poses(model, qpos)
        np.testing.assert_allclose(np.reshape(placed["xpos"], (-1, 3)), data.xpos, atol=1e-9)
        quats = np.reshape(placed["xquat"], (-1, 4))
        np.testing.assert_allclose(np.abs(np.sum(quats * data.xquat, axis=1)), 1, atol=1e-12)


def test_the_scene_shows_the_pose_of_a_slider(browser, page_of):
    model = model_of(ALL_JOINTS)
    browser.open(page_of(small_pack(ALL_JOINTS), "none"))
    qpos, _ = slide(browser, "turn", 1.1)
    assert qpos[model.joint("turn").qposadr[0]] == pytest.approx(1.1)
    assert browser.run("return document.querySelectorAll('.live-slider output')[4].textContent") != ""
    browser.run("linkwright.view.update()")
    data, before = poses(model, qpos), poses(model, model.qpos0)
    for name in ("rail", "tip", "upper"):
        body = model.body(name).id
        drawn = np.reshape(browser.run("return linkwright.matrix(arguments[0])", body), (4, 4)).T
        np.testing.assert_allclose(drawn[:3, :3], data.xmat[body].reshape(3, 3), atol=1e-9)
        np.testing.assert_allclose(drawn[:3, 3], data.xpos[body], atol=1e-9)
    first, last = (state.body("rail").xmat.reshape(3, 3) for state in (before, data))
    turned = first.T @ last
    assert np.arccos((np.trace(turned) - 1) / 2) == pytest.approx(1.1 - 0.4, abs=1e-9)


def test_a_loop_stays_closed_and_a_follower_follows(browser, page_of):
    browser.open(page_of(small_pack(FOUR_BAR), "none"))
    for joint, value in (("crank", 0.6), ("crank", -0.5), ("rocker", 0.2), ("gear", 0.0)):
        browser.run("linkwright.view.reset()")
        data = poses(model_of(FOUR_BAR), browser.run("return linkwright.pose(...arguments)", joint, value))
        assert data.joint(joint).qpos[0] == pytest.approx(value, abs=1e-9)
        np.testing.assert_allclose(data.site("end").xpos, data.site("top").xpos, atol=1e-6)
        rocker = data.joint("rocker").qpos[0]
        gear = 0.2 + 0.1 - 2 * rocker + 0.3 * rocker**2
        assert data.joint("gear").qpos[0] == pytest.approx(gear, abs=1e-6), joint


def test_a_weld_keeps_place_and_turn(browser, page_of):
    browser.open(page_of(small_pack(SLIDER_CRANK), "none"))
    for value in (0.7, -0.7):
        browser.run("linkwright.view.reset()")
        data = poses(
            model_of(SLIDER_CRANK), browser.run("return linkwright.pose('crank', arguments[0])", value)
        )
        end, pin = data.site("end"), data.site("pin")
        assert data.joint("crank").qpos[0] == pytest.approx(value)
        np.testing.assert_allclose(end.xpos, pin.xpos, atol=1e-6)
        np.testing.assert_allclose(end.xmat, pin.xmat, atol=1e-6)
        along = 0.2 * np.sin(value) + np.sqrt(0.5**2 - (0.2 * (1 - np.cos(value))) ** 2)
        assert data.joint("slide").qpos[0] == pytest.approx(along - 0.5, abs=1e-6)


def test_a_ball_turns_about_its_vector_and_no_further_than_its_cone(browser, page_of):
    browser.open(page_of(small_pack(ALL_JOINTS), "none"))
    place = model_of(ALL_JOINTS).joint("shoulder").qposadr[0]
    vector, quat = np.array([0.3, -0.5, 0.2]), np.zeros(4)
    mujoco.mju_axisAngle2Quat(quat, vector / np.linalg.norm(vector), np.linalg.norm(vector))
    qpos = browser.run("return linkwright.pose('shoulder', ...arguments)", *vector)
    np.testing.assert_allclose(qpos[place : place + 4], quat, atol=1e-9)
    for axis in "xyz":
        qpos, _ = slide(browser, f"shoulder {axis}", 1.2)
    assert 2 * np.arccos(qpos[place]) == pytest.approx(1.2, abs=1e-9)


def test_a_joint_goes_only_as_far_as_its_loop_lets_it(browser, page_of):
    """Grashof: the rocker of this four-bar linkage cannot turn round."""
    model = model_of(FOUR_BAR)
    browser.open(page_of(small_pack(FOUR_BAR), "none"))
    data = poses(model, browser.run("return linkwright.pose('rocker', 2.5)"))
    assert data.joint("rocker").qpos[0] < 2.5
    np.testing.assert_allclose(data.site("end").xpos, data.site("top").xpos, atol=1e-6)


def test_the_engine_steps_as_mujoco_does(browser, page_of):
    """The page's engine is older than ours: a swing without contact has one answer."""
    model = model_of(FOUR_BAR)
    browser.open(page_of(small_pack(FOUR_BAR)))
    browser.run("linkwright.view.pause(); linkwright.view.reset()")
    positions = browser.run("return linkwright.step(0.5)")
    data = mujoco.MjData(model)
    for _ in range(500):
        mujoco.mj_step(model, data)
    np.testing.assert_allclose(positions, data.qpos, atol=1e-3)
    assert np.abs(data.qpos - model.qpos0).max() > 0.1


def test_many_links_take_few_draw_calls(browser, page_of):
    browser.open(page_of(small_pack(chain(80)), "none"))
    browser.run(
        "for (const box of document.querySelectorAll('[data-layer]')) if (!box.checked) box.click();"
        "linkwright.view.update(); linkwright.view.stage.render()"
    )
    info = browser.run("return linkwright.info()")
    assert info["triangles"] > 80 * 12
    assert info["calls"] <= 8
