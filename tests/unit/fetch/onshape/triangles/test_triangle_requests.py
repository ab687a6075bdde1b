"""Which triangles are asked for: only those used of a large part studio, glTF where faces are refused."""

import json
from urllib.parse import parse_qsl, quote

import numpy as np
import pytest

from linkwright.stages.fetch.bundle.archive import pack
from linkwright.stages.fetch.onshape.asking.triangle_requests import parts_to_request
from linkwright.stages.formats import triangles
from linkwright.stages.formats.meshes import body_arrays
from linkwright.stages.robot.errors import Offline, ProtocolError, QuotaExhausted
from tests.fake_onshape.bundle import bundle_bytes
from tests.fake_onshape.server import Fault, OnshapeServer
from tests.support.kept import Kept, fetched, onshape, recording
from tests.support.traffic import at_path, rack, targets_of


def parts_in(request):
    return [value for key, value in parse_qsl(request.partition("?")[2]) if key == "partId"]


@pytest.mark.parametrize(
    ("used", "unused", "some"), [(2, 9, True), (2, 8, False), (12, 13, True), (12, 12, False)]
)
def test_used_parts_alone_are_asked_for_among_many(used, unused, some, kept):
    document = rack(used, unused)
    ids = sorted(part.id for part in document.studios[0].parts[:used])
    with OnshapeServer(document) as server:
        outcome = fetched(onshape(server.document_url()), kept, server.environ)
        assert (outcome.calls, server.count) == (3, 3)
        (request,) = targets_of(server, "/tessellatedfaces?")
        assert parts_in(request) == (ids if some else [])
        body = outcome.bundle.body(outcome.bundle.studios[0].tessellation)
        assert triangles.ids_with_triangles(body) == (
            set(ids) if some else {p.id for p in document.studios[0].parts}
        )
        assert fetched(onshape(server.document_url("m")), kept).calls == 0
        again = fetched(onshape(server.document_url()), kept, server.environ)
        assert (again.calls, again.bundle) == (1, outcome.bundle)


def test_parts_that_are_no_solids_are_not_asked_for_by_id():
    record = {"volume": [1.0, 1.0, 1.0]}
    mass = json.dumps({"bodies": {f"P{i}": record for i in range(40)}}).encode()
    assert parts_to_request(["P1", "P2"], mass) == ("P1", "P2")
    assert parts_to_request(["P1", "Q"], mass) == ()
    assert parts_to_request(["P1"], None) == ()
    flat = {"bodies": {f"P{i}": record | ({"volume": [0.0] * 3} if i == 1 else {}) for i in range(40)}}
    assert parts_to_request(["P1", "P2"], json.dumps(flat).encode()) == ()
    many = json.dumps({"bodies": {f"P{i}": record for i in range(900)}}).encode()
    assert len(parts_to_request([f"P{i}" for i in range(200)], many)) == 200
    assert parts_to_request([f"P{i}" for i in range(201)], many) == ()  # a request line has its bounds


def test_a_kept_reply_for_all_parts_serves_for_some():
    document = rack(2, 20)
    kept, whole = Kept(), rack(2, 20)
    for part in whole.studios[0].parts[2:]:
        whole.root.add(part, fixed=True)
    with OnshapeServer(document) as server:
        server.replies = type(server.replies)(whole)
        fetched(onshape(server.document_url("m")), kept, server.environ)
        del kept[next(request for request in kept if request.startswith("/assemblies"))]
        server.replies = type(server.replies)(document)
        again = fetched(onshape(server.document_url("m")), kept, server.environ)
        assert (again.calls, again.saved) == (1, 2)


def test_a_server_that_forgets_parts_is_asked_for_all(kept):
    document = rack(2, 20)
    ids = sorted(part.id for part in document.studios[0].parts[:2])
    with OnshapeServer(document) as server:

        def first_part_only(method, path, number):
            if len(parts_in(path)) != 2:
                return None
            asked_for = path.removeprefix("/api/v16").replace(f"&partId={quote(ids[1], safe='')}", "")
            return Fault(200, server.replies.answer(*asked_for.split("?")).body)

        server.fault = first_part_only
        outcome = fetched(onshape(server.document_url("m")), kept, server.environ)
        assert [parts_in(request) for request in targets_of(server, "/tessellatedfaces?")] == [ids, []]
        body = outcome.bundle.body(outcome.bundle.studios[0].tessellation)
        assert set(ids) <= triangles.ids_with_triangles(body)
        assert fetched(onshape(server.document_url("m")), kept).bundle == outcome.bundle


def test_the_quality_is_part_of_what_is_kept(kept):
    with OnshapeServer(rack(1, 0)) as server:
        url = server.document_url("m")
        qualities = [{}, {"angle": 0.1}, {"chord": 0.001}, {"max_facet_width": 0.01}]
        calls = [
            fetched(onshape(url, tessellation=quality), kept, server.environ).calls
            for quality in [*qualities, *qualities]
        ]
        assert calls == [3, 1, 1, 1, 0, 0, 0, 0]
        first = dict(parse_qsl(targets_of(server, "/tessellatedfaces?")[0].partition("?")[2]))
    assert first["outputFacetNormals"] == "false"
    assert first["outputIndexTable"] == first["outputFaceAppearances"] == "true"
    assert "outputVertexNormals" not in first  # off unless asked for


@pytest.mark.parametrize("fault", [*map(Fault, (404, 406, 400, 415))])
def test_gltf_stands_in_for_tessellated_faces_that_are_refused(fault, tmp_path, kept):
    document = rack(3, 1)
    with OnshapeServer(document) as server:
        right = fetched(onshape(server.document_url("m")), Kept(), server.environ).bundle
        server.reset()
        server.fault = at_path(fault, "/tessellatedfaces")
        outcome = fetched(onshape(server.document_url("m")), kept, server.environ)
        assert outcome.calls == server.count
        assert [problem.code for problem in outcome.diagnostics] == ["I-TESSELLATION"]
        assert document.studios[0].element in outcome.diagnostics[0].where
        again = fetched(onshape(server.document_url("m")), kept)
        assert (again.calls, again.bundle) == (0, outcome.bundle)
        assert [problem.code for problem in again.diagnostics] == ["I-TESSELLATION"]
    ours, theirs = (
        body_arrays.decode(bundle.body(bundle.studios[0].tessellation)) for bundle in (outcome.bundle, right)
    )
    assert set(ours) == set(theirs)
    for name, body in theirs.items():
        assert np.abs(ours[name].points - body.points).max() < 1e-8
    (tmp_path / "rack.zip").write_bytes(pack(outcome.bundle))
    assert fetched(recording(tmp_path / "rack.zip")).bundle == outcome.bundle


def test_the_first_refusal_is_reported_if_gltf_is_refused_too(kept):
    with OnshapeServer(rack(2, 0)) as server:
        faces = at_path(Fault(400, b'{"message": "no faces"}'), "/tessellatedfaces")
        gltf = at_path(Fault(400, b'{"message": "no glTF"}'), "/gltf")
        server.fault = lambda *call: faces(*call) or gltf(*call)
        with pytest.raises(ProtocolError, match="no faces"):
            fetched(onshape(server.document_url("m")), kept, server.environ)
        assert len(targets_of(server, "/tessellatedfaces?")) == len(targets_of(server, "/gltf?")) == 1
        assert len(kept) == server.count == 2


@pytest.mark.parametrize(
    ("fault", "error"),
    [
        (Fault(402), QuotaExhausted),
        (Fault(silent=True), Offline),
        (Fault(500), ProtocolError),
        (Fault(200, b'{"bodies": ['), ProtocolError),
    ],
)
def test_a_failure_that_may_pass_is_no_reason_for_gltf(fault, error):
    """Else a bad moment of the network would decide what the robot looks like."""
    with OnshapeServer(rack(2, 0)) as server:
        server.fault = at_path(fault, "/tessellatedfaces")
        with pytest.raises(error):
            fetched(onshape(server.document_url("m")), Kept(), server.environ)
        assert targets_of(server, "/gltf?") == []


def test_some_parts_and_all_parts_give_the_same_triangles(tmp_path):
    document = rack(2, 20)
    with OnshapeServer(document) as server:
        live = fetched(onshape(server.document_url()), environ=server.environ).bundle
    zipped = {}
    for kind, data in (("live", pack(live)), ("raw", bundle_bytes(document))):
        path = tmp_path / f"{kind}.zip"
        path.write_bytes(data)
        zipped[kind] = fetched(recording(path)).bundle
    assert zipped["live"] == live
    bodies = [body_arrays.decode(b.body(b.studios[0].tessellation)) for b in (zipped["live"], zipped["raw"])]
    assert set(bodies[0]) < set(bodies[1])
    for name, body in bodies[0].items():
        assert body.points.tobytes() == bodies[1][name].points.tobytes()
        assert body.triangles.tobytes() == bodies[1][name].triangles.tobytes()
