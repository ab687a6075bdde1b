"""Every block of the documents does what it shows."""

import os
import re

import pytest
from filelock import FileLock

from tests.docs.blocks import MARKS, REASONS, blocks, pages, parsed
from tests.docs.session import Session, Wrong, compare, run
from tests.support import kept_colliders
from tests.support.places import PROJECT

MOST_NOT_RUN = 15

EVERY = [block for page in pages() for block in blocks(page)]

FIRST_STEPS = ("README.md", "docs/start/index.md", "docs/start/urdf.md")

PAGES = [pytest.param(page, marks=[pytest.mark.slow] * (page not in FIRST_STEPS)) for page in pages()]


def slow(page):
    return any("slow" in block.marks for block in blocks(page))


@pytest.fixture(scope="session")
def cache(tmp_path_factory):
    """A cache for all pages of a run, which knows the colliders of the sample."""
    base = tmp_path_factory.getbasetemp()
    folder = (base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / "cache-of-documents"
    with FileLock(f"{folder}.lock"):
        if not folder.exists():
            kept_colliders.seed(folder)
    return folder


@pytest.mark.e2e
@pytest.mark.parametrize("page", PAGES)
def test_the_blocks_of_a_page_do_what_they_show(page, tmp_path, cache):
    """Up to the first slow block."""
    quick = blocks(page)
    first = next((n for n, block in enumerate(quick) if "slow" in block.marks), len(quick))
    with Session(tmp_path, cache) as session:
        run(session, quick[:first])


@pytest.mark.slow
@pytest.mark.e2e
@pytest.mark.parametrize("page", [page for page in pages() if slow(page)])
def test_the_slow_blocks_of_a_page_do_what_they_show(page, tmp_path, cache):
    with Session(tmp_path, cache) as session:
        run(session, blocks(page))


def test_every_mark_is_known_and_few_blocks_are_not_run():
    """A test that runs a block by itself may know it by a mark of its own; it names the block's page."""
    not_run = []
    for block in EVERY:
        if name := block.marks.get("tested by"):
            text = (PROJECT / name).read_text(encoding="utf-8")
            assert block.page in text or name == ".ci/run", block.place
        else:
            assert {*block.marks} <= MARKS, block.place
        if "not run" in block.marks:
            assert block.marks["not run"].startswith(REASONS), block.place
            not_run.append(block.place)
    assert len(not_run) <= MOST_NOT_RUN


def test_an_output_is_compared_whole():
    (block,) = parsed("page.md", "```text\n```\n")
    compare(block, "a\n...\nb ... s\n", "a\n1\n2\nb 3.5 s\n")
    compare(block, "a\n...\n", "a\n")
    for shown in ("a\n", "a\n...\nc\n", "b 3.5 s\n...\n"):
        with pytest.raises(Wrong):
            compare(block, shown, "a\n1\n2\nb 3.5 s\n")


@pytest.mark.parametrize(("text", "message"), [
    ("```sh\nfalse\n```\n", "exit status 1, expected 0"),
    ("<!-- exit: 2 -->\n```sh\ntrue\n```\n", "exit status 0, expected 2"),
    ("```sh\necho a\n```\n\n```text\nb\n```\n", "but the output is\n\na"),
    ("```console\n$ echo a\nb\n```\n", "but the output is\n\na"),
    ("```yaml\njoints: {elbo: {damping: 1}}\n```\n", "elbo"),
    ("```python\nprint(1)\n```\n\n```text\n2\n```\n", "but the output is\n\n1"),
    ("<!-- output -->\n```text\n2\n```\n", "no block before it has an output"),
    ("<!-- file: robot/a.yaml -->\n```yaml\n# @package _global_\nroot: 5\n```\n", "root"),
])  # fmt: skip
def test_a_block_that_does_something_else_is_found(text, message, tmp_path, cache):
    with Session(tmp_path, cache) as session, pytest.raises(Wrong, match=re.escape(message)):
        run(session, parsed("page.md", text))


def test_the_environment_stays_from_block_to_block(tmp_path, cache):
    text = (
        "```sh\nexport A=1; mkdir b; cd b\n```\n```console\n$ echo $A; basename $PWD\n1\nb\n```\n"
        "```python\nx = 2\n```\n```python\nprint(x)\n```\n```text\n2\n```\n"
        "<!-- folder -->\n```sh\nls; echo $A\n```\n```text\nso101.urdf\n1\n```\n"
    )
    with Session(tmp_path, cache) as session:
        run(session, parsed("page.md", text))


def test_the_placeholders_are_the_local_onshape(tmp_path, cache):
    text = (
        "```sh\nexport ONSHAPE_ACCESS_KEY=...  ONSHAPE_SECRET_KEY=...\n```\n"
        "<!-- file: robot/a.yaml -->\n```yaml\n# @package _global_\ndefaults: [override /source: onshape]\n"
        'source: {url: "https://cad.onshape.com/documents/.../w/.../e/..."}\n```\n'
        "```console\n$ linkwright robot=a until=fetch -q\n$ grep url robot/a.yaml\n"
        'source: {url: "https://cad.onshape.com/documents/.../w/.../e/..."}\n```\n'
    )
    with Session(tmp_path, cache) as session:
        run(session, parsed("page.md", text))
        assert session.server.count > 0
