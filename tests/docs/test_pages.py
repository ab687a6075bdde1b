"""The pages of the site, without building it: no dead link, each in the navigation, small pictures."""

import re

import pytest

from docs.site import __main__ as site
from docs.site import pages, reference, robots
from tests.support.places import PROJECT

PLACES = pages.places()
TARGETS = PLACES | {f"docs/{page}": page for page in reference.PAGES}


def text(path):
    return (PROJECT / path).read_text(encoding="utf-8")


def test_the_navigation_lists_each_page():
    site.check_navigation()


@pytest.mark.parametrize("path", PLACES)
def test_no_link_of_a_page_is_dead(path):
    page = pages.Page(path, TARGETS, robots.gallery())
    page.rewritten(text(path))
    assert page.dead == []


def test_readme_is_short_and_links_to_files_here():
    """Who reads it elsewhere has no site."""
    targets = re.findall(r"\]\((?!https?:)([^)#]+)", text("README.md"))
    assert [target for target in targets if not (PROJECT / target).is_file()] == []
    assert len(text("README.md").encode()) <= 8192


@pytest.mark.parametrize("path", [path for path in PLACES if path.startswith("docs/guide/")])
def test_each_page_of_the_guide_has_a_picture_or_a_live_robot(path):
    assert re.search(r"!\[[^\]]{10,}\]\([\w./-]+\.(webp|svg|png)\)", text(path))


def test_links_and_comments_are_rewritten_and_code_is_not():
    page = pages.Page("docs/guide/joints.md", TARGETS, ["sample"])
    written = (
        "<!-- exit: 3 -->\n```text\n[a](../../README.md) <!-- kept -->\n```\n"
        "[b](../../stages/CHECKS.md#c) `[c](d)` [e](https://f.g) [h](#i)\n"
        "[![j](../pictures/sample.webp)](../../conf/robot/sample.yaml)\n[k](../../conf/robot/sample.yaml)\n"
        "[l](nothing.md)\n"
    )
    assert page.rewritten(written) == (
        "```text\n[a](../../README.md) <!-- kept -->\n```\n"
        "[b](../reference/checks.md#c) `[c](d)` [e](https://f.g) [h](#i)\n"
        "[![j](../pictures/sample.webp)](../robots/sample/report.html#live)\n"
        "[k](../files/conf/robot/sample.yaml)\n"
        "[l](nothing.md)\n"
    )
    assert page.copied == ["docs/pictures/sample.webp", "conf/robot/sample.yaml"]
    assert page.dead == [
        "docs/guide/joints.md: the link nothing.md leads to no file of the repository and no page"
    ]


PICTURES = PROJECT / "docs" / "pictures"
LARGEST, FILM = 3_000_000, 600_000
"""Bytes, of all pictures and of the film of the page."""


def test_all_pictures_together_are_small_and_each_is_shown():
    texts = [text(path) for path in ("README.md", *(PROJECT / "docs").rglob("*.md"))]
    assert {path.name for path in PICTURES.iterdir()} - set(
        re.findall(r"pictures/([\w.-]+)", "".join(texts))
    ) == set()
    assert sum(path.stat().st_size for path in PICTURES.iterdir()) <= LARGEST
    assert (PICTURES / "page.webp").stat().st_size <= FILM


def test_the_gallery_shows_each_robot_of_the_package():
    shown = re.findall(r"\]\(pictures/(\w+)\.webp\)\]\(\.\./conf/robot/\1\.yaml\)", text("docs/gallery.md"))
    assert set(shown) == set(robots.gallery())
