"""`python -m docs.site.pictures` makes the pictures of the gallery's robots in `docs/pictures`.

Each is the picture of the robot's build, as WebP.
"""

import tempfile
from pathlib import Path

from PIL import Image

from docs.site import robots
from docs.site.pages import PROJECT

PICTURES = PROJECT / "docs" / "pictures"


def write(names: list[str], to: Path) -> None:
    """Builds robots, and saves the picture of each in a folder."""
    with tempfile.TemporaryDirectory() as work:
        built = Path(work) / "built"
        robots.build(names, Path(work) / "work", built)
        for name in names:
            with Image.open(built / name / "preview.png") as picture:
                picture.save(to / f"{name}.webp", quality=85, method=6)


if __name__ == "__main__":
    write(robots.gallery(), PICTURES)
