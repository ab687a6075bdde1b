"""The local Onshape over HTTP: paths, auth, errors, headers, counting."""

import base64
import gzip
import json
from http.client import HTTPConnection
from urllib.parse import urlsplit

import pytest

from linkwright.stages.fetch.onshape.api.credentials import Credentials
from linkwright.stages.fetch.onshape.api.signing import headers
from tests.fake_onshape.auth import Gate
from tests.fake_onshape.bundle import requests
from tests.fake_onshape.replies import Replies
from tests.fake_onshape.sample import sample_document
from tests.fake_onshape.server import TOKEN, Fault, OnshapeServer


@pytest.fixture(scope="module")
def document():
    return sample_document()


@pytest.fixture
def server(document):
    with OnshapeServer(document) as running:
        yield running


def get(server, target, keys=None, method="GET"):
    """(status, parsed body, headers)."""
    connection = HTTPConnection(urlsplit(server.url).netloc, timeout=10)
    token = base64.b64encode(":".join(keys or server.keys).encode()).decode()
    connection.request(method, target, headers={"Authorization": f"Basic {token}"})
    reply = connection.getresponse()
    body = reply.read()
    connection.close()
    return reply.status, json.loads(body), dict(reply.getheaders())


def assembly(document, kind="w", element=None):
    state = {"w": document.workspace, "v": document.version, "m": document.microversion}[kind]
    return f"/api/v16/assemblies/d/{document.id}/{kind}/{state}/e/{element or document.root.element}"


def test_what_a_build_asks_is_served_byte_for_byte_and_counted(server, document):
    definition, studios = requests(document)
    for request in [definition, *studios]:
        status, body, _ = get(server, f"/api/v17{request}")
        assert status == 200
        assert body == json.loads(Replies(document).answer(*request.split("?")).body)
    assert server.count == 1 + 2 * 4
    assert [status for _, _, status in server.calls] == [200] * 9
    server.reset()
    assert server.count == 0


@pytest.mark.parametrize("kind", ["w", "v", "m"])
def test_the_definition_is_there_for_workspace_version_and_microversion(server, document, kind):
    status, body, headers = get(server, assembly(document, kind) + "?includeMateFeatures=true")
    assert status == 200
    assert body["rootAssembly"]["documentMicroversion"] == document.microversion
    assert body["rootAssembly"]["features"]
    assert headers["Content-Type"] == "application/json;charset=UTF-8"
    assert headers["X-Api-Version"] == "v16"
    assert int(headers["X-Rate-Limit-Remaining"]) == 1000 - 1


@pytest.mark.parametrize(
    ("newest", "asked", "served", "resolved"),
    [(17, 16, 16, False), (17, 17, 17, True), (17, 99, 17, True), (16, 17, 16, False)],
)
def test_limits_are_in_the_definition_from_v17_and_what_is_not_known_gets_the_newest(
    document, newest, asked, served, resolved
):
    with OnshapeServer(document, newest=newest) as server:
        target = assembly(document).replace("/v16/", f"/v{asked}/") + "?includeMateFeatures=true"
        _, body, headers = get(server, target)
    assert headers["X-Api-Version"] == f"v{served}"
    mates = [one for one in body["rootAssembly"]["features"] if one["featureType"] == "mate"]
    assert {"mateLimits" in one["featureData"] for one in mates} == {resolved}


def test_features_come_only_when_asked_and_a_configuration_is_passed_through(server, document):
    _, body, _ = get(server, assembly(document) + "?configuration=size%3D2")
    assert body["rootAssembly"]["features"] == []
    assert body["rootAssembly"]["configuration"] == "size=2"


@pytest.mark.parametrize("keys", [("wrong", "a-secret-key"), ("an-access-key", "wrong")])
def test_wrong_keys_are_refused_and_not_billed(server, document, keys):
    status, body, _ = get(server, assembly(document), keys=keys)
    assert (status, body["status"]) == (401, 401)
    assert server.count == 0
    assert len(server.calls) == 1


def test_other_keys_can_be_set(document):
    with OnshapeServer(document, keys=("mine", "own")) as server:
        assert get(server, assembly(document))[0] == 200
        keys = {"ONSHAPE_ACCESS_KEY": "mine", "ONSHAPE_SECRET_KEY": "own"}
        assert server.environ == {**keys, "LINKWRIGHT_HOST": server.url}


def test_a_part_studio_is_no_assembly_nor_the_other_way_round(server, document):
    status, body, _ = get(server, assembly(document, element=document.studios[0].element))
    assert (status, body["message"]) == (400, "The element is not an assembly.")
    target = assembly(document).replace("/assemblies/", "/partstudios/") + "/massproperties"
    status, body, _ = get(server, target)
    assert (status, body["message"]) == (400, "The element is not a part studio.")


def test_what_does_not_exist_is_404_with_a_message(server, document):
    nowhere = "0" * 24
    for target in (
        assembly(document).replace(document.id, nowhere),
        assembly(document).replace(document.workspace, nowhere),
        assembly(document, element=nowhere),
        "/api/v16/nothing",
        "/",
    ):
        status, body, _ = get(server, target)
        assert (status, body["status"]) == (404, 404)
        assert body["message"]


def test_unknown_and_malformed_queries_and_parts_are_400(server, document):
    studio = f"/api/v16/partstudios/d/{document.id}/w/{document.workspace}/e/{document.studios[0].element}"
    for target in (
        assembly(document) + "?includeSuppressed=true",
        assembly(document) + "?includeMateFeatures=yes",
        studio + "/massproperties?partId=nope",
    ):
        assert get(server, target)[0] == 400


def test_a_linked_document_needs_the_document_it_is_linked_from(server, document):
    request = next(request for request in requests(document)[1] if "/v/" in request)
    assert get(server, f"/api/v16{request}")[0] == 200
    assert get(server, f"/api/v16{request}".replace("linkDocumentId", "configuration"))[0] == 403


def test_microversion_and_elements_are_reported(server, document):
    base = f"/api/v16/documents/d/{document.id}/w/{document.workspace}"
    assert get(server, f"{base}/currentmicroversion")[1] == {"microversion": document.microversion}
    listed = get(server, f"{base}/elements?elementType=ASSEMBLY")[1]
    assert {record["name"] for record in listed} == {"Desk arm", "Gripper", "Finger"}
    assert len({record["microversionId"] for record in listed}) == 3


def test_a_fault_takes_a_replys_place(document):
    def second_call_fails(method, target, number):
        return Fault(429, b'{"message":"Too many requests."}', {"Retry-After": "7"}) if number == 1 else None

    with OnshapeServer(document, fault=second_call_fails) as server:
        answers = [get(server, assembly(document)) for _ in range(3)]
    assert [status for status, _, _ in answers] == [200, 429, 200]
    assert answers[1][2]["Retry-After"] == "7"
    assert server.count == 2


def test_one_connection_serves_many_calls(server, document):
    connection = HTTPConnection(urlsplit(server.url).netloc, timeout=10)
    token = base64.b64encode(":".join(server.keys).encode()).decode()
    sockets = set()
    for _ in range(3):
        connection.request("GET", assembly(document), headers={"Authorization": f"Basic {token}"})
        reply = connection.getresponse()
        sockets.add(connection.sock.getsockname())
        reply.read()
    connection.close()
    assert len(sockets) == 1


def test_other_methods_are_refused(server, document):
    assert get(server, assembly(document), method="DELETE")[0] == 405


def test_the_browsers_address_names_document_state_and_element(server, document):
    for kind in "wvm":
        url = server.document_url(kind)
        assert url.startswith(server.url + "/documents/" + document.id + f"/{kind}/")
        assert url.endswith("/e/" + document.root.element)


def test_a_body_is_packed_where_the_client_takes_that(server, document):
    connection = HTTPConnection(urlsplit(server.url).netloc, timeout=10)
    headers = {"Authorization": f"Bearer {TOKEN}", "Accept-Encoding": "gzip"}
    connection.request("GET", assembly(document), headers=headers)
    reply = connection.getresponse()
    packed = reply.read()
    connection.close()
    assert reply.getheader("Content-Encoding") == "gzip"
    assert int(reply.getheader("Content-Length")) == len(packed)
    assert json.loads(gzip.decompress(packed)) == get(server, assembly(document))[1]


@pytest.fixture
def signed():
    return headers(Credentials("acc", "sec", "signature"), "GET", "/api/v16/x?a=b")


@pytest.mark.parametrize(
    ("broken", "why"),
    [
        ({"On-Nonce": "short"}, "nonce"),
        ({"Date": "Mon, 02 Mar 2020 10:11:12 GMT"}, "too far"),
        ({"Date": "today"}, "date"),
        ({"Content-Type": "text/plain"}, "signature"),
    ],
)
def test_a_signature_holds_for_the_headers_it_was_made_for(signed, broken, why):
    assert why in Gate(("acc", "sec"), "token").refuses("GET", "/api/v16/x?a=b", {**signed, **broken})


def test_a_signature_holds_for_one_request_and_once(signed):
    gate = Gate(("acc", "sec"), "token")
    assert "signature" in gate.refuses("GET", "/api/v16/x?a=c", signed)
    assert gate.refuses("GET", "/api/v16/x?a=b", signed) == ""
    assert "nonce" in gate.refuses("GET", "/api/v16/x?a=b", signed)
