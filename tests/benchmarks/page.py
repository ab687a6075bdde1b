"""`python -m tests.benchmarks.page`: the view in a browser, at many links and at many triangles."""

import statistics
import tempfile
import time
from pathlib import Path

from linkwright.stages.show.live.viewer import view
from tests.browser.conftest import PAGE
from tests.browser.models import chain, model_of, small_pack, sphere
from tests.browser.packs import pack_of, packed
from tests.browser.webdriver import Browser, missing
from tests.browser.words import word

LINKS = (10, 80)
TRIANGLES = (20_000, 200_000)
FRAMES = 20
GOAL = 8.0
"""Milliseconds of script a frame at 80 links."""

MEASURE = """
const found = [];
linkwright.view.run();
const drawn = () => new Promise((done) => requestAnimationFrame(() => setTimeout(done)));
for (let i = 0; i < arguments[0]; i++) {
  linkwright.view.draw();
  await drawn();
  found.push([linkwright.info().scriptTime, linkwright.info().stepTime]);
}
return found;
"""


def main():
    if missing():
        raise SystemExit(f"needs a browser: {missing()} not found")
    models = {f"{links} links": small_pack(chain(links)) for links in LINKS}
    models |= {f"{count:,} triangles": packed(pack_of(model_of(sphere(count)))) for count in TRIANGLES}
    print(f"script of a frame; goal at 80 links: {GOAL} ms without the engine's steps")
    print(f"{'model':18} {'opens, s':>9} {'script, ms':>11} {'steps, ms':>10} {'draw calls':>11}")
    with tempfile.TemporaryDirectory() as folder, Browser() as browser:
        page = Path(folder) / "page.html"
        for title, pack in models.items():
            made = view(pack, "whole")
            text = PAGE.format(style=made.style, body=made.body, scripts=made.scripts)
            page.write_text(text, encoding="utf-8")
            start = time.perf_counter()
            browser.open(page)
            opened = time.perf_counter() - start
            frames = browser.run(MEASURE, FRAMES)
            script = statistics.median(whole - steps for whole, steps in frames)
            stepped = statistics.median(steps for _, steps in frames)
            calls = browser.run("return linkwright.info().calls")
            print(f"{title:18} {opened:9.2f} {script:11.2f} {stepped:10.2f} {calls:11}  {word(browser)}")


if __name__ == "__main__":
    main()
