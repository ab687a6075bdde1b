"""`python -m docs.site.views` makes the pictures of the guide in `docs/pictures`: views of two robots' pages.

It needs Chromium and chromedriver, and takes a minute.
"""

import base64
import io
import sys
import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from PIL import Image

from tests.browser.webdriver import Browser
from tests.support.command import linkwright
from tests.support.places import PROJECT

PICTURES = PROJECT / "docs" / "pictures"
SIZE = (1100, 760)
"""The page's area [px]."""

SMALL = (440, 330)
"""The size of README's picture [px], which leaves room for the first command on the same screen."""

STAGE = "#live .live-stage"

CUBE = """\
# @package _global_
defaults: [/robot/sample, override /mesh: hull, _self_]
name: cube
elements:
  cube:
    into: {tag: worldbody}
    xml: |
      <body name="cube" pos="0.3 0 0.02">
        <freejoint/> <geom type="box" size="0.02 0.02 0.02" mass="0.05" rgba="0.9 0.4 0.1 1"/>
      </body>
"""
"""The sample with the cube of `docs/guide/xml.md`."""

SHOW = """
const [pose, layers, selector, height] = arguments;
const { view } = window.linkwright;
view.pause();
view.reset();
for (const [name, value] of Object.entries(pose)) window.linkwright.pose(name, value);
for (const box of document.querySelectorAll('#live [data-layer]'))
  if (box.checked !== layers.includes(box.dataset.layer)) box.click();
view.update();
view.stage.render();
for (const details of document.querySelectorAll(`${selector} details`)) details.open = true;
const box = document.querySelector(selector).getBoundingClientRect();
return { x: box.x, y: box.y + scrollY, width: box.width, height: Math.min(box.height, height), scale: 1 };
"""


@dataclass(frozen=True)
class View:
    """A picture of a part of a page: what of the robot, in which pose [rad, m], and the part's selector and
    largest height [px]."""

    layers: tuple[str, ...] = ("visual",)
    pose: Mapping[str, float] = field(default_factory=dict)
    selector: str = STAGE
    height: int = 520


VIEWS = {
    "sample": {
        "joints": View(("visual", "frames")),
        "mass": View(("visual", "inertia")),
        "colliders": View(("collider",)),
        "loops": View(pose={"shoulder": 0.9, "elbow": -0.2}),
        "python": View(pose={"shoulder_yaw": 0.2, "shoulder": -0.3, "elbow": 1.1}),
        "scene": View(pose={"shoulder": 0.8, "elbow": 1.0, "wrist_pitch": 0.3}),
        "actuators": View(selector="#live", height=408),
        "sensors": View(selector="#order", height=408),
        "files": View(selector="#readers"),
    },
    "cube": {"xml": View()},
}
"""Robot → picture → what it shows."""


def pictures(page: Path, views: Mapping[str, View]) -> Iterator[tuple[str, Image.Image]]:
    """The name and the picture of each view of the page at this path."""
    with Browser(width=SIZE[0], height=SIZE[1]) as browser:
        browser.open(page)
        for name, view in views.items():
            area = browser.run(SHOW, view.pose, view.layers, view.selector, view.height)
            shot = browser.cdp("Page.captureScreenshot", format="png", clip=area, captureBeyondViewport=True)
            yield name, Image.open(io.BytesIO(base64.b64decode(shot["data"]))).convert("RGB")


def main() -> None:
    """Builds the robots, and saves the views of their pages."""
    with tempfile.TemporaryDirectory() as folder:
        work = Path(folder)
        (work / "robot").mkdir()
        (work / "robot" / "cube.yaml").write_text(CUBE, encoding="utf-8")
        for robot, views in VIEWS.items():
            linkwright(work, f"robot={robot}", status=0)
            if robot == "sample":
                with Image.open(work / "outputs" / robot / "preview.png") as picture:
                    picture.resize(SMALL).save(PICTURES / "readme.webp", quality=85, method=6)
            for name, picture in pictures(work / "outputs" / robot / "report.html", views):
                picture.save(PICTURES / f"{name}.webp", quality=80, method=6)


if __name__ == "__main__":
    sys.exit(main())
