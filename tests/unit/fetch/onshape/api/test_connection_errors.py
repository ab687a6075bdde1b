"""The way to a server: each failure of a proxy, a name or a certificate says what failed and what to do."""

import errno
import socket
import ssl
import threading
from contextlib import contextmanager, suppress
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import pytest

from linkwright.stages import fetch as stage
from linkwright.stages.fetch.onshape.api import network_settings
from linkwright.stages.fetch.onshape.api.client import Client
from linkwright.stages.fetch.onshape.api.credentials import Credentials
from linkwright.stages.fetch.onshape.url import AssemblyUrl
from linkwright.stages.robot.errors import ConfigError, Offline
from tests.support.kept import ADDRESS, QUICK, fetched, onshape
from tests.support.places import PROJECT

KEY = Credentials("the-access", "the-secret")
MASS = "/partstudios/d/D/m/M/e/STUDIO/massproperties?configuration=default"
TLS = PROJECT / "tests/fake_onshape/tls"
WORLD = "https://cad.onshape.com"


@pytest.fixture(autouse=True)
def no_proxies(monkeypatch):
    for name in ("http_proxy", "https_proxy", "all_proxy", "no_proxy"):
        monkeypatch.delenv(name, raising=False)
        monkeypatch.delenv(name.upper(), raising=False)


@contextmanager
def serving(answer, certificate=None):
    """The port of a server on this computer that knows GET and CONNECT, and what was asked of it."""
    asked = []

    class Handler(BaseHTTPRequestHandler):
        protocol_version = "HTTP/1.1"

        def do_GET(self):
            asked.append(self.requestline)
            with suppress(OSError):
                answer(self)

        do_CONNECT = do_GET  # noqa: N815 - the name http.server calls

        def log_message(self, *_):
            pass

    class Server(ThreadingHTTPServer):
        daemon_threads = True

        def handle_error(self, *_):
            pass

    server = Server(("127.0.0.1", 0), Handler)
    if certificate:
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        context.load_cert_chain(TLS / certificate)
        server.socket = context.wrap_socket(server.socket, server_side=True)
    thread = threading.Thread(target=server.serve_forever, args=(0.01,), daemon=True)
    thread.start()
    try:
        yield server.server_address[1], asked
    finally:
        server.shutdown()
        server.server_close()
        thread.join()


def well(handler):
    handler.send_response_only(200)
    handler.send_header("Content-Length", "2")
    handler.end_headers()
    handler.wfile.write(b"{}")


def status(code):
    def answer(handler):
        handler.send_response_only(code)
        handler.send_header("Content-Length", "0")
        handler.end_headers()

    return answer


def asked_of(origin):
    with Client(AssemblyUrl(origin, "D", "w/W", "ROOT", "default"), KEY, patience=QUICK) as client:
        return client.get(MASS)


def told(origin):
    with pytest.raises(Offline) as caught:
        asked_of(origin)
    assert caught.value.hint
    return str(caught.value)


def free_port():
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


def test_a_certificate_that_the_user_names_is_trusted(monkeypatch):
    monkeypatch.setenv("SSL_CERT_FILE", str(TLS / "here.pem"))
    with serving(well, "here.pem") as (port, _):
        assert asked_of(f"https://127.0.0.1:{port}") == b"{}"


@pytest.mark.parametrize(
    ("certificate", "trusted", "said"),
    [
        ("here.pem", None, ["self-signed", "SSL_CERT_FILE", "your key was not sent"]),
        ("expired.pem", "expired.pem", ["has expired", "clock"]),
        ("elsewhere.pem", "elsewhere.pem", ["for another host", "source.url"]),
    ],
)
def test_a_certificate_that_is_not_to_be_trusted_is_reported_once(monkeypatch, certificate, trusted, said):
    monkeypatch.delenv("SSL_CERT_FILE", raising=False)
    if trusted:
        monkeypatch.setenv("SSL_CERT_FILE", str(TLS / trusted))
    with serving(well, certificate) as (port, asked):
        message = told(f"https://127.0.0.1:{port}")
    assert asked == []
    assert "tried 3 times" not in message
    for words in ["no secure connection to 127.0.0.1", *said]:
        assert words in message


def test_a_server_without_tls_is_reported():
    with serving(well) as (port, _):
        message = told(f"https://127.0.0.1:{port}")
    assert "no secure connection to 127.0.0.1: TLS failed" in message


@pytest.mark.parametrize(
    ("number", "said"),
    [
        (socket.EAI_NONAME, "cad.onshape.com cannot be reached: its name is not known (DNS)"),
        (socket.EAI_AGAIN, "cad.onshape.com cannot be reached: no name server answers (DNS)"),
        (socket.EAI_FAIL, "cad.onshape.com cannot be reached: its name is not found (DNS: it failed)"),
    ],
)
def test_a_name_that_leads_nowhere_is_reported(monkeypatch, number, said):
    def unknown(*_, **__):
        raise socket.gaierror(number, "it failed")

    monkeypatch.setattr(socket, "getaddrinfo", unknown)
    message = told(WORLD)
    assert said in message
    assert "source.offline=true" in message


@pytest.mark.parametrize(
    ("number", "said"),
    [
        (errno.ECONNREFUSED, "connection refused"),
        (errno.ENETUNREACH, "the network is unreachable"),
        (errno.EHOSTUNREACH, "there is no route to the host"),
        (errno.EACCES, "permission denied"),
    ],
)
def test_a_connection_that_is_not_made_is_reported(monkeypatch, number, said):
    def refused(*_, **__):
        raise OSError(number, "Permission denied")

    monkeypatch.setattr(socket, "create_connection", refused)
    assert said in told(WORLD)


def test_a_server_that_hangs_up_is_reported():
    def hang_up(handler):
        handler.close_connection = True

    with serving(hang_up) as (port, _):
        assert "it closed the connection" in told(f"http://127.0.0.1:{port}")


@pytest.mark.parametrize("name", ["HTTPS_PROXY", "https_proxy", "ALL_PROXY"])
def test_a_proxy_that_is_not_there_is_named_without_its_password(monkeypatch, name):
    port = free_port()
    monkeypatch.setenv(name, f"http://user:hunter22@127.0.0.1:{port}")
    message = told(WORLD)
    assert f"the proxy 127.0.0.1:{port} ({name}) cannot be reached: nothing listens there" in message
    assert "NO_PROXY=cad.onshape.com" in message
    assert "hunter22" not in message


def test_a_word_that_is_taken_for_a_proxy_is_reported(monkeypatch):
    def unknown(*_, **__):
        raise socket.gaierror(socket.EAI_NONAME, "Name or service not known")

    monkeypatch.setenv("HTTPS_PROXY", "garbage")
    monkeypatch.setattr(socket, "getaddrinfo", unknown)
    assert "the proxy garbage:80 (HTTPS_PROXY) cannot be reached: its name is not known" in told(WORLD)


@pytest.mark.parametrize(
    ("code", "times", "said"),
    [
        (407, 1, ["requires a login (407)", "http://USER:PASSWORD@HOST:PORT"]),
        (403, 1, ["refuses to connect to cad.onshape.com (403)", "NO_PROXY=cad.onshape.com"]),
        (502, 3, ["refuses to connect to cad.onshape.com (502)", "tried 3 times"]),
    ],
)
def test_a_proxy_that_lets_nothing_through_is_reported(monkeypatch, code, times, said):
    with serving(status(code)) as (port, asked):
        monkeypatch.setenv("HTTPS_PROXY", f"http://user:hunter22@127.0.0.1:{port}")
        message = told(WORLD)
    assert asked == ["CONNECT cad.onshape.com:443 HTTP/1.1"] * times
    assert "hunter22" not in message
    for words in [f"the proxy 127.0.0.1:{port} (HTTPS_PROXY)", *said]:
        assert words in message


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
        assert "no secure connection to cad.onshape.com: its certificate is self-signed" in told(WORLD)


WRONG = [
    ({"HTTPS_PROXY": "ftp://proxy:21"}, "HTTPS_PROXY", "not the address of a proxy"),
    ({"HTTPS_PROXY": "http://"}, "HTTPS_PROXY", "not the address of a proxy"),
    ({"HTTPS_PROXY": "://"}, "HTTPS_PROXY", "not the address of a proxy"),
    ({"https_proxy": "http://proxy:port"}, "https_proxy", "not the address of a proxy"),
    ({"https_proxy": "http://proxy:99999"}, "https_proxy", "not the address of a proxy"),
    ({"ALL_PROXY": "http://[::1"}, "ALL_PROXY", "not the address of a proxy"),
    ({"HTTP_PROXY": "ht tp://x"}, "HTTP_PROXY", "not the address of a proxy"),
    ({"HTTPS_PROXY": "http://user:hunter22@proxy:port"}, "HTTPS_PROXY", "not the address of a proxy"),
    ({"ALL_PROXY": "socks5://127.0.0.1:1080"}, "ALL_PROXY", "SOCKS"),
    ({"HTTPS_PROXY": "socks4://127.0.0.1:1080"}, "HTTPS_PROXY", "not the address of a proxy"),
    ({"SSL_CERT_FILE": "/nowhere/ca.pem"}, "SSL_CERT_FILE", "/nowhere/ca.pem is not a file"),
    ({"SSL_CERT_FILE": __file__}, "SSL_CERT_FILE", "contains no certificate"),
    ({"SSL_CERT_DIR": "/nowhere"}, "SSL_CERT_DIR", "/nowhere is not a folder"),
]


@pytest.mark.parametrize(("environ", "name", "said"), WRONG)
def test_a_setting_that_cannot_be_meant_is_refused_by_its_name(monkeypatch, environ, name, said):
    monkeypatch.setattr(network_settings.importlib.util, "find_spec", lambda _: None)
    with pytest.raises(ConfigError, match=said) as caught:
        network_settings.require(environ)
    assert caught.value.where == name
    assert caught.value.hint
    assert "hunter22" not in str(caught.value)


@pytest.mark.parametrize(
    "environ",
    [
        {},
        {"HTTPS_PROXY": "proxy:3128", "HTTP_PROXY": "http://proxy", "ALL_PROXY": "https://u:p@proxy:1"},
        {"HTTPS_PROXY": "ftp://x", "https_proxy": "http://proxy:1"},
        {"HTTPS_PROXY": "ftp://x", "NO_PROXY": "*"},
        {"SSL_CERT_FILE": str(TLS / "here.pem")},
        {"SSL_CERT_DIR": str(TLS)},
    ],
)
def test_what_can_be_meant_is_let_through(environ):
    network_settings.require(environ)


def test_this_computers_own_servers_need_no_proxy():
    network_settings.require({"HTTPS_PROXY": "ftp://x"}, proxies=False)


def test_exceptions_from_proxies_that_cannot_be_read_are_reported(monkeypatch):
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
