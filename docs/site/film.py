"""`python -m docs.site.film` makes `docs/pictures/page.webp`: the sample in its page, moved by its controls.

It needs Chromium and chromedriver. The page's clock is replaced, so that the film runs in the robot's own
time, however slowly this computer draws.
"""

import base64
import io
import tempfile
from collections.abc import Iterator
from pathlib import Path

from PIL import Image

from docs.site import robots
from docs.site.pictures import PICTURES
from tests.browser.webdriver import Browser

FRAMES, PER_SECOND = 84, 12
STEPS = 4
"""Pieces of the time of a frame, between which the robot's engine is advanced: it takes no long ones."""

COLLIDERS = range(50, 74)
"""The frames that show the colliders."""

SIZE, RATIO = (1100, 760), 0.7
"""The page's area [px], and the pixels of the film by those of the page."""

LARGEST = 600_000
"""Bytes of the film."""

SWINGS = {
    "lift": (0.2, 1), "shoulder_yaw": (0.28, 1), "shoulder": (0.25, 1), "elbow": (0.3, 2),
    "wrist_pitch": (0.3, 2), "wrist_roll": (0.4, 1), "left_finger": (0.5, 3),
}  # fmt: skip
"""Control → how far it swings to each side, as a share of the room that it has there, and its periods in the
film."""

CLOCK = """
let now = performance.now();
let asked = [];
window.requestAnimationFrame = (callback) => asked.push(callback);
performance.now = () => now;
await new Promise((resolve) => setTimeout(resolve, 500));
linkwright.view.reset();
linkwright.view.run();
document.querySelector(".live-rate").hidden = true;
const start = Array.from(linkwright.view.ctrl);
const swing = (phase, swings) => {
  linkwright.header.actuators.forEach(({ name, range }, index) => {
    if (!(name in swings)) return;
    const [share, periods] = swings[name];
    const side = Math.sin(2 * Math.PI * periods * phase);
    const room = side > 0 ? range[1] - start[index] : start[index] - range[0];
    linkwright.view.control(index, start[index] + share * side * room);
  });
};
window.film = (phase, swings, seconds, steps) => {
  for (let step = 1; step <= steps; step++) {
    swing(phase, swings);
    now += (1000 * seconds) / steps;
    if (step < steps) {
      linkwright.view.advance(seconds / steps);
      linkwright.view.last = now;
    }
  }
  for (const callback of asked.splice(0)) callback(now);
};
"""


def frames(page: Path) -> Iterator[Image.Image]:
    """The pictures of the film, of the robot's page at this path."""
    with Browser(width=SIZE[0], height=SIZE[1], ratio=RATIO) as browser:
        browser.open(page)
        browser.run(CLOCK)
        area = browser.run(
            "const { x, y, width, height } = document.getElementById('live').getBoundingClientRect();"
            "return { x, y: y + scrollY, width, height, scale: 1 }"
        )
        for frame in range(-PER_SECOND, FRAMES):  # a second to settle
            phase = max(frame, 0) / FRAMES
            if frame in (COLLIDERS.start, COLLIDERS.stop):
                browser.run("document.querySelector('[data-layer=collider]').click()")
            browser.run("film(...arguments)", phase, SWINGS, 1 / PER_SECOND, STEPS)
            if frame >= 0:
                shot = browser.cdp("Page.captureScreenshot", format="png", clip=area)
                yield Image.open(io.BytesIO(base64.b64decode(shot["data"]))).convert("RGB")


def write(path: Path) -> None:
    """Builds the sample, and writes the film of its page."""
    with tempfile.TemporaryDirectory() as work:
        built = Path(work) / "built"
        robots.build(["sample"], Path(work) / "work", built)
        first, *others = frames(built / "sample" / "report.html")
    for quality in range(45, 0, -5):
        first.save(
            path, save_all=True, append_images=others, duration=round(1000 / PER_SECOND), loop=0,
            quality=quality, method=4,
        )  # fmt: skip
        if path.stat().st_size <= LARGEST:
            break


if __name__ == "__main__":
    write(PICTURES / "page.webp")
