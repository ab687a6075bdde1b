"""The report of a build and the page of a sweep in a browser: they fit a laptop, a phone and paper, and the
keyboard reaches their parts."""

from dataclasses import replace

import pytest

from linkwright.pipeline.page.document import page
from linkwright.pipeline.page.sweep.document import page as sweep_page
from linkwright.pipeline.secrets import Secrets
from linkwright.pipeline.show.live import NOTHING, Live
from linkwright.stages.show.graph_view.views import views
from tests.browser.models import ALL_JOINTS, small_pack
from tests.browser.words import complaints
from tests.unit.pipeline.page.test_document import REPORT
from tests.unit.pipeline.page.test_hostile import HOSTILE, build_page, report, sweep
from tests.unit.pipeline.page.test_sweep_page import GRID
from tests.unit.show.graph_view.test_picture import nasty_robot, random_robot

pytestmark = pytest.mark.slow

LONG = "a_name_without_any_end_" * 12
TAB = "\ue004"
ENTER = "\ue007"


def shown(robot):
    return {name: data.decode() for name, data in views(robot).items()}


def of(robot, live=NOTHING):
    return page(replace(REPORT, outline=()), shown(robot), {"arm.urdf": 1}, Secrets({}), live=live)


PAGES = {
    "small": lambda: of(random_robot(6)),
    "big": lambda: of(random_robot(80)),
    "nasty": lambda: of(nasty_robot()),
    "view": lambda: of(random_robot(6), Live(small_pack(ALL_JOINTS))),
    "failed": lambda: page(replace(report(LONG, LONG), status="failed"), {}, dict.fromkeys(
        report(LONG, LONG).outputs, 1), Secrets({})),
    "long names": lambda: build_page(LONG),
    "hostile": lambda: build_page(HOSTILE),
    "sweep": lambda: sweep_page("arm.sweep", GRID, lambda _: False, ()),
    "sweep of long names": lambda: sweep(LONG),
}  # fmt: skip


@pytest.fixture
def opened(browser, tmp_path):
    def open_page(data, width=1280, dark=False):
        browser.size(width, 900, dark=dark)
        path = tmp_path / "report.html"
        path.write_bytes(data)
        browser.open(path)
        return browser

    return open_page


@pytest.mark.parametrize("kind", PAGES)
def test_nothing_is_wider_than_a_phone_or_a_laptop(opened, kind):
    data = PAGES[kind]()
    for width in (400, 1280):
        browser = opened(data, width)
        browser.run("for (const it of document.querySelectorAll('details')) it.open = true")
        wide = browser.run("return document.scrollingElement.scrollWidth")
        assert wide <= width, (kind, width, wide)


def test_a_hostile_name_runs_nothing(opened):
    alert = b"<head><script>window.alert = () => window.ran = 1</script>"
    browser = opened(build_page(HOSTILE).replace(b"<head>", alert))
    assert browser.run("return window.ran ?? 0") == 0
    assert browser.run("return document.querySelectorAll('img[src=x], [onload], [onerror]').length") == 0
    assert browser.run("return document.querySelector('h1').textContent").startswith(HOSTILE)
    assert complaints(browser) == []


def test_contents_fit_laptop_and_phone_and_obey_the_keyboard(opened):
    data = of(random_robot(6))
    links = "[...document.querySelectorAll('.contents a')]"
    seen = f"return {links}.filter(one => one.checkVisibility()).length"
    browser = opened(data, 1280)
    number = browser.run(f"return {links}.length")
    assert browser.run(seen) == number >= 8
    reached = set()
    for _ in range(40):
        browser.keys(TAB)
        reached.add(browser.run("return document.activeElement.getAttribute('href')"))
    assert {"#report", "#fix", "#checks", "#codes"} <= reached
    browser = opened(data, 400)
    assert browser.run(seen) == 0
    browser.run("document.querySelector('.contents summary').focus()")
    browser.keys(ENTER)
    assert browser.run(seen) == number


def test_the_first_key_leads_past_the_robot_to_the_report(opened):
    browser = opened(of(random_robot(6), Live(small_pack(ALL_JOINTS))))
    browser.keys(TAB)
    read = "const it = document.activeElement; return [it.getBoundingClientRect().left, it.textContent]"
    left, words = browser.run(read)
    assert left >= 0
    assert words == "Skip to the report"
    browser.keys(ENTER)
    assert browser.run("return document.activeElement.id") == "report"


def test_a_link_to_a_code_leads_to_its_explanation_below_the_contents(opened):
    browser = opened(of(random_robot(6)))
    browser.run("document.querySelector('.fixes a').click()")
    code, top, line = browser.run(
        "const at = document.getElementById(location.hash.slice(1));"
        "const line = document.querySelector('.contents').getBoundingClientRect().bottom;"
        "return [at.textContent, at.getBoundingClientRect().top, line]"
    )
    assert code == "W-LIMIT"
    assert line - 1 <= top <= 900


@pytest.mark.parametrize("dark", [False, True])
def test_texts_can_be_read_in_light_and_dark(opened, dark):
    """The colours as the browser computes them, of every text against the ground below it."""
    browser = opened(PAGES["hostile"](), dark=dark)
    worst = browser.run(
        """
        const light = colour => { const part = colour.match(/[\\d.]+/g).map(Number);
          const linear = part.slice(0, 3).map(v => v / 255)
            .map(v => v <= .04045 ? v / 12.92 : ((v + .055) / 1.055) ** 2.4);
          return [.2126 * linear[0] + .7152 * linear[1] + .0722 * linear[2], part[3] ?? 1]; };
        const ground = it => { for (; it; it = it.parentElement) {
          const [value, alpha] = light(getComputedStyle(it).backgroundColor);
          if (alpha === 1) return value; } return 1; };
        let worst = [99, ""];
        for (const it of document.querySelectorAll("body *:not(svg *):not(script):not(style)")) {
          if (![...it.childNodes].some(node => node.nodeType === 3 && node.data.trim())) continue;
          const one = light(getComputedStyle(it).color)[0], other = ground(it);
          const contrast = (Math.max(one, other) + .05) / (Math.min(one, other) + .05);
          if (contrast < worst[0]) worst = [contrast, it.className + " " + it.textContent.slice(0, 40)];
        }
        return worst;"""
    )
    assert worst[0] >= 4.5, worst


def test_folded_parts_are_open_on_paper_unless_left_out(opened):
    browser = opened(build_page("word"))
    browser.cdp("Emulation.setEmulatedMedia", media="print")
    seen = browser.run(
        """
        const shown = it => it.checkVisibility();
        const kinds = {open: [], brief: []};
        for (const one of document.querySelectorAll("#report details"))
          kinds[one.classList.contains("brief") ? "brief" : "open"].push(shown(one.lastElementChild));
        return [kinds, shown(document.querySelector("nav"))];"""
    )
    browser.cdp("Emulation.setEmulatedMedia", media="")
    kinds, nav = seen
    assert len(kinds["open"]) >= 4
    assert all(kinds["open"])
    assert kinds["brief"]
    assert not any(kinds["brief"])
    assert not nav
