"""A real HTTP server on 127.0.0.1 that serves a document with Onshape's paths, auth and shapes.

with OnshapeServer(document) as server:
    ... server.document_url() ...
    assert server.count == 9
"""

import base64
import re
import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

from tests.onshape import ids
from tests.onshape.document import Document
from tests.onshape.replies import Replies, Reply, error_body

ACCESS_KEY = "an-access-key"
SECRET_KEY = "a-secret-key"
# How many calls each endpoint starts with, as live receipts show.
WINDOW = {"definition": 1000, "elements": 9000, "currentmicroversion": 400}
RELEASE = "1.218.0"


@dataclass(frozen=True)
class Fault:
    """What a fault hook puts in place of a reply."""

    status: int
    body: bytes = b""
    headers: Mapping[str, str] = field(default_factory=dict)


FaultHook = Callable[[str, str, int], Fault | None]


class OnshapeServer:
    """A context manager; the server runs in its own thread on a port that was free.

    `keys`: the (access, secret) pair that Basic auth must carry. `latency_s`: waited before each
    reply. `fault(method, path with query, number of the call from 0)` may return a `Fault`.
    `calls` lists (method, path with query, status); `count` counts what Onshape would bill: 2xx
    and 3xx. `replies` may be replaced while it runs (an edit).
    """

    def __init__(
        self,
        document: Document,
        *,
        keys: tuple[str, str] = (ACCESS_KEY, SECRET_KEY),
        latency_s: float = 0.0,
        fault: FaultHook | None = None,
        **options,
    ):
        self.document, self.replies = document, Replies(document, **options)
        self.keys, self.latency_s, self.fault = keys, latency_s, fault
        self.calls: list[tuple[str, str, int]] = []
        self.at_once = self.most_at_once = 0
        self._cache: dict[tuple[int, str], Reply] = {}
        self._lock = threading.Lock()
        self._http = ThreadingHTTPServer(("127.0.0.1", 0), self._handler())
        self._http.daemon_threads = True
        self._thread = threading.Thread(target=self._http.serve_forever, args=(0.02,), daemon=True)

    def __enter__(self):
        self._thread.start()
        return self

    def __exit__(self, *_):
        self._http.shutdown()
        self._http.server_close()
        self._thread.join()

    @property
    def url(self):
        """http://127.0.0.1:port"""
        return f"http://127.0.0.1:{self._http.server_address[1]}"

    @property
    def environ(self):
        """The environment variables that carry the credentials."""
        return {"ONSHAPE_ACCESS_KEY": self.keys[0], "ONSHAPE_SECRET_KEY": self.keys[1]}

    @property
    def count(self):
        """Calls answered with 2xx or 3xx."""
        return sum(200 <= status < 400 for _, _, status in self.calls)

    def reset(self):
        """Forget the calls so far."""
        self.calls.clear()
        self.most_at_once = 0

    def document_url(self, kind="w", element=None):
        """The address a browser would show; `kind`: w, v or m."""
        home = self.document
        state = {"w": home.workspace, "v": home.version, "m": home.microversion}[kind]
        return f"{self.url}/documents/{home.id}/{kind}/{state}/e/{element or home.root.element}"

    def answer(self, method, target, authorization) -> tuple[int, bytes, dict[str, str]]:
        """Status, body and headers for one request; counts it."""
        with self._lock:
            number = len(self.calls)
            self.calls.append((method, target, 0))
            self.at_once += 1
            self.most_at_once = max(self.most_at_once, self.at_once)
        if self.latency_s:
            time.sleep(self.latency_s)
        status, body, headers = self._decide(method, target, authorization, number)
        with self._lock:
            if number < len(self.calls):
                self.calls[number] = (method, target, status)
            self.at_once -= 1
        return status, body, headers

    def _decide(self, method, target, authorization, number):
        fault = self.fault(method, target, number) if self.fault else None
        if fault is not None:
            return fault.status, fault.body, dict(fault.headers)
        match = re.match(r"/api/(v\d+)(/[^?]*)\??(.*)$", target)
        if match is None:
            return 404, error_body(404, "Not found."), {}
        headers = {"X-Api-Version": match[1], "On-Version": RELEASE}
        expected = "Basic " + base64.b64encode(":".join(self.keys).encode()).decode()
        if authorization != expected:
            return 401, error_body(401, "Unauthenticated API request."), headers
        if method != "GET":
            return 405, error_body(405, "Method not allowed."), headers
        with self._lock:
            key = (id(self.replies), target)
            reply = self._cache.get(key) or self.replies.answer(match[2], match[3])
            self._cache[key] = reply
        left = WINDOW.get(reply.endpoint, 3000) - self._asked(reply.endpoint)
        return reply.status, reply.body, {**headers, "X-Rate-Limit-Remaining": str(max(0, left))}

    def _asked(self, endpoint):
        suffix = {"definition": "/assemblies/"}.get(endpoint, f"/{endpoint}")
        return sum(suffix in target for _, target, _ in self.calls)

    def _handler(server):  # noqa: N805 - the handler has a self of its own
        class Handler(BaseHTTPRequestHandler):
            protocol_version = "HTTP/1.1"
            disable_nagle_algorithm = True

            def do_GET(self):
                status, body, headers = server.answer(
                    self.command, self.path, self.headers.get("Authorization", "")
                )
                length = int(self.headers.get("Content-Length") or 0)
                if length:
                    self.rfile.read(length)
                self.send_response(status)
                self.send_header("X-Request-Id", ids.hex_id(self.path))
                self.send_header("Content-Length", str(len(body)))
                for name, value in {"Content-Type": "application/json;charset=UTF-8", **headers}.items():
                    self.send_header(name, value)
                # One write: header and body in one packet keeps small replies quick.
                self._headers_buffer.append(b"\r\n" + body)
                self.flush_headers()

            do_POST = do_PUT = do_DELETE = do_GET  # noqa: N815 - the names http.server calls

            def log_message(self, *_):
                pass

        return Handler
