"""How a request shows its key: the headers, and what the local server thinks of them."""

from email.utils import formatdate
from time import time

import pytest

from linkwright.stages.fetch.onshape.api import signing
from linkwright.stages.fetch.onshape.api.client import Client
from linkwright.stages.fetch.onshape.api.credentials import Credentials
from linkwright.stages.fetch.onshape.url import AssemblyUrl
from linkwright.stages.robot.errors import AuthError
from tests.fake_onshape.server import ACCESS_KEY, SECRET_KEY, Fault, OnshapeServer
from tests.support.faulty import desk
from tests.support.kept import QUICK

TARGET = "/api/v16/partstudios/d/D/w/W/e/E/massproperties?configuration=a%3Db%2Bc"


def test_the_signature_is_that_of_openssl():
    """The same text through `openssl dgst -sha256 -hmac 'The-Secret' -binary | base64`."""
    signed = signing.signature(
        "The-Secret", "GET", "aBcDeFgHiJkLmNoPqRsTuVwXy", "Mon, 02 Mar 2026 10:11:12 GMT", TARGET
    )
    assert signed == "BuokfNIrcOxmccvY5gWwjaqZLnYhT0t3g65BsHbGub0="


def test_a_signed_request_has_its_own_nonce_and_no_secret():
    key = Credentials("acc", "sec-ret", "signature")
    first, second = signing.headers(key, "GET", TARGET), signing.headers(key, "GET", TARGET)
    assert "sec-ret" not in str(first)
    assert first["On-Nonce"] != second["On-Nonce"]
    assert first["On-Nonce"].isalnum()
    assert len(first["On-Nonce"]) == 25


@pytest.fixture(scope="module")
def document():
    return desk()


@pytest.mark.parametrize(
    ("key", "said"),
    [
        (Credentials(ACCESS_KEY, "wrong"), "a key works only on the host where it was made"),
        (Credentials(ACCESS_KEY, "wrong", "signature"), "The signature is not good."),
        (Credentials("wrong", SECRET_KEY, "signature"), "API key"),
        (Credentials(kind="bearer", token="stale"), "valid for about an hour"),
    ],
)
def test_a_wrong_key_is_refused_and_explained_after_one_call(document, key, said):
    with OnshapeServer(document) as server:
        url = AssemblyUrl(server.url, document.id, f"m/{document.microversion}", "e", "default")
        with Client(url, key, patience=QUICK) as client, pytest.raises(AuthError) as caught:
            client.get(f"/documents/d/{document.id}/m/{document.microversion}/elements")
        assert len(server.calls) == 1
    assert said in str(caught.value)
    assert "wrong" not in str(caught.value)
    assert "stale" not in str(caught.value)


@pytest.mark.parametrize(("away", "said"), [(600, "10 min behind"), (-600, "10 min ahead of")])
def test_a_clock_that_is_wrong_is_named(document, away, said):
    """The server's clock is ours; here it tells another time in what it refuses."""

    def elsewhen(method, path, number):
        return Fault(401, b"{}", {"Date": formatdate(time() + away, usegmt=True)})

    with OnshapeServer(document, fault=elsewhen) as server:
        url = AssemblyUrl(server.url, document.id, "w/W", "e", "default")
        key = Credentials(ACCESS_KEY, SECRET_KEY, "signature")
        with Client(url, key, patience=QUICK) as client, pytest.raises(AuthError, match=said):
            client.get("/documents/d/D/w/W/currentmicroversion")
