"""The visitor's actions: run, pause, toggles, keyframes, keys, clicks and pulls; and the page's messages."""

import mujoco
import numpy as np
import pytest

from tests.browser.conftest import SIZE, write_page
from tests.browser.models import ALL_JOINTS, CARRIED, FOUR_BAR, HELD, chain, model_of, renamed, small_pack
from tests.browser.words import complaints, opened, shown, slide, text, word

pytestmark = pytest.mark.slow

CLICK = [{"type": "pointerDown", "button": 0}, {"type": "pointerUp", "button": 0}]

HOSTILE = '</script><img src=x onerror="window.broken=1">&amp;\'"'


@pytest.fixture(scope="module")
def held_page(tmp_path_factory):
    return write_page(tmp_path_factory.mktemp("held"), small_pack(HELD))


@pytest.fixture
def held(browser, held_page):
    """The page of an arm that its actuators hold."""
    return opened(browser, held_page)


def at(browser, body):
    """Where a body's centre of mass is on the screen [px]."""
    x, y = browser.run(
        "const {view} = linkwright; view.update(); const p = view.stage.center.clone();"
        "p.fromArray(linkwright.header.bodies[arguments[0]].com)"
        ".applyMatrix4(view.robot.bones[arguments[0]].matrixWorld).project(view.stage.camera);"
        "const b = view.stage.canvas.getBoundingClientRect();"
        "return [b.left + (p.x + 1) / 2 * b.width, b.top + (1 - p.y) / 2 * b.height]",
        body,
    )
    return {"x": round(x), "y": round(y)}


def test_it_runs_at_home_at_once(browser, held_page):
    browser.open(held_page)
    assert word(browser) == "Simulating in MuJoCo 3.14.0"
    assert browser.run("return linkwright.info().running")
    assert text(browser, ".live-toggle span") == "Pause"


def test_less_motion_means_paused(browser, page_of):
    browser.size(*SIZE, still=True)
    browser.open(page_of(small_pack(HELD)))
    assert not browser.run("return linkwright.info().running")
    assert browser.run("return linkwright.info().engine")
    assert "less motion" in word(browser)


def test_a_robot_that_nothing_drives_waits(browser, page_of):
    browser.open(page_of(small_pack(chain(3))))
    assert not browser.run("return linkwright.info().running")
    assert "nothing drives the joints" in word(browser)


def test_space_pauses_and_arrows_turn_the_camera(held):
    before = held.run(
        "document.querySelector('canvas').focus(); return linkwright.view.stage.camera.position"
    )
    held.keys(" ")
    assert word(held) == "Paused"
    held.keys("\ue014\ue014\ue013")
    after = held.run("return linkwright.view.stage.camera.position")
    assert np.hypot(before["x"] - after["x"], before["y"] - after["y"]) > 0.05
    held.keys(" ")
    assert word(held) == "Simulating in MuJoCo 3.14.0"


def test_a_control_moves_its_joint(held):
    joint = model_of(HELD).joint("shoulder").qposadr[0]
    before = held.run("linkwright.view.pause(); return linkwright.qpos()")[joint]
    held.run(
        "const input = document.querySelector('.live-fold .live-slider input');"
        "input.value = 0.5; input.dispatchEvent(new Event('input'))"
    )
    assert text(held, ".live-slider label") == "shoulder"
    after = held.run("return linkwright.step(2)")[joint]
    assert abs(before - 0.2) < 0.02
    assert abs(after - 0.5) < 0.02


def test_a_posed_robot_stays_there_when_it_runs(held):
    posed = held.run("return linkwright.pose('shoulder', 0.6)")
    assert word(held) == "Paused"
    np.testing.assert_allclose(held.run("return linkwright.step(2)"), posed, atol=0.03)


def test_targets_that_are_states_go_along_with_keyframes_and_poses(browser, page_of):
    browser.open(page_of(small_pack(CARRIED)))
    home = model_of(CARRIED).key_qpos[0]
    after = browser.run("linkwright.view.pause(); linkwright.view.reset(); return linkwright.step(2)")
    np.testing.assert_allclose(after, home, atol=0.03)
    posed = browser.run("return linkwright.pose('shoulder', 0.6)")
    np.testing.assert_allclose(browser.run("return linkwright.step(2)"), posed, atol=0.03)


def test_a_ball_is_posed_from_where_it_is_while_it_runs(browser, page_of):
    """A single slider of three: the other two keep their values of the simulation."""
    browser.open(page_of(small_pack(ALL_JOINTS)))
    vector, quat = np.array([0.5, -0.4, 0.3]), np.zeros(4)
    mujoco.mju_axisAngle2Quat(quat, vector / np.linalg.norm(vector), np.linalg.norm(vector))
    place = int(model_of(ALL_JOINTS).joint("shoulder").qposadr[0])
    qpos = browser.run(
        "linkwright.view.pause(); linkwright.view.reset(); linkwright.view.run();"
        "const [place, quat] = arguments; linkwright.view.engine.views.qpos.set(quat, place);"
        "const row = [...document.querySelectorAll('.live-slider')].find((row) =>"
        " row.querySelector('label').textContent === 'shoulder x');"
        "const input = row.querySelector('input'); input.value = 0.2;"
        "input.dispatchEvent(new Event('input')); return linkwright.qpos()",
        place,
        quat.tolist(),
    )
    wanted = np.array([0.2, *vector[1:]])
    turn = np.linalg.norm(wanted)
    expected = [np.cos(turn / 2), *(np.sin(turn / 2) * wanted / turn)]
    np.testing.assert_allclose(qpos[place : place + 4], expected, atol=1e-6)


def test_keyframes_and_reset(held):
    choose = "const s = document.querySelector('select'); s.value = '1'; s.dispatchEvent(new Event('change'))"
    held.run(f"linkwright.view.pause(); {choose}")
    assert held.run("return linkwright.qpos()") == model_of(HELD).key_qpos[1].tolist()
    held.run("document.querySelector('.live-reset').click()")
    assert held.run("return linkwright.qpos()") == model_of(HELD).key_qpos[0].tolist()


@pytest.mark.parametrize("layer", ["visual", "collider", "inertia", "frames", "contacts"])
def test_a_toggle_shows_and_hides(held, layer):
    draw = "linkwright.view.pause(); linkwright.view.update(); linkwright.view.stage.render();"
    read = "return [linkwright.view.layers[arguments[0]].visible, linkwright.info().triangles]"
    on, before = held.run(draw + read, layer)
    click = "document.querySelector(`[data-layer=${arguments[0]}]`).click();"
    changed, after = held.run(click + draw + read, layer)
    assert changed is not on
    assert (after > before) is changed
    assert held.run(click + draw + read, layer) == [on, before]
    assert complaints(held) == []


def test_contacts_are_those_of_mujoco(held):
    model, data = model_of(HELD), mujoco.MjData(model_of(HELD))
    read = "linkwright.view.pause(); linkwright.view.reset(); return linkwright.view.contactsNow()"
    places = sorted(contact[:3] for contact in held.run(read))
    mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_forward(model, data)
    assert len(places) == data.ncon > 0
    np.testing.assert_allclose(places, sorted(data.contact.pos.tolist()), atol=1e-6)


def test_boxes_of_inertia_have_the_bodies_inertia(held):
    model = model_of(HELD)
    for body in range(1, model.nbody):
        box = np.reshape(held.run(f"return linkwright.view.inertia.local[{body}].elements"), (4, 4)).T
        a, b, c = np.linalg.norm(box[:3, :3], axis=0)
        mass = model.body_mass[body]
        inertia = mass / 12 * np.array([b * b + c * c, a * a + c * c, a * a + b * b])
        np.testing.assert_allclose(inertia, model.body_inertia[body], rtol=1e-9)


def test_a_click_picks_a_link_and_another_lets_it_go(held):
    held.run("linkwright.view.pause()")
    held.act({"type": "pointerMove", "duration": 0, **at(held, model_of(HELD).body("forearm").id)}, *CLICK)
    assert (text(held, ".live-card h3"), text(held, ".live-parts")) == ("forearm", "part of forearm0.3 kg")
    box = held.run("return document.querySelector('canvas').getBoundingClientRect().toJSON()")
    corner = {"x": round(box["right"] - 9), "y": round(box["bottom"] - 9)}
    held.act({"type": "pointerMove", "duration": 0, **corner}, *CLICK)
    assert not shown(held, ".live-card")


def test_the_keyboard_shows_where_it_is_and_a_click_draws_no_frame(held):
    held.run("linkwright.view.pause()")
    ring = "return document.activeElement.tagName + document.activeElement.matches(':focus-visible')"
    held.act({"type": "pointerMove", "duration": 0, **at(held, model_of(HELD).body("forearm").id)}, *CLICK)
    assert held.run(ring) == "CANVASfalse"
    held.run("document.activeElement.blur()")
    held.keys("\ue004")
    assert held.run(ring) == "INPUTtrue"


def test_a_link_may_be_chosen_by_its_name(held):
    held.run(
        "const s = document.querySelector('.live-links');"
        "s.value = [...s.options].find((it) => it.text === 'arm').value;"
        "s.dispatchEvent(new Event('change'))"
    )
    assert text(held, ".live-card h3") == "arm"
    names = held.run("return [...document.querySelectorAll('.live-links option')].map((it) => it.text)")
    assert names[1:] == ["block", "post", "arm", "forearm"]
    held.run("document.querySelector('.live-close').click()")
    assert not shown(held, ".live-card")
    assert held.run("return document.querySelector('.live-links').value") == ""


def test_a_pull_moves_a_link_to_the_pointer_until_it_is_let_go(held):
    body = model_of(HELD).body("block").id
    spot = at(held, body)
    rise = (
        "linkwright.step(arguments[1]); linkwright.view.update(); return linkwright.matrix(arguments[0])[14]"
    )
    held.act(
        {"type": "pointerMove", "duration": 0, **spot},
        {"type": "pointerDown", "button": 0},
        {"type": "pointerMove", "duration": 100, "x": spot["x"], "y": spot["y"] - 120},
    )
    drawn = "await new Promise(requestAnimationFrame); await new Promise(requestAnimationFrame);"
    assert held.run(drawn + "return linkwright.view.line.object.visible")
    assert held.run(rise, body, 1) > 0.07
    held.act({"type": "pointerUp", "button": 0})
    assert not held.run("return linkwright.view.line.object.visible")
    assert held.run("return linkwright.view.engine.data.xfrc_applied.every((force) => force === 0)")
    assert held.run(rise, body, 2) == pytest.approx(0.05, abs=1e-3)
    assert complaints(held) == []


def test_names_from_cad_stay_text(browser, page_of):
    browser.open(page_of(small_pack(renamed(chain(2), HOSTILE))))
    browser.run("linkwright.view.pick(1)")
    assert text(browser, ".live-card h3") == HOSTILE
    assert browser.run("return document.querySelectorAll('#live img:not(.preview)').length") == 0
    assert browser.run("return window.broken") is None
    assert complaints(browser) == []


@pytest.mark.parametrize("width", [320, 400, 760, 1280])
def test_nothing_sticks_out(browser, page_of, width):
    browser.size(width, 900)
    browser.open(page_of(small_pack(renamed(chain(2), "x" * 80))))
    browser.run("linkwright.view.pick(1); document.querySelector('.live-licences summary').click()")
    assert browser.run("return document.documentElement.scrollWidth") <= width
    for selector in (".live-slider input", ".live-bar button", ".live-card"):
        right = "return document.querySelector(arguments[0]).getBoundingClientRect().right"
        assert browser.run(right, selector) <= width, selector


def test_every_control_has_a_name(held):
    unnamed = held.run(
        "return [...document.querySelectorAll('#live :is(input, button, select)')].filter((it) =>"
        "!it.labels?.[0]?.textContent.trim() && !it.textContent.trim() && !it.ariaLabel)"
        ".map((it) => it.outerHTML)"
    )
    assert unnamed == []


def test_a_slider_is_where_its_joint_went(browser, page_of):
    """Also the second time that it is moved to where the loop does not let the joint go."""
    browser.open(page_of(small_pack(FOUR_BAR), "none"))
    for value in (2.5, 3):
        qpos, shown_at = slide(browser, "rocker", value)
    rocker = qpos[model_of(FOUR_BAR).joint("rocker").qposadr[0]]
    assert rocker < 2.4
    assert shown_at == pytest.approx(rocker, abs=0.01)


def test_values_that_change_while_it_runs_are_not_read_out(held):
    live = held.run("return [...document.querySelectorAll('#live output')].map((it) => it.ariaLive)")
    assert set(live) == {"off"}


@pytest.mark.parametrize(("rate", "said"), [(0.84, "0.8"), (0.1, "0.1"), (0.034, "0.03")])
def test_the_rate_is_never_shown_as_zero(held, rate, said):
    read = "linkwright.view.page.showRate(arguments[0]); return linkwright.view.page.rate.textContent"
    assert held.run(read, rate) == f"at {said} of real time"


def test_it_does_not_step_out_of_sight(held):
    held.run("document.body.prepend(Object.assign(document.createElement('div'), {style: 'height: 300vh'}))")
    seconds = "await new Promise((done) => setTimeout(done, 300)); return linkwright.view.engine.data.time"
    held.run(seconds)
    assert held.run(seconds) == held.run(seconds)
    held.run("scrollTo(0, 1e9)")
    held.run(seconds)
    assert held.run(seconds) < held.run(seconds)
    held.run("document.body.firstElementChild.remove()")


def test_a_frame_is_drawn_once_also_after_it_was_out_of_sight(held):
    drawn, ticks = held.run(
        "const tall = Object.assign(document.createElement('div'), {style: 'height: 300vh'});"
        "const wait = () => new Promise((done) => setTimeout(done, 60));"
        "for (const _ of [1, 2, 3]) {"
        " document.body.prepend(tall); await wait(); tall.remove(); await wait(); }"
        "const {stage} = linkwright.view; let drawn = 0, ticks = 0;"
        "stage.render = () => { drawn++; Object.getPrototypeOf(stage).render.call(stage); };"
        "for (; ticks < 10; ticks++) await new Promise(requestAnimationFrame);"
        "delete stage.render; return [drawn, ticks]"
    )
    assert 0 < drawn <= ticks + 1


def test_the_licences_open(held):
    text = held.run(
        "document.querySelector('.live-licences summary').click();"
        "const pre = document.querySelector('.live-licences pre');"
        "for (let n = 0; n < 300 && !pre.textContent; n++) await new Promise((go) => setTimeout(go, 100));"
        "return pre.textContent"
    )
    assert "Apache License" in text
    assert "three.js authors" in text
    assert len(text) > 200_000


def test_paper_gets_the_view_as_it_is(held):
    size = held.run(
        "dispatchEvent(new Event('beforeprint'));"
        "const picture = document.querySelector('.live-still img'); await picture.decode();"
        "const drawn = Object.assign(document.createElement('canvas'), {width: picture.naturalWidth,"
        " height: picture.naturalHeight}).getContext('2d'); drawn.drawImage(picture, 0, 0);"
        "const shown = drawn.getImageData(0, 0, picture.naturalWidth, picture.naturalHeight).data;"
        "return shown.filter((value, index) => index % 4 === 3 && value === 255).length"
    )
    assert size > 1000
