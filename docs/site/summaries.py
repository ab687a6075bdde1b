"""`python -m docs.site.summaries` makes the pictures of the pages on sweeps in `docs/pictures`.

They are parts of the summary of a sweep, and of the page of one of its jobs. It needs Chromium and
chromedriver.
"""

import base64
import io
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image

from docs.site.pictures import PICTURES
from tests.browser.webdriver import Browser

SWEEP = (
    "-m", "robot=sample", "mesh=hull", "validate=quick", "variants.n=256", "hydra.sweep.dir=sweep",
    "objective.figures=[mass,torque_margin]", "mass.links.forearm.mass=0.15,0.3,0.45",
    "mass.links.upper_arm.mass=0.15,0.3",
)  # fmt: skip

VIEWS = {
    "sweeps": ("summary.html", "#jobs"),
    "sweeps-summary": ("summary.html", "body"),
    "search": ("summary.html", "#plots"),
    "variants": ("*/report.html", "#variants"),
}
"""Picture → the page below the sweep's folder, and the part of it."""

SIZE, HEIGHT = (1100, 760), 560
"""The page's area, and the largest height of a picture [px]."""

AREA = """
const part = document.querySelector(arguments[0]);
for (const fold of part.querySelectorAll("details")) fold.open = true;
await new Promise((resolve) => setTimeout(resolve, 500));
const { x, y, width, height } = part.getBoundingClientRect();
const room = Math.min(16, x);
const area = { width: width + 2 * room, height: Math.min(height, arguments[1]) };
return { x: x - room, y: y + scrollY, ...area, scale: 1 };
"""


def main() -> None:
    """Builds the sweep, and saves a picture of each part."""
    with tempfile.TemporaryDirectory() as folder, Browser(width=SIZE[0], height=SIZE[1]) as browser:
        subprocess.run([sys.executable, "-m", "linkwright", *SWEEP], cwd=folder, check=True)
        for name, (page, part) in VIEWS.items():
            browser.open(min((Path(folder) / "sweep").glob(page)))
            area = browser.run(AREA, part, HEIGHT)
            shot = browser.cdp("Page.captureScreenshot", format="png", clip=area, captureBeyondViewport=True)
            picture = Image.open(io.BytesIO(base64.b64decode(shot["data"]))).convert("RGB")
            picture.save(PICTURES / f"{name}.webp", quality=80, method=6)


if __name__ == "__main__":
    main()
