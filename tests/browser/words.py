"""What the page says, and what the browser complains of."""

from pathlib import Path

from tests.browser.webdriver import Browser

OF_THE_DRIVER = "GL Driver Message"
"""What drawing in software says of itself when a picture is taken."""


def complaints(browser: Browser) -> list[str]:
    """Errors and warnings in the console since the last call."""
    return [line for line in browser.console() if OF_THE_DRIVER not in line]


def word(browser: Browser) -> str:
    """The state that the page tells."""
    return str(browser.run("return document.querySelector('.live-word').textContent"))


def shown(browser: Browser, selector: str) -> bool:
    """Whether an element takes room on the page."""
    script = (
        "const e = document.querySelector(arguments[0]); return e !== null && e.getClientRects().length > 0"
        " && getComputedStyle(e).visibility !== 'hidden'"
    )
    return bool(browser.run(script, selector))


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


def opened(browser: Browser, page: Path) -> Browser:
    """Has a page as it is when it has just been opened; one that is open already is not read again."""
    if browser.page == page:
        browser.run(AS_OPENED)
    else:
        browser.open(page)
    return browser
