"""Replies that lack a part which the robot needs: refused, not kept, and asked for anew."""

import json
from dataclasses import replace
from types import SimpleNamespace

import pytest

from linkwright.stages.fetch.bundle.archive import pack
from linkwright.stages.fetch.onshape.gather import digest
from linkwright.stages.formats import triangles
from linkwright.stages.formats.meshes import body_arrays
from linkwright.stages.robot.errors import Offline, ProtocolError
from tests.fake_onshape import solids
from tests.fake_onshape.document import Document
from tests.fake_onshape.server import Fault, OnshapeServer
from tests.support.kept import Kept, fetched, onshape
from tests.support.traffic import targets_of

EMPTY = {"massproperties": [b'{"bodies":{}}'], "tessellatedfaces": [b"[]", b'{"bodies":[]}']}
CASES = [(kind, body) for kind, bodies in EMPTY.items() for body in bodies]


@pytest.fixture
def server():
    document = Document("Pair")
    studio, root = document.studio("Pair"), document.assembly("Pair")
    root.add(studio.part("One", solids.box(0.1, 0.1, 0.1), density=1000), fixed=True)
    root.add(studio.part("Two", solids.box(0.2, 0.1, 0.1), density=1000))
    with OnshapeServer(document) as server:
        yield server


def instead(server, kind, body, times=99):
    """Replies of this kind are `body`, so many `times`."""
    left = [Fault(200, body)] * times
    server.fault = lambda method, path, number: left.pop() if f"/{kind}?" in path and left else None


def build(server, kept, pin="m", **keys):
    server.reset()
    return fetched(onshape(server.document_url(pin), **keys), kept, server.environ)


@pytest.mark.parametrize(("kind", "body"), CASES)
def test_an_empty_reply_is_asked_for_once_more_and_refused_if_it_stays_so(server, kind, body):
    for pin in "mw":
        right, kept = build(server, Kept(), pin), Kept()
        instead(server, kind, body, times=1)
        made = build(server, kept, pin)
        assert (made.calls, made.bundle) == (4, right.bundle)
    right, kept = build(server, Kept()), Kept()
    instead(server, kind, body)
    with pytest.raises(ProtocolError, match=r"source.refresh=true is not needed") as caught:
        build(server, kept)
    assert len(targets_of(server, f"/{kind}?")) == 2
    studio = server.document.studios[0]
    for name in (*(part.id for part in studio.parts), studio.element):
        assert name in caught.value.message
    assert not any(f"/{kind}?" in request for request in kept)
    server.fault = None
    assert build(server, kept).bundle == right.bundle


@pytest.mark.parametrize("kind", EMPTY)
def test_a_reply_that_lacks_one_part_names_that_one(server, kind):
    second = server.document.studios[0].parts[1]
    kept = Kept()
    build(server, kept)
    request = next(request for request in kept if f"/{kind}?" in request)
    body = json.loads(server.replies.answer(*request.split("?")).body)
    if kind == "massproperties":
        del body["bodies"][second.id]
    else:
        body["bodies"] = [record for record in body["bodies"] if record["id"] != second.id]
    instead(server, kind, json.dumps(body).encode())
    with pytest.raises(ProtocolError, match=f"lack the parts {second.id};"):
        build(server, Kept())


@pytest.mark.parametrize("kind", EMPTY)
def test_an_incomplete_reply_that_was_kept_is_as_none(server, kind):
    kept = Kept()
    right = build(server, kept)
    request = next(request for request in kept if f"/{kind}?" in request)
    lacking = body_arrays.encode([]) if kind == "tessellatedfaces" else EMPTY[kind][0]
    kept[request] = lacking
    with pytest.raises(Offline, match="1 reply is not in the cache"):
        build(server, kept, offline=True)
    made = build(server, kept)
    assert (made.calls, made.bundle) == (1, right.bundle)
    assert kept[request] != lacking
    assert build(server, kept).calls == 0


def test_incomplete_replies_of_an_earlier_state_are_not_taken_over(server):
    kept = Kept()
    build(server, kept, "w")
    for request in list(kept):
        if "/tessellatedfaces?" in request:
            kept[request] = body_arrays.encode([])
    server.edit(server.document.edited("Pair"))
    made = build(server, kept, "w")
    body = made.bundle.body(made.bundle.studios[0].tessellation)
    assert triangles.ids_with_triangles(body) == {part.id for part in server.document.studios[0].parts}


def test_a_solid_without_volume_may_lack_triangles(server):
    kept = Kept()
    build(server, kept)
    first, second = server.document.studios[0].parts
    mass = next(request for request in kept if "/massproperties?" in request)
    faces = next(request for request in kept if "/tessellatedfaces?" in request)
    flat = json.loads(kept[mass])
    flat["bodies"][second.id]["volume"] = [0.0, 0.0, 0.0]
    kept[mass] = json.dumps(flat).encode()
    kept[faces] = body_arrays.encode([body_arrays.decode(kept[faces])[first.id]])
    assert build(server, kept).calls == 0


def test_a_recording_may_lack_triangles(server, tmp_path):
    bundle = build(server, Kept()).bundle
    (studio,) = bundle.studios
    empty = body_arrays.encode([])
    renamed = {studio.tessellation: digest(empty)}
    blobs = {name: bundle.blobs[name] for name in bundle.blobs if name not in renamed} | {
        digest(empty): empty
    }
    lacking = replace(
        bundle,
        studios=(replace(studio, tessellation=digest(empty)),),
        requests={request: renamed.get(name, name) for request, name in bundle.requests.items()},
        blobs=blobs | {digest(empty): empty},
    )
    path = tmp_path / "pair.zip"
    path.write_bytes(pack(lacking))
    recording = SimpleNamespace(source=SimpleNamespace(kind="bundle", path=str(path)))
    assert fetched(recording).bundle == lacking
