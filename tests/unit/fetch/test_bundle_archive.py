"""Bundles: packed to the same bytes, and read with distrust."""

import io
import json
import random
import stat
import tracemalloc
import zipfile
from hashlib import sha256
from types import SimpleNamespace

import pytest

from linkwright.stages.fetch.bundle import archive as module
from linkwright.stages.fetch.bundle.archive import pack, read
from linkwright.stages.fetch.bundle.source import BundleSource
from linkwright.stages.robot.bundle import OnshapeBundle
from linkwright.stages.robot.errors import SourceError

BODIES = [b'{"a": 1}', b'{"b": 2}']
DIGESTS = [sha256(body).hexdigest() for body in BODIES]
ROOT = {"document": "d", "microversion": "m", "element": "e", "configuration": "default"}
MANIFEST = {
    "format": 1,
    "kind": "onshape",
    "api": "v16",
    "root": ROOT,
    "definition": DIGESTS[0],
    "requests": {"/one?x=1": DIGESTS[0], "/two?x=1": DIGESTS[1]},
}
GOOD = {"manifest.json": json.dumps(MANIFEST).encode()} | {
    f"replies/{digest}": body for digest, body in zip(DIGESTS, BODIES, strict=True)
}


def zipped(entries, method=zipfile.ZIP_DEFLATED):
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", method) as archive:
        for name, body in entries.items() if isinstance(entries, dict) else entries:
            archive.writestr(name, body)
    return out.getvalue()


def refused(data, why):
    with pytest.raises(SourceError) as caught:
        read(data, "robots/arm.zip")
    assert caught.value.where == "robots/arm.zip"
    assert why in caught.value.message
    assert caught.value.hint


def refused_within(most, data, why):
    """Asserts that no more than this number of bytes is used meanwhile."""
    tracemalloc.start()
    try:
        refused(data, why)
        assert tracemalloc.get_traced_memory()[1] < most
    finally:
        tracemalloc.stop()


def test_a_packed_bundle_is_read_back_and_packs_the_same():
    blobs = dict(zip(DIGESTS, BODIES, strict=True))
    parts = (ROOT, MANIFEST["requests"], blobs)
    forwards, backwards = (
        OnshapeBundle("onshape", root, DIGESTS[0], requests, replies, api="v16", studios=())
        for root, requests, replies in (parts, (dict(reversed(part.items())) for part in parts))
    )
    assert pack(forwards) == pack(backwards)
    again = read(pack(forwards), "x.zip")
    assert (again.root, again.definition) == (ROOT, DIGESTS[0])
    assert (again.requests, again.blobs) == (MANIFEST["requests"], forwards.blobs)
    # A folder entry that zip tools add is harmless.
    assert read(zipped({"replies/": b"", **GOOD}), "x.zip").definition == DIGESTS[0]


def test_a_file_that_is_no_zip_or_was_changed_is_refused():
    refused(b"", "not a zip file")
    refused(b"<html>sign in</html>", "not a zip file")
    data = zipped(GOOD, zipfile.ZIP_STORED)
    refused(data[:-30], "not a zip file")
    refused(data.replace(BODIES[0], b'{"a": 7}'), "damaged")


def test_entries_of_odd_names_links_or_methods_are_refused():
    for name in (
        *("../evil", "replies/../../evil", "/etc/passwd", "C:\\evil", "..\\evil"),
        *("replies/..\\evil", "\\evil"),
    ):
        refused(zipped({**GOOD, name: b"x"}), "points outside")
    refused(zipped({**GOOD, "replies/readme.txt": b"x"}), "neither manifest.json nor")
    link = zipfile.ZipInfo(f"replies/{'0' * 64}")
    link.external_attr = (stat.S_IFLNK | 0o777) << 16
    refused(zipped([*GOOD.items(), (link, b"/etc/passwd")]), "is a link")
    with pytest.warns(UserWarning, match="Duplicate"):
        doubled = zipped([*GOOD.items(), ("manifest.json", b"{}")])
    refused(doubled, "occurs twice")
    for method in (zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA):  # they may ask for gigabytes
        refused(zipped(GOOD, method), "another method than deflate")


def test_a_file_too_large_is_refused_before_it_is_read(tmp_path):
    with (tmp_path / "arm.zip").open("wb") as file:
        file.truncate((1 << 30) + 1)
    source = SimpleNamespace(kind="bundle", path=str(tmp_path / "arm.zip"))
    with pytest.raises(SourceError, match="1073741825 bytes"):
        BundleSource(source).content()


def test_a_harmed_bundle_is_refused_or_read_as_it_was():
    good = zipped(GOOD)
    whole, chance = read(good, "x.zip"), random.Random(3)
    refusals = 0
    for _ in range(3000):
        harmed = bytearray(good)
        for _ in range(chance.randint(1, 3)):
            harmed[chance.randrange(len(harmed))] = chance.randrange(256)
        cut = chance.choice([len(good), chance.randrange(len(good))])
        try:
            assert read(bytes(harmed[:cut]), "x") == whole
        except SourceError:
            refusals += 1
    assert 1000 < refusals < 3000


def test_bombs_are_refused_before_they_are_inflated(monkeypatch):
    bomb = zipped({**GOOD, f"replies/{'0' * 64}": bytes(8 << 20)})
    refused(bomb, "compressed too strongly")
    monkeypatch.setattr(module, "MAX_BYTES", 1000)
    refused(zipped({**GOOD, f"replies/{'0' * 64}": bytes(2000)}), "would unpack to")
    monkeypatch.setattr(module, "_MAX_ENTRIES", 2)
    refused(zipped(GOOD), "3 entries")


def lying(entries, name, **sizes):
    """A zip whose directory, and whose entry itself, say other sizes of one entry."""
    data = bytearray(zipped(entries))
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        at = archive.getinfo(name).header_offset
    directory = data.index(name.encode(), data.index(b"PK\x01\x02")) - 46
    for place, first in ((at, 18), (directory, 20)):
        for offset, key in ((first, "packed"), (first + 4, "unpacked")):
            if key in sizes:
                data[place + offset : place + offset + 4] = sizes[key].to_bytes(4, "little")
    return bytes(data)


def test_an_entry_is_inflated_no_further_than_it_announces():
    """All of it would be 16 MB, whatever it says."""
    name = f"replies/{'0' * 64}"
    for claimed in (0, 10, 1000):
        refused_within(4 << 20, lying({**GOOD, name: bytes(16 << 20)}, name, unpacked=claimed), "")
    refused(lying(GOOD, "manifest.json", unpacked=1 << 20), "damaged")


def test_entries_are_counted_before_there_is_an_object_of_each():
    entry = zipped({"a": b""})
    start, end = entry.index(b"PK\x01\x02"), entry.index(b"PK\x05\x06")
    many = entry[start:end] * 50_000
    tail = bytearray(entry[end:])
    tail[8:12], tail[12:16] = b"\x01\x00\x01\x00", len(many).to_bytes(4, "little")
    refused_within(1 << 20, entry[:start] + many + bytes(tail), "more entries than")


def test_a_reply_is_no_larger_than_one_from_a_server():
    requests = {"/partstudios/d/D/m/M/e/E/massproperties?x=1": DIGESTS[1]}
    large = bytes(33 << 20)
    digest = sha256(large).hexdigest()
    manifest = {**MANIFEST, "requests": dict.fromkeys(requests, digest)}
    entries = {**GOOD, "manifest.json": json.dumps(manifest).encode(), f"replies/{digest}": large}
    refused(zipped(entries, zipfile.ZIP_STORED), "at most 33554432 are read")


def test_a_manifest_is_bounded_and_a_reply_is_what_its_name_says(monkeypatch):
    refused(zipped({**GOOD, f"replies/{DIGESTS[1]}": b'{"b": 3}'}), "does not match its digest")
    monkeypatch.setattr(module, "_MAX_MANIFEST", 100)
    refused(zipped(GOOD), "manifest.json would unpack to")


def test_a_missing_reply_is_named_with_its_request():
    entries = {name: body for name, body in GOOD.items() if name != f"replies/{DIGESTS[1]}"}
    refused(zipped(entries), "/two?x=1")
    refused(zipped({name: body for name, body in GOOD.items() if name != "manifest.json"}), "no manifest")


@pytest.mark.parametrize(
    ("manifest", "why"),
    [
        (b"{", "not JSON"),
        (b"[]", "not a JSON object"),
        (b"\xff\xfe", "not JSON"),
        (b'{"format": ' + b"[" * 100_000, "not JSON"),
        ({**MANIFEST, "root": {**ROOT, "element": "\ud800"}}, "malformed (root.element"),
        ({**MANIFEST, "format": 2}, "format 2, and this version reads 1"),
        ({**MANIFEST, "format": "one"}, "malformed (format"),
        ({**MANIFEST, "kind": "step"}, "malformed (kind"),
        ({**MANIFEST, "api": ""}, "malformed (: Value error, an Onshape assembly has an api"),
        ({**MANIFEST, "root": {**ROOT, "element": ""}}, "malformed (: Value error, an Onshape assembly"),
        ({**MANIFEST, "options": {"a": 1}}, "malformed (options"),
        ({**MANIFEST, "root": {**ROOT, "element": None}}, "malformed (root.element"),
        ({**MANIFEST, "definition": "../x"}, "malformed (definition"),
        ({**MANIFEST, "requests": {"/one": "short"}}, "malformed (requests"),
        ({key: value for key, value in MANIFEST.items() if key != "api"}, "malformed (api"),
    ],
)
def test_a_malformed_manifest_is_refused_by_the_key_at_fault(manifest, why):
    body = manifest if isinstance(manifest, bytes) else json.dumps(manifest).encode()
    refused(zipped({**GOOD, "manifest.json": body}), why)
