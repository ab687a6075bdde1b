"""The local Onshape over HTTP: paths, auth, errors, headers, counting."""

import base64
import json
from http.client import HTTPConnection
from urllib.parse import urlsplit

import pytest

from linkwright.stages.fetch.onshape.api.credentials import Credentials
from linkwright.stages.fetch.onshape.api.signing import headers
from tests.fake_onshape.auth import Gate
from tests.fake_onshape.bundle import requests
from tests.fake_onshape.sample import sample_document
from tests.fake_onshape.server import OnshapeServer


@pytest.fixture(scope="module")
def document():
    return sample_document()


@pytest.fixture
def server(document):
    with OnshapeServer(document) as running:
        yield running


def get(server, target, keys=None):
    """(status, parsed body, headers)."""
    connection = HTTPConnection(urlsplit(server.url).netloc, timeout=10)
    token = base64.b64encode(":".join(keys or server.keys).encode()).decode()
    connection.request("GET", target, headers={"Authorization": f"Basic {token}"})
    reply = connection.getresponse()
    body = reply.read()
    connection.close()
    return reply.status, json.loads(body), dict(reply.getheaders())


def assembly(document, element=None):
    state = f"d/{document.id}/w/{document.workspace}"
    return f"/api/v16/assemblies/{state}/e/{element or document.root.element}"


@pytest.mark.parametrize(
    ("newest", "asked", "served", "resolved"),
    [(17, 16, 16, False), (17, 17, 17, True), (17, 99, 17, True), (16, 17, 16, False)],
)
def test_limits_are_in_the_definition_from_v17_on(document, newest, asked, served, resolved):
    with OnshapeServer(document, newest=newest) as server:
        target = assembly(document).replace("/v16/", f"/v{asked}/") + "?includeMateFeatures=true"
        _, body, headers = get(server, target)
    assert headers["X-Api-Version"] == f"v{served}"
    mates = [feature for feature in body["rootAssembly"]["features"] if feature["featureType"] == "mate"]
    assert {"mateLimits" in mate["featureData"] for mate in mates} == {resolved}


@pytest.mark.parametrize("keys", [("wrong", "a-secret-key"), ("an-access-key", "wrong")])
def test_wrong_keys_are_refused_and_not_billed(server, document, keys):
    status, body, _ = get(server, assembly(document), keys=keys)
    assert (status, body["status"]) == (401, 401)
    assert server.count == 0
    assert len(server.calls) == 1


def test_what_is_not_there_or_not_known_is_refused_with_a_message(server, document):
    nowhere = "0" * 24
    studio = f"/api/v16/partstudios/d/{document.id}/w/{document.workspace}/e/{document.studios[0].element}"
    linked = "/api/v16" + next(request for request in requests(document)[1] if "/v/" in request)
    assert get(server, linked)[0] == 200
    for target, status in (
        (assembly(document).replace(document.id, nowhere), 404),
        (assembly(document).replace(document.workspace, nowhere), 404),
        (assembly(document, element=nowhere), 404),
        ("/api/v16/nothing", 404),
        ("/", 404),
        (assembly(document) + "?includeSuppressed=true", 400),
        (assembly(document) + "?includeMateFeatures=yes", 400),
        (studio + "/massproperties?partId=nope", 400),
        (linked.replace("linkDocumentId", "configuration"), 403),
    ):
        answered, body, _ = get(server, target)
        assert (answered, body["status"]) == (status, status), target
        assert body["message"]


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
