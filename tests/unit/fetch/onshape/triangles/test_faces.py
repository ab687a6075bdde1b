"""Replies with triangles: read piece by piece, kept in a compact form, asked for by part or as glTF."""

import json
import tracemalloc
from hashlib import sha256

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from linkwright.stages.fetch.onshape.triangles import faces, json_stream
from linkwright.stages.fetch.onshape.triangles.json_stream import Document, MalformedError, Pieces
from linkwright.stages.formats import triangles as codec
from linkwright.stages.formats.meshes import body_arrays
from linkwright.stages.robot.errors import ProtocolError


def plain(value):
    """What was read, with all large arrays as lists."""
    if isinstance(value, Pieces | list):
        return [plain(item) for item in value]
    return {key: plain(item) for key, item in value.items()} if isinstance(value, dict) else value


texts = st.text(st.sampled_from('ab"\\[]{},:\n é\0'), max_size=6)
values = st.recursive(
    st.none() | st.booleans() | st.integers(-9, 9) | st.floats(-1, 1) | texts,
    lambda inner: (
        st.lists(st.dictionaries(texts, inner, max_size=3), max_size=4)
        | st.lists(st.lists(st.integers(-9, 9), max_size=3), max_size=4)
        | st.dictionaries(texts, inner, max_size=4)
    ),
    max_leaves=25,
)


@pytest.mark.slow
@settings(max_examples=300, deadline=None)
@given(value=values, run=st.integers(1, 60), block=st.integers(1, 70), spaced=st.booleans())
def test_a_text_read_in_pieces_is_what_it_is_read_at_once(value, run, block, spaced):
    text = json.dumps(value, ensure_ascii=False, indent=1 if spaced else None).encode()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(json_stream, "_RUN_SIZE", run)
        patch.setattr(json_stream, "_BLOCK", block)
        assert plain(Document(text).root()) == value


@settings(max_examples=200, deadline=None)
@given(st.data())
def test_a_harmed_text_is_refused_or_read_as_json(data):
    text = json.dumps({"bodies": [{"id": "a]", "n": [[1, 2], [3, 4]]}, {"id": 'b"', "n": [{}, {}]}]}).encode()
    cut = data.draw(st.integers(0, len(text) - 1))
    changed = text[:cut] + data.draw(st.sampled_from([b"", b"]", b"}", b'"', b",", b"\\"])) + text[cut + 1 :]
    for harmed in (text[:cut], changed):
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(json_stream, "_RUN_SIZE", 8)
            patch.setattr(json_stream, "_BLOCK", 16)
            try:
                value = plain(Document(harmed).root())
            except MalformedError:
                continue
        assert value == json.loads(harmed)


def lattice(rows, columns, form):
    """A reply with one body of 2 × rows × columns triangles; each row is a face."""
    faces, table = [], []
    for row in range(rows):
        facets = []
        for column in range(columns):
            corners = [(row + i, column + j) for i, j in ((0, 0), (1, 0), (1, 1), (0, 1))]
            points = [{"x": x / 977, "y": y / 991, "z": (x * y % 7) / 983} for x, y in corners]
            for picked in ((0, 1, 2), (0, 2, 3)):
                if form == "table":
                    facets.append({"indices": [len(table) + corner for corner in picked]})
                else:
                    facets.append({"vertices": [points[corner] for corner in picked]})
            table += points
        colour = {"color": [row % 5, 0, 0], "opacity": 255}
        faces.append({"id": f"J{row}", "appearance": colour, "facets": facets})
    body = {"id": "JHD", "faces": faces, "facetPoints": table if form == "table" else []}
    return json.dumps({"bodies": [body], "facetPoints": []}, separators=(",", ":")).encode()


@pytest.mark.parametrize("form", ["table", "loose"])
def test_a_large_reply_takes_little_more_memory_than_itself(form):
    reply = lattice(120, 120, form)
    assert len(reply) > 4e6
    faces.compact(lattice(2, 2, form))  # what is imported only once
    tracemalloc.start()
    try:
        compact = faces.compact(reply)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert len(reply) + peak < 3 * len(reply)
    assert len(compact) < len(reply) / 5
    body = body_arrays.decode(compact)["JHD"]
    assert body.triangles.shape == (2 * 120 * 120, 3)
    assert body.points.shape == (121 * 121, 3)
    assert len(body.palette) == 5


def test_pieces_of_any_size_give_the_same_bytes_everywhere(monkeypatch):
    replies = [lattice(6, 7, form) for form in ("table", "loose")]
    whole = [faces.compact(reply) for reply in replies]
    assert whole[0] == whole[1]
    for run in (40, 200, 3000):
        monkeypatch.setattr(json_stream, "_RUN_SIZE", run)
        monkeypatch.setattr(faces, "_BATCH", run // 40)
        assert [faces.compact(reply) for reply in replies] == whole
    monkeypatch.setattr(json_stream, "_RUN_SIZE", 8)
    with pytest.raises(MalformedError, match="does not end after its last element"):
        plain(Document(b"[[1, 2, 3], [4, 5, 6],]").root())
    compact = faces.compact(lattice(2, 3, "table"))
    assert faces.compact(compact) is compact
    assert body_arrays.encode(list(body_arrays.decode(compact).values())) == compact
    assert sha256(compact).hexdigest() == DIGEST


DIGEST = "6a559681bea35ec48da0f0c6868d0fcbedfcd4007f4b4d5eca18546c98521898"


@settings(max_examples=100, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_a_harmed_compact_form_is_refused_or_in_range(seed):
    rng = np.random.default_rng(seed)
    compact = bytearray(faces.compact(lattice(2, 3, "table")))
    compact[rng.integers(len(compact))] = rng.integers(256)
    for harmed in (bytes(compact), bytes(compact[: rng.integers(len(compact))])):
        try:
            bodies = body_arrays.decode(harmed)
        except ProtocolError:
            continue
        for body in bodies.values():
            assert np.isfinite(body.points[body.triangles]).all()
            assert (body.colours < len(body.palette)).all()


def test_bodies_are_found_by_name_and_only_those_wanted_are_read():
    box = {"faces": [{"facets": [{"vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0]]}]}]}
    reply = json.dumps(
        [{"id": "A", **box}, {"id": "B", **box}, {"id": "A"}, {"id": "C"}, {"id": 7}, 8]
    ).encode()
    compact = faces.compact(reply)
    assert codec.ids_with_triangles(compact) == {"A", "B"}
    assert set(body_arrays.decode(compact)) == {"A", "B", "C"}
    assert set(body_arrays.decode(compact, {"B", "D"})) == {"B"}
    assert len(body_arrays.decode(compact)["A"].triangles) == 1


@pytest.mark.parametrize(
    ("reply", "why"),
    [
        (b"", "not JSON"),
        (b"null", "no bodies"),
        (b"{}", "no bodies"),
        (b'{"bodies": 7}', "no bodies"),
        (b'{"bodies": [{"id": "A", "faces": [7]}]}', "part A"),
        (b'[{"id": "A", "faces": [{"facets": [{"vertices": [[0, 0]]}]}]}]', "three coordinates"),
        (b'[{"id": "A", "faces": [{"facets": [{"vertices": [[0, 0, 1e999]]}]}]}]', "JSON"),
        (b'[{"id": "A", "faces": [{"facets": [{"indices": [0, 1]}]}], "facetPoints": [[0,0,0]]}]', "outside"),
    ],
)
def test_a_reply_without_triangles_is_reported(reply, why):
    with pytest.raises(ProtocolError) as caught:
        faces.compact(reply)
    assert why in str(caught.value)
