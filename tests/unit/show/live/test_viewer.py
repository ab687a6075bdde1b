"""The view's files, and what becomes of them in a page."""

import gzip
import hashlib
import json
import re
from base64 import b64decode
from html.parser import HTMLParser

import pytest

from linkwright.stages.show.live.viewer import ROOM, SCRIPTS, engine_script, script, view

ENGINE = ROOM / "engine"
FILES = json.loads((ENGINE / "engine.json").read_text())
PACK = gzip.compress(b"a pack", mtime=0)

LINES = 315
"""As of a module."""

SCHEMA = "mjcf-"
"""What the engine's MJCF knows: our own list, not a file of the engine."""


class Elements(HTMLParser):
    """The elements of a page with their attributes, and the texts in scripts."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.found: list[tuple[str, dict[str, str | None]]] = []
        self.scripts: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        self.found.append((tag, dict(attributes)))
        if tag == "script":
            self.scripts.append("")

    def handle_data(self, data: str) -> None:
        if self.found and self.found[-1][0] == "script" and self.cdata_elem:
            self.scripts[-1] += data


@pytest.mark.parametrize("name", sorted(FILES))
def test_a_file_of_the_engine_is_the_one_that_is_named(name):
    content = (ENGINE / name).read_bytes()
    assert hashlib.sha256(content).hexdigest() == FILES[name]["sha256"]
    original = gzip.decompress(content)
    assert hashlib.sha256(original).hexdigest() == FILES[name]["sha256_original"]
    assert len(original) == FILES[name]["bytes"]
    assert content[4:8] == bytes(4), "the time in the header: compress with gzip -n"


def test_every_compressed_file_is_named():
    there = {path.name for path in ENGINE.glob("*.gz") if not path.name.startswith(SCHEMA)}
    assert there == set(FILES)


def test_the_licences_are_those_of_the_engine():
    texts = {
        name: gzip.decompress((ENGINE / name).read_bytes()).decode() for name in FILES if "LICENSE" in name
    }
    assert "Apache License" in texts["mujoco.LICENSE.gz"]
    assert "three.js authors" in texts["three.LICENSE.gz"]
    assert len(texts["mujoco.LICENSES_THIRD_PARTY.md.gz"]) > 100_000


def test_every_script_has_its_place():
    assert sorted(SCRIPTS) == sorted(path.stem for path in (ROOM / "script").glob("*.js"))


def test_no_script_is_longer_than_can_be_read_at_once():
    lengths = {name: len((ROOM / f"script/{name}.js").read_text().splitlines()) for name in SCRIPTS}
    assert {name: lines for name, lines in lengths.items() if lines > LINES} == {}


def test_the_script_ends_no_element_and_imports_nothing():
    assert "</script" not in script().lower()
    assert "<!--" not in script()
    assert not re.search(r"^\s*(import|export)\b", script(), re.MULTILINE)
    assert not re.search(r"innerHTML|insertAdjacentHTML|document\.write", script())
    assert not re.search(r"\bfetch\(|XMLHttpRequest|https?://", script())


@pytest.mark.parametrize(
    ("engine", "pieces"),
    [
        ("whole", {"robot-pack", "linkwright-three", "linkwright-wasm", "linkwright-glue"}),
        ("shared", {"robot-pack", "linkwright-three"}),
        ("none", {"robot-pack", "linkwright-three"}),
    ],
)
def test_a_page_holds_what_it_runs(engine, pieces):
    found = view(PACK, engine, "../linkwright-engine.js" if engine == "shared" else "")
    elements = Elements(found.body + found.scripts)
    scripts = [attributes for tag, attributes in elements.found if tag == "script"]
    assert {one["id"] for one in scripts if one.get("id")} == pieces
    assert [one["src"] for one in scripts if "src" in one] == ["../linkwright-engine.js"] * (
        engine == "shared"
    )
    kept = dict(zip((one.get("id") for one in scripts), elements.scripts))
    assert b64decode(kept["robot-pack"]) == PACK
    assert found.body.count("<!-- preview -->") == 1


def test_nothing_without_a_pack():
    assert set(vars_of(view(None, "whole"))) == {""}


def vars_of(found):
    return [found.style, found.body, found.scripts]


def test_the_shared_engine_is_the_one_of_a_whole_page():
    text = engine_script().decode()
    shared = json.loads(text.removeprefix("globalThis.linkwrightEngine = ").removesuffix(";\n"))
    assert b64decode(shared["wasm"]) == (ENGINE / "mujoco.wasm.gz").read_bytes()
    assert b64decode(shared["glue"]) == (ENGINE / "mujoco.js.gz").read_bytes()
    assert len(shared["licences"]) == 2
    assert engine_script() == engine_script()
