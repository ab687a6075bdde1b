"""The client against a bare server: what is counted, and what each refusal or fault becomes."""

import gzip
import json
import threading
from contextlib import contextmanager, suppress
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import pytest

from stages.fetch.client import Client
from stages.fetch.credentials import Credentials
from stages.fetch.url import AssemblyUrl
from stages.robot.errors import (
    AuthError,
    NotFound,
    Offline,
    ProtocolError,
    QuotaExhausted,
    RateLimited,
    SourceError,
)

KEY = Credentials("the-access", "the-secret")
MASS = "/partstudios/d/D/m/M/e/STUDIO/massproperties?configuration=a%3Db%2Bc"
DEFINITION = "/assemblies/d/D/w/W/e/ROOT?configuration=default"


@contextmanager
def serving(answer):
    """A client of a server whose `answer(handler)` writes each reply."""

    class Handler(BaseHTTPRequestHandler):
        protocol_version = "HTTP/1.1"

        def do_GET(self):
            answer(self)

        def log_message(self, *_):
            pass

    server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    server.daemon_threads = True
    thread = threading.Thread(target=server.serve_forever, args=(0.01,), daemon=True)
    thread.start()
    origin = f"http://127.0.0.1:{server.server_address[1]}"
    try:
        with Client(AssemblyUrl(origin, "D", "w/W", "ROOT", "default"), KEY) as client:
            yield client
    finally:
        server.shutdown()
        server.server_close()
        thread.join()


def reply(status, body=b"", *, length=None, **headers):
    def answer(handler):
        handler.send_response(status)
        handler.send_header("Content-Length", str(len(body) if length is None else length))
        for name, value in headers.items():
            handler.send_header(name.replace("_", "-"), value)
        handler.end_headers()
        handler.wfile.write(body)
        handler.close_connection = length is not None

    return answer


def test_the_canonical_request_is_sent_as_it_is_with_basic_auth():
    seen = {}

    def answer(handler):
        seen.update(path=handler.path, **{k.lower(): v for k, v in handler.headers.items()})
        reply(200, b"{}")(handler)

    with serving(answer) as client:
        assert client.get(MASS) == b"{}"
    assert seen["path"] == "/api/v16" + MASS
    assert seen["authorization"] == "Basic dGhlLWFjY2Vzczp0aGUtc2VjcmV0"
    assert "gzip" in seen["accept-encoding"]


def test_a_packed_reply_is_unpacked():
    body = json.dumps({"bodies": list(range(1000))}).encode()
    with serving(reply(200, gzip.compress(body), Content_Encoding="gzip")) as client:
        assert client.get(MASS) == body


@pytest.mark.parametrize(
    ("request_", "status", "headers", "error", "said"),
    [
        (DEFINITION, 401, {}, AuthError, "works only on the host where it was made"),
        (MASS, 403, {}, AuthError, "may not read the mass properties of part studio STUDIO"),
        (MASS, 402, {}, QuotaExhausted, "yearly quota"),
        (DEFINITION, 404, {}, NotFound, "a part studio or a drawing?"),
        (MASS, 404, {}, NotFound, "private to others"),
        (MASS, 429, {"Retry_After": "450"}, RateLimited, "wait 450 s"),
        (MASS, 429, {"Retry_After": "soon"}, RateLimited, "(429)"),
        (DEFINITION, 400, {}, SourceError, "a part studio or a drawing?"),
        (MASS, 400, {}, ProtocolError, "(400)"),
        (MASS, 406, {}, ProtocolError, "(406)"),
        (MASS, 307, {"Location": "https://elsewhere.example.org/"}, ProtocolError, "points elsewhere"),
        (MASS, 500, {}, ProtocolError, "failed to give"),
        (MASS, 503, {}, ProtocolError, "failed to give"),
    ],
)
def test_each_refusal_is_explained_with_the_words_of_the_server(request_, status, headers, error, said):
    body = b'{"message": "Told\\nso by the-secret.", "status": 0}'
    with serving(reply(status, body, **headers)) as client, pytest.raises(SourceError) as caught:
        client.get(request_)
    assert type(caught.value) is error
    assert said in str(caught.value)
    assert "the-secret" not in str(caught.value)
    assert "127.0.0.1" in caught.value.where
    if status != 307:
        assert "Told so by ***." in caught.value.message


def test_a_web_page_is_never_quoted_nor_taken_for_a_reply():
    page = b"<!doctype html><html><body>Sign in</body></html>"
    with serving(reply(502, page)) as client, pytest.raises(ProtocolError) as caught:
        client.get(MASS)
    assert "html" not in caught.value.message
    with serving(reply(200, b"  " + page)) as client, pytest.raises(ProtocolError, match="a web page"):
        client.get(MASS)


def test_only_what_is_billed_is_counted():
    statuses = iter([200, 404, 307, 500, 200, 429])
    with serving(lambda handler: reply(next(statuses), b"{}")(handler)) as client:
        for _ in range(6):
            with suppress(SourceError):
                client.get(MASS)
        assert client.calls == 3


@pytest.mark.parametrize(
    "answer",
    [
        reply(200, b'{"bodies"', length=1000),
        reply(200, gzip.compress(b"x" * 10000)[:-200] + b"?" * 200, Content_Encoding="gzip"),
    ],
)
def test_a_reply_cut_short_is_an_error_and_was_paid_for(answer):
    with serving(answer) as client:
        with pytest.raises(ProtocolError, match="cut short"):
            client.get(MASS)
        assert client.calls == 1


def test_a_server_that_hangs_up_is_no_reply():
    def hang_up(handler):
        handler.close_connection = True
        handler.connection.close()

    with serving(hang_up) as client, pytest.raises((ProtocolError, Offline)):
        client.get(MASS)


def test_no_server_is_offline():
    with serving(reply(200, b"{}")) as client:
        pass
    with Client(AssemblyUrl(f"http://{client.host}", "D", "w/W", "ROOT", "default"), KEY) as late:
        with pytest.raises(Offline, match="cannot be reached"):
            late.get(MASS)
        assert late.calls == 0
