"""Reads the page, moves its sliders, and collects the browser's complaints."""

OF_THE_DRIVER = "GL Driver Message"
"""A message of drawing in software when a picture is taken."""


def complaints(browser):
    """Errors and warnings in the console since the last call."""
    return [line for line in browser.console() if OF_THE_DRIVER not in line]


def word(browser):
    """The state that the page tells."""
    return text(browser, ".live-word")


def shown(browser, selector):
    """Whether an element takes room on the page."""
    script = (
        "const e = document.querySelector(arguments[0]); return e !== null && e.getClientRects().length > 0"
        " && getComputedStyle(e).visibility !== 'hidden'"
    )
    return bool(browser.run(script, selector))


def text(browser, selector):
    return browser.run("return document.querySelector(arguments[0]).textContent", selector)


def slide(browser, label, value):
    """Moves the last slider of this label; the values of the joints and of the slider after two frames."""
    return browser.run(
        "const row = [...document.querySelectorAll('.live-slider')].filter((row) =>"
        " row.querySelector('label').textContent === arguments[0]).pop();"
        "const input = row.querySelector('input'); input.value = arguments[1];"
        "input.dispatchEvent(new Event('input'));"
        "for (const _ of [1, 2]) await new Promise(requestAnimationFrame);"
        "return [linkwright.qpos(), Number(input.value)]",
        label,
        value,
    )


AS_OPENED = """
const {view} = linkwright;
view.letGo();
view.pick(null);
for (const box of document.querySelectorAll("[data-layer]")) {
  if (box.checked !== box.defaultChecked) box.click();
}
document.querySelector(".live-keyframe").value = "0";
document.activeElement.blur();
scrollTo(0, 0);
view.stage.resize();
view.stage.home();
view.pause();
view.reset();
view.run();
"""


def opened(browser, page):
    """A page in the state of just being opened; a page that is open already is not read again."""
    if browser.page == page:
        browser.run(AS_OPENED)
    else:
        browser.open(page)
    return browser
