"""Addresses: what a browser shows becomes an assembly, anything else an error that says why."""

import pickle
import socket

import pytest

from linkwright.stages.fetch.onshape.section import OnshapeSourceSection
from linkwright.stages.fetch.onshape.url import AssemblyUrl, parse
from linkwright.stages.robot.errors import ConfigError
from tests.support.tricky_hosts import HOSTS

D, W, E = "5f1a0c2b9d8e7f6a5b4c3d2e", "0a1b2c3d4e5f60718293a4b5", "a1b2c3d4e5f60718293a4b5c"
PLAIN = f"https://cad.onshape.com/documents/{D}/w/{W}/e/{E}"


def test_a_browser_address_is_read_without_what_concerns_the_browser():
    url = parse(f" {PLAIN}?renderMode=0&uiState=66f0c4d1e2#top ")
    assert url == AssemblyUrl("https://cad.onshape.com", D, f"w/{W}", E, "default")
    assert not url.pinned
    assert parse(PLAIN + "/") == url


@pytest.mark.parametrize(("letter", "pinned"), [("w", False), ("v", True), ("m", True)])
def test_only_a_workspace_can_change(letter, pinned):
    url = parse(PLAIN.replace("/w/", f"/{letter}/"))
    assert url.pin == f"{letter}/{W}"
    assert url.pinned is pinned


@pytest.mark.parametrize(
    ("query", "configuration"),
    [
        ("configuration=List_x%3D_500_mm%3Bwide%3Dtrue", "List_x=_500_mm;wide=true"),
        ("renderMode=0&configuration=leg%3D0.25%2Bmeter&uiState=1", "leg=0.25+meter"),
        ("configuration=leg=0.25+meter", "leg=0.25+meter"),
        ("configuration=share%3D50%2525", "share=50%25"),
        ("configuration=", "default"),
    ],
)
def test_the_configuration_is_decoded_once(query, configuration):
    assert parse(f"{PLAIN}?{query}").configuration == configuration


@pytest.mark.parametrize(
    ("address", "origin", "loopback"),
    [
        (PLAIN.replace("cad.", "my-company-2."), "https://my-company-2.onshape.com", False),
        (PLAIN.replace("https://cad.onshape.com", "http://127.0.0.1:8123"), "http://127.0.0.1:8123", True),
        (PLAIN.replace("https://cad.onshape.com", "http://localhost:80"), "http://localhost:80", True),
        (PLAIN.replace("https://cad.onshape.com", "http://[::1]:9"), "http://[::1]:9", True),
        (
            PLAIN.replace("https://cad.onshape.com", "HTTPS://CAD.Onshape.com"),
            "https://cad.onshape.com",
            False,
        ),
        (PLAIN.replace("cad.", ""), "https://onshape.com", False),
    ],
)
def test_the_host_is_kept(address, origin, loopback):
    url = parse(address)
    assert (url.origin, url.loopback) == (origin, loopback)


@pytest.mark.parametrize(
    ("address", "why"),
    [
        ("", "https://"),
        ("cad.onshape.com/documents", "https://"),
        ("ftp://cad.onshape.com/documents", "https://"),
        ("https://[bad/documents", "not a URL"),
        (PLAIN.replace(".com", ".com:port"), "not a URL"),
        (PLAIN.replace("https", "http"), "plain http"),
        (PLAIN.replace("onshape.com", "onshape.com.example.org"), "its host is not onshape.com"),
        (PLAIN.replace("cad.onshape.com", "notonshape.com"), "its host is not onshape.com"),
        (f"https://cad.onshape.com/documents/{D}", "no tab"),
        (f"https://cad.onshape.com/documents/{D}/w/{W}", "no tab"),
        (PLAIN[:-1], "24 hex"),
        (PLAIN.replace("/w/", "/x/"), "24 hex"),
        (PLAIN + "/more", "24 hex"),
        ("https://cad.onshape.com/signin", "24 hex"),
    ],
)
def test_anything_else_is_refused_with_the_reason_and_an_example(address, why):
    with pytest.raises(ConfigError) as caught:
        parse(address)
    assert why in str(caught.value)
    assert caught.value.where == "source.url"
    assert "https://" in caught.value.hint


@pytest.mark.parametrize("scheme", ["https", "http"])
@pytest.mark.parametrize("host", HOSTS)
def test_no_trick_makes_a_host_onshapes(host, scheme, monkeypatch):
    monkeypatch.setattr(socket, "getaddrinfo", None)
    monkeypatch.setattr(socket, "socket", None)
    with pytest.raises(ConfigError) as caught:
        parse(PLAIN.replace("https://cad.onshape.com", f"{scheme}://{host}"))
    assert caught.value.where == "source.url"


def test_a_password_in_an_address_is_refused_and_not_repeated():
    with pytest.raises(ConfigError) as caught:
        parse(PLAIN.replace("https://", "https://key:hush@"))
    assert "hush" not in str(caught.value)
    assert "ONSHAPE_SECRET_KEY" in caught.value.hint


def test_the_configuration_holds_the_parsed_address_and_writes_it_as_it_was_typed():
    typed = f" https://cad.onshape.com/documents/{'A' * 24}/w/{'b' * 24}/e/{'c' * 24}?renderMode=0#view "
    keys = OnshapeSourceSection(url=typed)
    assert keys.url == parse(typed)
    assert keys.identity()["url"] == keys.model_dump()["url"] == typed
    assert pickle.loads(pickle.dumps(keys)).url.text == typed
