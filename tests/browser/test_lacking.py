"""The view in a browser that lacks something: the page says so in a line, and throws nothing."""

import pytest

from linkwright.stages.show.live.viewer import engine_script
from tests.browser.models import ALL_JOINTS, FOUR_BAR, model_of, small_pack
from tests.browser.packs import pack_of, packed
from tests.browser.webdriver import Browser
from tests.browser.words import complaints, shown, word

pytestmark = pytest.mark.slow


def test_without_webassembly_the_sliders_pose_the_robot(page_of):
    with Browser("--js-flags=--jitless") as browser:
        browser.open(page_of(small_pack(FOUR_BAR)))
        reason = "WebAssembly is switched off in this browser"
        assert word(browser) == f"No simulation: {reason}. The sliders pose the robot."
        assert browser.run("return linkwright.pose('crank', 0.3)")[0] == pytest.approx(0.3)
        assert browser.run("return linkwright.open()") < 1e-6
        parts = ("canvas", ".live-slider input", ".live-toggle")
        assert [shown(browser, part) for part in parts] == [True, True, False]
        assert complaints(browser) == []


def test_without_webgl_the_preview_is_shown(page_of):
    with Browser("--disable-3d-apis") as browser:
        browser.open(page_of(small_pack(FOUR_BAR)))
        assert "WebGL" in word(browser)
        parts = (".preview", "canvas", ".live-slider", ".live-bar")
        assert [shown(browser, part) for part in parts] == [True, False, False, False]
        assert complaints(browser) == []


def test_a_model_that_the_engine_refuses_is_posed(browser, page_of):
    refused = ALL_JOINTS.replace("<worldbody>", "<worldbody><nonsense/>", 1)
    browser.open(page_of(packed(pack_of(model_of(ALL_JOINTS), refused))))
    assert "MuJoCo 3.14.0 could not load the model" in word(browser)
    assert "nonsense" in word(browser)
    assert shown(browser, ".live-slider input")
    assert complaints(browser) == []


def test_an_engine_with_another_model_is_not_used(browser, page_of):
    browser.open(page_of(packed(pack_of(model_of(ALL_JOINTS), FOUR_BAR))))
    assert "other joints or bodies" in word(browser)
    assert complaints(browser) == []


def test_the_engine_beside_the_page(browser, page_of, tmp_path):
    (tmp_path / "linkwright-engine.js").write_bytes(engine_script())
    page = page_of(small_pack(FOUR_BAR), "shared", "linkwright-engine.js")
    browser.open(page)
    assert browser.run("return linkwright.info().engine"), word(browser)
    assert complaints(browser) == []
    assert list(browser.requests()) == [page.as_uri(), (tmp_path / "linkwright-engine.js").as_uri()]


def test_the_engine_beside_the_page_may_be_gone(browser, page_of):
    browser.open(page_of(small_pack(FOUR_BAR), "shared", "../linkwright-engine.js"))
    assert "../linkwright-engine.js is not beside it" in word(browser)
    assert shown(browser, ".live-slider input")


def test_a_model_without_an_engine_is_posed(browser, page_of):
    browser.open(page_of(packed(pack_of(model_of(FOUR_BAR)))))
    assert word(browser) == "No simulation: there is no model for it. The sliders pose the robot."
    assert not shown(browser, ".live-toggle")
    assert complaints(browser) == []


def test_an_unstable_simulation_is_stopped_and_reset(browser, page_of):
    browser.open(page_of(small_pack(FOUR_BAR)))
    browser.run("const {view} = linkwright; view.run(); view.engine.views.qvel[0] = NaN; view.advance(0.01)")
    assert word(browser).startswith("The simulation became unstable")
    assert browser.run("return linkwright.info().running") is False
    assert browser.run("return linkwright.qpos()") == model_of(FOUR_BAR).qpos0.tolist()
    assert complaints(browser) == []
