"""The page of a sweep in a browser: sorted, filtered, its views linked, by mouse and by keyboard."""

import random
import re

import pytest

from linkwright.pipeline.page.sweep.document import page
from linkwright.pipeline.sweep.outcome import state_of
from tests.browser.words import complaints
from tests.unit.pipeline.page.test_hostile import HOSTILE
from tests.unit.pipeline.page.test_sweep_page import GRID, job

pytestmark = pytest.mark.slow

LARGE = 10_000
TAB, ENTER = "\ue004", "\ue007"
LEFT, RIGHT = "\ue012", "\ue014"
MESSAGES = {0: "valid", 3: "a check failed", 1: "no triangles", None: "missing"}


def page_of_sweep(jobs, pictures=False):
    return page("arm.sweep", jobs, lambda path: pictures or not path.endswith(".png"), ("summary.json",))


def many(number):
    """Jobs with a mass and a reach, which those that failed or are missing have not."""
    draw = random.Random(7)
    made = []
    for at in range(number):
        status = draw.choices((0, 3, 1, None), (90, 5, 3, 2))[0]
        figures = {"mass": round(draw.uniform(1, 9), 4), "reach": round(draw.uniform(0.1, 0.9), 4)}
        message = MESSAGES[status]
        some = figures if status in (0, 3) else {}
        row = job(at, status, some, message, mesh=("hull", "coacd")[at % 2], leg=at // 2 % 50)
        made.append(row | {"state": state_of(status, message)})
    return made


@pytest.fixture
def opened(browser, tmp_path):
    def open_page(jobs, width=1200, pictures=False):
        browser.size(width, 900)
        path = tmp_path / "summary.html"
        path.write_bytes(page_of_sweep(jobs, pictures))
        browser.open(path)
        return browser

    return open_page


def texts(browser, selector):
    script = "return [...document.querySelectorAll(arguments[0])].map(it => it.textContent)"
    return browser.run(script, selector)


def numbers(browser):
    """The jobs of the table, in its order."""
    return list(map(int, texts(browser, "#jobs tbody .pick")))


def press_heading(browser, title):
    browser.run(
        "const all = [...document.querySelectorAll('#jobs thead button')];"
        "all.find(it => it.textContent === arguments[0]).click()",
        title,
    )


def choose(browser, selector, value):
    """Chooses an option by its text, or enters a value."""
    browser.run(
        "const [it, value] = [document.querySelector(arguments[0]), arguments[1]];"
        "it.value = [...it.options ?? []].find(option => option.textContent === value)?.value ?? value;"
        "it.dispatchEvent(new Event('input')); it.dispatchEvent(new Event('change'));"
        "await new Promise(done => setTimeout(done, 300))",
        selector,
        value,
    )


def shown(browser):
    """The jobs that the selection shows."""
    script = "return linkwright.jobs.filter(it => linkwright.selection.shown[it.at]).map(it => it.number)"
    return set(browser.run(script))


def test_table_sorts_by_any_column_with_empty_values_last(opened):
    jobs = many(90)
    browser = opened(jobs)
    choose(browser, "[data-pages] select", "100")
    mass = {entry["number"]: entry["figures"].get("mass") for entry in jobs}
    with_mass = sorted((n for n in mass if mass[n] is not None), key=lambda n: (mass[n], n))
    without = [n for n in mass if mass[n] is None]
    assert without
    press_heading(browser, "mass, kg")
    assert numbers(browser) == with_mass + without
    press_heading(browser, "mass, kg")
    assert numbers(browser) == with_mass[::-1] + without
    assert texts(browser, "#jobs th[aria-sort=descending]") == ["mass, kg"]
    assert browser.run("return document.activeElement.textContent") == "mass, kg"
    press_heading(browser, "status")
    order = ["built", "unmet", "failed", "running", "missing"]
    states = {entry["number"]: order.index(entry["state"]) for entry in jobs}
    assert numbers(browser) == sorted(states, key=lambda n: (states[n], n))
    assert complaints(browser) == []


def test_a_filter_holds_in_all_views(opened):
    jobs = many(200)
    browser = opened(jobs)
    assert shown(browser) == set(range(200))
    choose(browser, '[aria-label="mass, kg from"]', "5")
    heavy = {entry["number"] for entry in jobs if entry["figures"].get("mass", 0) >= 5}
    assert shown(browser) == heavy
    assert numbers(browser) == sorted(heavy)[:25]
    bright = "const all = [...document.querySelectorAll('.plots [data-job]:not(.out)')];"
    assert set(browser.run(f"{bright} return all.map(it => Number(it.dataset.job))")) == heavy
    assert texts(browser, "[data-count]") == [f"{len(heavy)} of 200 jobs shown"]
    # All words must be there.
    choose(browser, "[name=words]", "mesh=HULL built")
    assert shown(browser) == {n for n in heavy if n % 2 == 0}
    reset = "document.querySelector('#compare [type=reset]').click();"
    browser.run(f"{reset} await new Promise(requestAnimationFrame)")
    assert shown(browser) == set(range(200))
    browser.run("document.querySelector('[data-states] input[value=built]').click()")
    assert shown(browser) == {entry["number"] for entry in jobs if entry["state"] != "built"}
    browser.run(f"{reset} await new Promise(requestAnimationFrame)")
    choose(browser, "select[aria-label=mesh]", "coacd")
    assert shown(browser) == set(range(1, 200, 2))


def test_range_dragged_on_an_axis_filters_until_a_click(opened):
    browser = opened(many(200))
    browser.run("document.querySelector('[data-parallel]').scrollIntoView({block: 'center'})")
    left, top, height = browser.run(
        "const r = document.querySelector('[data-parallel] canvas').getBoundingClientRect();"
        "return [r.left, r.top, r.height]"
    )
    move = {"type": "pointerMove", "duration": 0, "x": int(left + 46)}
    down, up = {"type": "pointerDown", "button": 0}, {"type": "pointerUp", "button": 0}
    middle, low = int(top + height * 0.5), int(top + height - 5)
    browser.act({**move, "y": middle}, down, {**move, "y": (middle + low) // 2}, {**move, "y": low}, up)
    browser.run("await new Promise(requestAnimationFrame); await new Promise(requestAnimationFrame)")
    # The lower half of the first axis, mesh, is its first category.
    assert shown(browser) == set(range(0, 200, 2))
    assert browser.run("return document.querySelector('select[aria-label=mesh]').value") == "some"
    browser.act({**move, "y": middle}, down, up)
    assert shown(browser) == set(range(200))


def test_what_one_view_points_at_the_others_show(opened):
    browser = opened(GRID)
    browser.run("linkwright.point(4)")
    assert texts(browser, "#jobs tr.at .pick") == ["4"]
    assert len(texts(browser, ".plots .at")) == 2
    assert texts(browser, "[data-card] h3") == ["Job 4 ✓ built"]
    dot = "document.querySelector('.plots [data-job=\"2\"]')"
    browser.run(f"{dot}.dispatchEvent(new PointerEvent('pointerenter'))")
    assert texts(browser, "[data-card] h3") == ["Job 2 ✓ built"]
    browser.run("document.querySelectorAll('#jobs .pick')[5].click(); linkwright.point(-1)")
    assert texts(browser, "[data-card] h3") == ["Job 5 ✓ built"]
    assert texts(browser, ".pick[aria-pressed=true]") == ["5"]


def test_the_mouse_points_at_dots_and_at_lines(opened):
    jobs = many(30)
    browser = opened(jobs)
    choose(browser, "[name=x]", "mass, kg")
    for view, place in {
        "[data-scatter]": "return [scatter.places[0], scatter.places[1]]",
        "[data-parallel]": "return [axisX(2), axisY(parallel.axes[2].share(columns[2].numbers[0]))]",
    }.items():
        x, y = browser.run(f"const {{scatter, parallel, axisX, axisY, columns}} = linkwright; {place}")
        browser.run("document.querySelector(arguments[0]).scrollIntoView({block: 'center'})", view)
        left, top = browser.run(
            "const r = document.querySelector(`${arguments[0]} canvas`).getBoundingClientRect();"
            "return [r.left, r.top]",
            view,
        )
        browser.act({"type": "pointerMove", "duration": 0, "x": int(left + x), "y": round(top + y)})
        assert texts(browser, "[data-card] h3") == ["Job 0 ✓ built"], view
        browser.act({"type": "pointerMove", "duration": 0, "x": 2, "y": 2})


def test_the_arrow_keys_step_from_job_to_job(opened):
    browser = opened(GRID)
    choose(browser, "[name=x]", "mass, kg")
    browser.run("document.querySelector('[data-scatter] canvas').focus()")
    seen = []
    for key in (RIGHT, RIGHT, RIGHT, LEFT):
        browser.keys(key)
        seen.append(browser.run("return linkwright.selection.hovered"))
    assert seen == [0, 1, 2, 1]
    browser.keys(ENTER)
    assert browser.run("return linkwright.selection.picked") == 1
    label = browser.run("return document.querySelector('[data-scatter] canvas').getAttribute('aria-label')")
    assert label.startswith("mass, kg against mass, kg, of 6 jobs")


def dominated(first, other, directions):
    """Whether `other` is at least as good as `one` in both values and better in any."""
    gains = [sign * (b - a) for a, b, sign in zip(first, other, directions, strict=True)]
    return min(gains) >= 0 and max(gains) > 0


def test_the_pareto_front_is_that_of_brute_force(opened):
    browser = opened(GRID)
    draw = random.Random(3)
    for _ in range(60):
        # Few different values, so that many are the same.
        several = draw.choice([3, 30])
        values = [[draw.choice([None, *range(several)]) for _ in range(2)] for _ in range(40)]
        seen = [draw.random() < 0.8 for _ in values]
        directions = [draw.choice([-1, 1]), draw.choice([-1, 1])]
        front = browser.run(
            "const [values, seen, [x, y]] = arguments;"
            "const side = at => Float64Array.from(values, pair => pair[at] ?? NaN);"
            "return linkwright.paretoFront(side(0), side(1), x, y, seen)",
            values, seen, directions,
        )  # fmt: skip
        there = [n for n, pair in enumerate(values) if seen[n] and None not in pair]
        expected = [n for n in there if not any(dominated(values[n], values[m], directions) for m in there)]
        assert sorted(front) == expected


def test_front_is_that_of_the_shown_jobs_and_may_stand_alone(opened):
    jobs = many(300)
    browser = opened(jobs)
    browser.run("document.querySelector('[data-states] input[value=unmet]').click()")
    for name, value in {"x": "mass, kg", "y": "reach", "x-better": "less", "y-better": "more"}.items():
        choose(browser, f"[name={name}]", value)
    built = [entry for entry in jobs if entry["state"] == "built"]
    values = {entry["number"]: (entry["figures"]["mass"], entry["figures"]["reach"]) for entry in built}
    every = values.values()
    expected = {n for n in values if not any(dominated(values[n], other, (-1, 1)) for other in every)}
    assert texts(browser, "[data-front]") == [f"Pareto front: {len(expected)} jobs"]
    browser.run("document.querySelector('[name=front]').click()")
    assert shown(browser) == expected == set(numbers(browser))


def test_of_ten_thousand_jobs_only_what_is_seen_is_loaded(opened):
    browser = opened(many(LARGE), pictures=True)
    assert len(shown(browser)) == LARGE
    assert numbers(browser) == list(range(25))
    browser.run("document.querySelector('[data-step=\"1\"]').click()")
    assert numbers(browser) == list(range(25, 50))
    assert texts(browser, "[data-pages] output") == ["26–50 of 10,000"]
    assert browser.run("return document.querySelectorAll('body *').length") < 5000
    pictures = {address for address in browser.requests() if address.endswith("preview.png")}
    assert len(pictures) < 100
    choose(browser, "[name=x]", "mass, kg")
    choose(browser, '[aria-label="reach from"]', "0.5")
    assert 0 < len(shown(browser)) < LARGE


@pytest.mark.parametrize("width", [400, 1200])
def test_the_page_asks_for_nothing_else_and_is_as_wide_as_the_screen(opened, width):
    browser = opened(many(60), width)
    assert [address for address in browser.requests() if not address.endswith("summary.html")] == []
    browser.run("for (const it of document.querySelectorAll('details')) it.open = true")
    assert browser.run("return document.scrollingElement.scrollWidth") <= width
    seen = "filter(it => it.checkVisibility()).length"
    assert browser.run(f"return [...document.querySelectorAll('#jobs thead button')].{seen}") >= 5


def test_the_keyboard_reaches_filters_plot_and_table(opened):
    browser = opened(GRID)
    reached = set()
    for _ in range(60):
        browser.keys(TAB)
        names = "it.name || it.className || it.textContent || it.tagName"
        reached.add(browser.run(f"const it = document.activeElement; return {names}"))
    assert {"words", "x", "y", "x-better", "y-better", "CANVAS", "mesh", "pick"} <= reached


def test_no_name_is_taken_as_html(opened):
    jobs = [{**job, "folder": HOSTILE, "message": HOSTILE} for job in GRID]
    browser = opened([{**entry, "overrides": {HOSTILE: f"{HOSTILE}{entry['number']}"}} for entry in jobs])
    browser.run("linkwright.point(1)")
    assert browser.run("return document.querySelectorAll('img[src=x], [onload], [onerror]').length") == 0
    assert HOSTILE in texts(browser, "#jobs")[0]
    assert HOSTILE in texts(browser, "[data-card]")[0]


def test_without_a_script_the_table_and_the_plots_are_read(browser, tmp_path):
    path = tmp_path / "summary.html"
    script = rb"<script type=\"module\">.*?</script>"
    path.write_bytes(re.sub(script, b"", page_of_sweep(GRID), flags=re.DOTALL))
    browser.open(path)
    seen = "return [...document.querySelectorAll(arguments[0])].filter(it => it.checkVisibility()).length"
    assert browser.run(seen, "#jobs tbody tr") == len(GRID)
    assert browser.run(seen, ".plots svg[role=img]") == 2
    assert browser.run(seen, "form, [data-views], .pages") == 0
    assert "need JavaScript" in texts(browser, "#compare")[0]
