"""The way to a server: each failure of a proxy, a name or a certificate says what failed and what to do."""

import errno
import socket
import ssl
from contextlib import suppress

import pytest

from linkwright.stages import fetch as stage
from linkwright.stages.fetch.onshape.api import network_settings
from linkwright.stages.robot.errors import ConfigError, Offline
from tests.support.bare_server import TLS, reply, serving
from tests.support.kept import ADDRESS, client_at, fetched, onshape

MASS = "/partstudios/d/D/m/M/e/STUDIO/massproperties?configuration=default"
WORLD = "https://cad.onshape.com"
OK = reply(200, b"{}")


@pytest.fixture(autouse=True)
def no_proxies(monkeypatch):
    for name in ("http_proxy", "https_proxy", "all_proxy", "no_proxy"):
        monkeypatch.delenv(name, raising=False)
        monkeypatch.delenv(name.upper(), raising=False)


def asked_of(origin):
    with client_at(origin) as client:
        return client.get(MASS)


def refusal(origin):
    with pytest.raises(Offline) as caught:
        asked_of(origin)
    assert caught.value.hint
    return str(caught.value)


def free_port():
    with socket.socket() as server:
        server.bind(("127.0.0.1", 0))
        return server.getsockname()[1]


def failing(error):
    """A function of the system that fails."""

    def fail(*_, **__):
        raise error

    return fail


def test_a_certificate_that_the_user_names_is_trusted(monkeypatch):
    monkeypatch.setenv("SSL_CERT_FILE", str(TLS / "here.pem"))
    with serving(OK, certificate="here.pem") as (port, _):
        assert asked_of(f"https://127.0.0.1:{port}") == b"{}"


@pytest.mark.parametrize(
    ("certificate", "trusted", "words"),
    [
        ("here.pem", None, ["self-signed", "SSL_CERT_FILE", "your key was not sent"]),
        ("expired.pem", "expired.pem", ["has expired", "clock"]),
        ("elsewhere.pem", "elsewhere.pem", ["for another host", "source.url"]),
        (None, None, ["TLS failed"]),
    ],
)
def test_a_server_without_a_good_certificate_is_reported_once(monkeypatch, certificate, trusted, words):
    monkeypatch.delenv("SSL_CERT_FILE", raising=False)
    if trusted:
        monkeypatch.setenv("SSL_CERT_FILE", str(TLS / trusted))
    with serving(OK, certificate=certificate) as (port, asked):
        message = refusal(f"https://127.0.0.1:{port}")
    assert asked == []
    assert ("tried 3 times" in message) == (certificate is None)
    for word in ["no secure connection to 127.0.0.1: ", *words]:
        assert word in message


@pytest.mark.parametrize(
    ("function", "error", "words"),
    [
        ("getaddrinfo", socket.gaierror(socket.EAI_NONAME, "failed"), "reached: its name is not known (DNS)"),
        ("getaddrinfo", socket.gaierror(socket.EAI_AGAIN, "failed"), "reached: no name server answers (DNS)"),
        ("getaddrinfo", socket.gaierror(socket.EAI_FAIL, "failed"), "its name is not found (DNS: failed)"),
        ("create_connection", OSError(errno.ECONNREFUSED, ""), "connection refused"),
        ("create_connection", OSError(errno.ENETUNREACH, ""), "the network is unreachable"),
        ("create_connection", OSError(errno.EHOSTUNREACH, ""), "there is no route to the host"),
        ("create_connection", OSError(errno.EACCES, "Permission denied"), "permission denied"),
    ],
)
def test_an_unknown_name_or_a_failed_connection_is_reported(monkeypatch, function, error, words):
    monkeypatch.setattr(socket, function, failing(error))
    message = refusal(WORLD)
    assert words in message
    assert "cad.onshape.com cannot be reached" in message
    assert function != "getaddrinfo" or "source.offline=true" in message


def test_a_server_that_hangs_up_is_reported():
    with serving(lambda handler: setattr(handler, "close_connection", True)) as (port, _):
        assert "it closed the connection" in refusal(f"http://127.0.0.1:{port}")


@pytest.mark.parametrize("name", ["HTTPS_PROXY", "https_proxy", "ALL_PROXY"])
def test_a_proxy_that_is_not_there_is_named_without_its_password(monkeypatch, name):
    port = free_port()
    monkeypatch.setenv(name, f"http://user:hunter22@127.0.0.1:{port}")
    message = refusal(WORLD)
    assert f"the proxy 127.0.0.1:{port} ({name}) cannot be reached: nothing listens there" in message
    assert "NO_PROXY=cad.onshape.com" in message
    assert "hunter22" not in message


def test_a_word_that_is_taken_for_a_proxy_is_reported(monkeypatch):
    monkeypatch.setenv("HTTPS_PROXY", "garbage")
    monkeypatch.setattr(socket, "getaddrinfo", failing(socket.gaierror(socket.EAI_NONAME, "Not known")))
    assert "the proxy garbage:80 (HTTPS_PROXY) cannot be reached: its name is not known" in refusal(WORLD)


@pytest.mark.parametrize(
    ("code", "times", "words"),
    [
        (407, 1, ["requires a login (407)", "http://USER:PASSWORD@HOST:PORT"]),
        (403, 1, ["refuses to connect to cad.onshape.com (403)", "NO_PROXY=cad.onshape.com"]),
        (502, 3, ["refuses to connect to cad.onshape.com (502)", "tried 3 times"]),
    ],
)
def test_a_proxy_that_lets_nothing_through_is_reported(monkeypatch, code, times, words):
    with serving(reply(code)) as (port, asked):
        monkeypatch.setenv("HTTPS_PROXY", f"http://user:hunter22@127.0.0.1:{port}")
        message = refusal(WORLD)
    assert [line for line, _, _ in asked] == ["CONNECT cad.onshape.com:443 HTTP/1.1"] * times
    assert "hunter22" not in message
    for word in [f"the proxy 127.0.0.1:{port} (HTTPS_PROXY)", *words]:
        assert word in message


def test_a_server_behind_a_proxy_is_not_taken_for_it(monkeypatch):
    """The proxy leads to a server whose certificate nobody trusts."""
    monkeypatch.delenv("SSL_CERT_FILE", raising=False)

    def lead(handler):
        handler.send_response_only(200)
        handler.end_headers()
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        context.load_cert_chain(TLS / "here.pem")
        with suppress(OSError):
            context.wrap_socket(handler.connection, server_side=True)
        handler.close_connection = True

    with serving(lead) as (port, _):
        monkeypatch.setenv("HTTPS_PROXY", f"http://127.0.0.1:{port}")
        assert "no secure connection to cad.onshape.com: its certificate is self-signed" in refusal(WORLD)


NO_PROXY = "not the address of a proxy"


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        *(
            ("HTTPS_PROXY", text, NO_PROXY)
            for text in ("ftp://proxy:21", "http://", "://", "socks4://[::1]:1")
        ),
        *(("https_proxy", text, NO_PROXY) for text in ("http://proxy:port", "http://proxy:99999")),
        ("ALL_PROXY", "http://[::1", NO_PROXY),
        ("HTTP_PROXY", "ht tp://x", NO_PROXY),
        ("HTTPS_PROXY", "http://user:hunter22@proxy:port", NO_PROXY),
        ("ALL_PROXY", "socks5://127.0.0.1:1080", "SOCKS"),
        ("SSL_CERT_FILE", "/nowhere/ca.pem", "/nowhere/ca.pem is not a file"),
        ("SSL_CERT_FILE", __file__, "contains no certificate"),
        ("SSL_CERT_DIR", "/nowhere", "/nowhere is not a folder"),
    ],
)
def test_a_setting_that_cannot_be_meant_is_refused_by_its_name(monkeypatch, name, value, words):
    monkeypatch.setattr(network_settings.importlib.util, "find_spec", lambda _: None)
    with pytest.raises(ConfigError, match=words) as caught:
        network_settings.require({name: value})
    assert caught.value.where == name
    assert caught.value.hint
    assert "hunter22" not in str(caught.value)


def test_a_setting_that_can_be_meant_is_let_through():
    for environ in (
        {},
        {"HTTPS_PROXY": "proxy:3128", "HTTP_PROXY": "http://proxy", "ALL_PROXY": "https://u:p@proxy:1"},
        {"HTTPS_PROXY": "ftp://x", "https_proxy": "http://proxy:1"},
        {"HTTPS_PROXY": "ftp://x", "NO_PROXY": "*"},
        {"SSL_CERT_FILE": str(TLS / "here.pem")},
        {"SSL_CERT_DIR": str(TLS)},
    ):
        network_settings.require(environ)
    # This computer's own servers need no proxy.
    network_settings.require({"HTTPS_PROXY": "ftp://x"}, proxies=False)


def test_a_no_proxy_that_cannot_be_read_is_reported(monkeypatch):
    monkeypatch.setenv("NO_PROXY", "[::1")
    with pytest.raises(ConfigError, match="the proxy settings cannot be read"):
        asked_of(WORLD)


def test_a_build_that_will_call_is_reported_before_it_begins():
    key = {"ONSHAPE_ACCESS_KEY": "access-key", "ONSHAPE_SECRET_KEY": "secret-key"}
    wrong = {**key, "HTTPS_PROXY": "ftp://x"}
    with pytest.raises(ConfigError, match="HTTPS_PROXY: it is not the address of a proxy"):
        stage.preflight(onshape(ADDRESS), wrong)
    stage.preflight(onshape(ADDRESS, offline=True), wrong)
    with pytest.raises(ConfigError, match="SSL_CERT_FILE: /nowhere is not a file"):
        stage.preflight(onshape(ADDRESS), {**key, "SSL_CERT_FILE": "/nowhere"})
    pinned = ADDRESS.replace("/w/", "/v/")
    stage.preflight(onshape(pinned), wrong)
    with pytest.raises(ConfigError, match="HTTPS_PROXY"):
        fetched(onshape(pinned), environ=wrong)
