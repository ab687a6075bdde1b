"""Where a key may follow a redirect, and what following costs."""

import pytest

from linkwright.stages.fetch.onshape.api import redirects
from linkwright.stages.robot.errors import ProtocolError
from tests.fake_onshape.server import ACCESS_KEY, SECRET_KEY, TOKEN, Fault, OnshapeServer
from tests.support.faulty import desk
from tests.support.kept import Kept, client_at, fetched, onshape
from tests.support.tricky_hosts import HOSTS

CAD = "https://cad.onshape.com/api/v16/x?a=b%2Fc"
LOCAL = "http://127.0.0.1:8000/api/v16/x"


def test_a_key_goes_to_hosts_of_the_same_owner():
    for here, location, there in (
        (CAD, "https://cad-usw2.onshape.com/api/v16/x?a=b%2Fc", None),
        (CAD, "https://onshape.com/y", None),
        (CAD, "/api/v16/y?p=JF%2F", "https://cad.onshape.com/api/v16/y?p=JF%2F"),
        (CAD, "//big-co.onshape.com/y", "https://big-co.onshape.com/y"),
        (CAD, "https://cad.onshape.com/y#part", "https://cad.onshape.com/y"),
        (LOCAL, "http://127.0.0.1:8000/y", None),
        (LOCAL, "/y", "http://127.0.0.1:8000/y"),
    ):
        assert redirects.target(here, location, "it") == (there or location)


@pytest.mark.parametrize(
    ("here", "location"),
    [
        *((CAD, f"https://{place}/y") for place in (
            "example.org", "onshape.com.example.org", "badonshape.com", "user@cad.onshape.com",
            "cad.onshape.com@example.org", "localhost", "cad.onshape.com:port", *HOSTS,
        )),
        *((CAD, text) for text in (
            "", "http://cad.onshape.com/y", "http://127.0.0.1/y", "ftp://cad.onshape.com/y",
            "javascript:alert(1)", "https://[/y",
            "//evil.com\\.onshape.com/y", "\\\\evil.com/y", "https:\\\\evil.com\\.onshape.com",
            "\thttps://evil.com",
        )),
        *((LOCAL, text) for text in (
            "https://cad.onshape.com/y", "http://192.168.0.1/y", "file:///etc/passwd", "http://localhost:8000/y",
            "http://127.0.0.1:9000/api/v16/x", "https://127.0.0.1:8000/y",
            *(f"http://{host}/y" for host in HOSTS),
        )),
        ("https://cad.example.org/x", "https://www.example.org/x"),
    ],
)  # fmt: skip
def test_a_key_goes_nowhere_else(here, location):
    with pytest.raises(ProtocolError) as caught:
        redirects.target(here, location, "it")
    assert "user@" not in str(caught.value)


def test_a_post_follows_only_what_keeps_its_method():
    assert [s for s in range(300, 400) if redirects.must_follow("GET", s)] == [301, 302, 303, 307, 308]
    assert [s for s in range(300, 400) if redirects.must_follow("POST", s)] == [307, 308]


@pytest.fixture(scope="module")
def document():
    return desk()


@pytest.mark.parametrize(
    "environ",
    [
        {"ONSHAPE_ACCESS_KEY": ACCESS_KEY, "ONSHAPE_SECRET_KEY": SECRET_KEY},
        {"ONSHAPE_ACCESS_KEY": ACCESS_KEY, "ONSHAPE_SECRET_KEY": SECRET_KEY, "ONSHAPE_AUTH": "signature"},
        {"ONSHAPE_ACCESS_TOKEN": TOKEN},
    ],
)
def test_a_region_is_followed_with_its_key_and_remembered(document, environ, monkeypatch):
    """Only the first call for each of the two documents pays for the way; each stop is billed."""
    # Here both are this computer, and not Onshape's hosts.
    monkeypatch.setattr(redirects, "_may_send_key", lambda before, after: True)
    with OnshapeServer(document) as region, OnshapeServer(document) as front:
        front.fault = lambda method, path, number: Fault(307, headers={"Location": region.url + path})
        outcome = fetched(onshape(front.document_url()), Kept(), environ)
        assert {status for _, _, status in front.calls} == {307}
        assert {status for _, _, status in region.calls} == {200}
        assert outcome.calls == front.count + region.count
        assert region.count == 7
        # Those that were under way at once may each have paid.
        assert 2 <= front.count <= 5


@pytest.mark.parametrize(
    ("location", "stops"),
    [("/api/v16/again", 4), ("https://cad.onshape.com/x", 1), ("http://192.168.0.1/x", 1),
     ("http://127.0.0.1:9/x", 1), ("http://evil.com\\.onshape.com/x", 1)],
)  # fmt: skip
def test_a_way_that_does_not_end_or_leads_away_is_left(document, location, stops):
    with OnshapeServer(document) as server:
        server.fault = lambda *_: Fault(307, headers={"Location": location})
        with client_at(server.url) as client:
            with pytest.raises(ProtocolError, match="redirects"):
                client.get("/documents/d/D/w/W/currentmicroversion")
            assert client.calls == server.count == stops
