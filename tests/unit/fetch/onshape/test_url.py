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


def test_a_browsers_address_is_read_without_its_view():
    url = parse(f" {PLAIN}?renderMode=0&uiState=66f0c4d1e2#top ")
    assert url == AssemblyUrl("https://cad.onshape.com", D, f"w/{W}", E, "default")
    assert not url.pinned
    assert parse(PLAIN + "/") == url


def test_a_workspace_alone_can_change():
    for letter, pinned in (("w", False), ("v", True), ("m", True)):
        url = parse(PLAIN.replace("/w/", f"/{letter}/"))
        assert (url.pin, url.pinned) == (f"{letter}/{W}", pinned)


def test_the_configuration_is_decoded_once():
    for query, configuration in (
        ("configuration=List_x%3D_500_mm%3Bwide%3Dtrue", "List_x=_500_mm;wide=true"),
        ("renderMode=0&configuration=leg%3D0.25%2Bmeter&uiState=1", "leg=0.25+meter"),
        ("configuration=leg=0.25+meter", "leg=0.25+meter"),
        ("configuration=share%3D50%2525", "share=50%25"),
        ("configuration=", "default"),
    ):
        assert parse(f"{PLAIN}?{query}").configuration == configuration


SITE = "https://cad.onshape.com"


@pytest.mark.parametrize(
    ("site", "origin", "loopback"),
    [
        ("https://my-company-2.onshape.com", "https://my-company-2.onshape.com", False),
        ("HTTPS://CAD.Onshape.com", SITE, False),
        ("https://onshape.com", "https://onshape.com", False),
        *((host, host, True) for host in ("http://127.0.0.1:8123", "http://localhost:80", "http://[::1]:9")),
    ],
)
def test_the_host_is_kept(site, origin, loopback):
    url = parse(PLAIN.replace(SITE, site))
    assert (url.origin, url.loopback) == (origin, loopback)


@pytest.mark.parametrize(
    ("address", "why"),
    [
        *(
            (text, "https://")
            for text in ("", "cad.onshape.com/documents", "ftp://cad.onshape.com/documents")
        ),
        *((text, "not a URL") for text in ("https://[bad/documents", PLAIN.replace(".com", ".com:port"))),
        (PLAIN.replace("https", "http"), "plain http"),
        (PLAIN.replace("onshape.com", "onshape.com.example.org"), "its host is not onshape.com"),
        (PLAIN.replace("cad.onshape.com", "notonshape.com"), "its host is not onshape.com"),
        *((f"{SITE}/documents/{D}{state}", "no tab") for state in ("", f"/w/{W}")),
        *(
            (text, "24 hex")
            for text in (PLAIN[:-1], PLAIN.replace("/w/", "/x/"), PLAIN + "/more", SITE + "/signin")
        ),
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
def test_a_trick_makes_no_host_onshapes(host, scheme, monkeypatch):
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


def test_the_section_holds_the_parsed_address_and_its_text():
    typed = f" https://cad.onshape.com/documents/{'A' * 24}/w/{'b' * 24}/e/{'c' * 24}?renderMode=0#view "
    keys = OnshapeSourceSection(url=typed)
    assert keys.url == parse(typed)
    assert keys.identity()["url"] == keys.model_dump()["url"] == typed
    assert pickle.loads(pickle.dumps(keys)).url.text == typed
