"""The pictures of the documents are small, and each is used."""

import re

from docs.site import robots
from tests.support.places import PROJECT

PICTURES = PROJECT / "docs" / "pictures"
LARGEST, FILM = 3_000_000, 600_000
"""Bytes, of all pictures and of the film of the page."""


def texts():
    paths = [PROJECT / "README.md", *(PROJECT / "docs").rglob("*.md")]
    return "\n".join(path.read_text(encoding="utf-8") for path in paths)


def test_all_pictures_together_are_small():
    assert sum(path.stat().st_size for path in PICTURES.iterdir()) <= LARGEST
    assert (PICTURES / "page.webp").stat().st_size <= FILM


def test_the_gallery_shows_each_robot_of_the_package():
    text = (PROJECT / "docs" / "gallery.md").read_text(encoding="utf-8")
    shown = set(re.findall(r"\]\(pictures/(\w+)\.webp\)\]\(\.\./conf/robot/\1\.yaml\)", text))
    assert shown == set(robots.gallery())


def test_each_picture_is_shown_in_a_document():
    shown = set(re.findall(r"pictures/([\w.-]+)", texts()))
    assert {path.name for path in PICTURES.iterdir()} - shown == set()
