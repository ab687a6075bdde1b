"""The view's files, the bytes of a pack, and what becomes of both in a page."""

import gzip
import hashlib
import json
import re
import struct
from base64 import b64decode
from html.parser import HTMLParser

import pytest

from linkwright.stages.show.live.pack import Buffers, pack_bytes, read_pack
from linkwright.stages.show.live.viewer import ROOM, SCRIPTS, engine_script, script, view

ENGINE = ROOM / "engine"
FILES = json.loads((ENGINE / "engine.json").read_text())
PACK = gzip.compress(b"a pack", mtime=0)

LINES = 315
"""As of a module."""


class Scripts(HTMLParser):
    """The scripts of a page: their attributes and texts."""

    def __init__(self, text):
        super().__init__()
        self.attributes, self.texts = [], []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        if tag == "script":
            self.attributes.append(dict(attributes))
            self.texts.append("")

    def handle_data(self, data):
        if self.cdata_elem == "script":
            self.texts[-1] += data


@pytest.mark.parametrize("name", sorted(FILES))
def test_file_of_the_engine_has_its_digest(name):
    content = (ENGINE / name).read_bytes()
    assert hashlib.sha256(content).hexdigest() == FILES[name]["sha256"]
    original = gzip.decompress(content)
    assert hashlib.sha256(original).hexdigest() == FILES[name]["sha256_original"]
    assert len(original) == FILES[name]["bytes"]
    assert content[4:8] == bytes(4), "the time in the header: compress with gzip -n"


def test_compressed_files_are_named_and_have_their_licences():
    # The list of what the engine's MJCF knows is our own, not a file of the engine.
    assert {path.name for path in ENGINE.glob("*.gz") if not path.name.startswith("mjcf-")} == set(FILES)
    texts = {name: gzip.decompress((ENGINE / name).read_bytes()) for name in FILES if "LICENSE" in name}
    assert b"Apache License" in texts["mujoco.LICENSE.gz"]
    assert b"three.js authors" in texts["three.LICENSE.gz"]
    assert len(texts["mujoco.LICENSES_THIRD_PARTY.md.gz"]) > 100_000


def test_every_script_has_its_place_and_can_be_read_at_once():
    paths = {path.stem: path for path in (ROOM / "script").glob("*.js")}
    assert sorted(SCRIPTS) == sorted(paths)
    lengths = {name: len(path.read_text().splitlines()) for name, path in paths.items()}
    assert {name: lines for name, lines in lengths.items() if lines > LINES} == {}


def test_script_ends_no_element_and_imports_nothing():
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
def test_page_holds_what_it_runs(engine, pieces):
    page = view(PACK, engine, "../linkwright-engine.js" if engine == "shared" else "")
    scripts = Scripts(page.body + page.scripts)
    texts = {entry.get("id"): text for entry, text in zip(scripts.attributes, scripts.texts, strict=True)}
    assert set(texts) - {None} == pieces
    sources = [entry["src"] for entry in scripts.attributes if "src" in entry]
    assert sources == ["../linkwright-engine.js"] * (engine == "shared")
    assert b64decode(texts["robot-pack"]) == PACK
    assert page.body.count("<!-- preview -->") == 1
    without = view(None, engine)
    assert {without.style, without.body, without.scripts} == {""}


def test_shared_engine_is_that_of_a_whole_page():
    text = engine_script().decode()
    shared = json.loads(text.removeprefix("globalThis.linkwrightEngine = ").removesuffix(";\n"))
    assert b64decode(shared["wasm"]) == (ENGINE / "mujoco.wasm.gz").read_bytes()
    assert b64decode(shared["glue"]) == (ENGINE / "mujoco.js.gz").read_bytes()
    assert len(shared["licences"]) == 2
    assert engine_script() == engine_script()


def test_pack_is_a_length_a_header_and_aligned_buffers():
    buffers = Buffers()
    places = [buffers.add(b"abc"), buffers.add(b"defgh"), buffers.add(b"abc")]
    assert places == [0, 4, 0]
    whole = gzip.decompress(pack_bytes({"name": "</script>é"}, buffers))
    (length,) = struct.unpack("<I", whole[:4])
    assert length % 4 == 0
    assert json.loads(whole[4 : 4 + length]) == {"name": "</script>é"}
    assert whole[4 + length :] == b"abc\0defgh\0\0\0"


def test_packs_are_read_back_and_equal_packs_are_equal_bytes():
    buffers = Buffers()
    buffers.add(b"1234")
    assert read_pack(pack_bytes({"a": [1, 2.5]}, buffers)) == ({"a": [1, 2.5]}, b"1234")
    assert pack_bytes({"a": 1}, Buffers()) == pack_bytes({"a": 1}, Buffers())
