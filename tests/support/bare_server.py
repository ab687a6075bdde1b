"""A bare HTTP server on this computer, whose replies a test writes itself."""

import ssl
import threading
from contextlib import contextmanager, suppress
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import NamedTuple

from tests.support.places import PROJECT

TLS = PROJECT / "tests/fake_onshape/tls"


class Asked(NamedTuple):
    """A request: its first line, its headers by lower-case name, and its body."""

    line: str
    headers: dict
    body: bytes


@contextmanager
def serving(*answers, certificate=None):
    """The port of a server that knows GET, POST and CONNECT, and the list of its requests so far.

    Each `answer(handler)` writes one reply, in turn; the last answers all later requests too.
    """
    asked = []

    class Handler(BaseHTTPRequestHandler):
        protocol_version = "HTTP/1.1"

        def do_GET(self):
            body = self.rfile.read(int(self.headers.get("Content-Length") or 0))
            headers = {name.lower(): value for name, value in self.headers.items()}
            asked.append(Asked(self.requestline, headers, body))
            with suppress(OSError):
                answers[min(len(asked), len(answers)) - 1](self)

        do_POST = do_CONNECT = do_GET  # noqa: N815 - the names http.server calls

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


def reply(status, body=b"", *, length=None, **headers):
    """An answer; `length`: the Content-Length it claims, after which it hangs up."""

    def answer(handler):
        handler.send_response_only(status)
        handler.send_header("Content-Length", str(len(body) if length is None else length))
        for name, value in headers.items():
            handler.send_header(name.replace("_", "-"), value)
        handler.end_headers()
        handler.wfile.write(body)
        handler.wfile.flush()
        handler.close_connection = length is not None

    return answer


def hang_up(handler):
    """An answer without a reply."""
    handler.close_connection = True
    handler.connection.close()
