"""A real HTTP server on 127.0.0.1 that serves a document with Onshape's paths, auth and shapes.

with OnshapeServer(document) as server:
    ... server.document_url() ...
    assert server.count == 9
"""

import gzip
import re
import threading
import time
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

from tests.fake_onshape import ids
from tests.fake_onshape.auth import Gate
from tests.fake_onshape.faults import Fault, send
from tests.fake_onshape.peer_replies import PeerReplies
from tests.fake_onshape.replies import Replies, error_body

ACCESS_KEY = "an-access-key"
SECRET_KEY = "a-secret-key"
TOKEN = "a-bearer-token"
# How many calls each endpoint starts with, as live receipts show.
WINDOW = {"definition": 1000, "elements": 9000, "currentmicroversion": 400}
RELEASE = "1.218.0"


WORTH_PACKING = 1000
"""Shorter bodies are sent as they are [bytes]."""
SOUND = Fault(body=None)


class OnshapeServer:
    """A context manager; the server runs in its own thread on a port that was free.

    `keys`: the (access, secret) pair of Basic auth and of signatures; `token`: the bearer's.
    `latency_s`: waited before each reply. `fault(method, path with query, number of the call from 0)`
    may return a `Fault`.
    `calls` lists (method, path with query, status); `count` counts what Onshape would bill: 2xx
    and 3xx. `edit` changes the document while it runs.
    """

    def __init__(
        self,
        document,
        *,
        keys=(ACCESS_KEY, SECRET_KEY),
        token=TOKEN,
        latency_s=0.0,
        fault=None,
        **options,
    ):
        self.document, self.replies = document, Replies(document, **options)
        self._options = options
        self.keys, self.latency_s, self.fault = keys, latency_s, fault
        self._gate = Gate(keys, token)
        self._packed = {}
        self.calls = []
        self.at_once = self.most_at_once = 0
        self._cache = {}
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
        """The environment variables that carry the credentials, and let files name the server."""
        keys = {"ONSHAPE_ACCESS_KEY": self.keys[0], "ONSHAPE_SECRET_KEY": self.keys[1]}
        return {**keys, "LINKWRIGHT_HOST": self.url}

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

    def edit(self, document):
        """Puts another state of the document in the workspace; the microversions before it stay."""
        self.replies = Replies(document, **self._options, earlier=self.replies)
        self.document = document

    def answer(self, method, target, headers, sent=b""):
        """Status, body and headers for one request, and how to send them; counts it."""
        with self._lock:
            number = len(self.calls)
            self.calls.append((method, target, 0))
            self.at_once += 1
            self.most_at_once = max(self.most_at_once, self.at_once)
        if self.latency_s:
            time.sleep(self.latency_s)
        fault = (self.fault(method, target, number) if self.fault else None) or SOUND
        status, body, own = fault.status, fault.body, {}
        if body is None:
            status, body, own = self._decide(method, target, headers, sent)
            status = status if fault.status == 200 else fault.status
            if "gzip" in headers.get("Accept-Encoding", "") and len(body) > WORTH_PACKING:
                body, own = self._pack(body), {**own, "Content-Encoding": "gzip"}
        with self._lock:
            if number < len(self.calls):
                self.calls[number] = (method, target, 0 if fault.silent else status)
            self.at_once -= 1
        return status, body, {**own, **fault.headers}, fault

    def _pack(self, body):
        packed = self._packed.get(body)
        if packed is None:
            packed = self._packed[body] = gzip.compress(body, 1, mtime=0)
        return packed

    def _decide(self, method, target, received, sent):
        match = re.match(r"/api(?:/(v\d+))?(/[^?]*)\??(.*)$", target)
        if match is None:
            return 404, error_body(404, "Not found."), {}
        served = f"v{self.replies.version(int(match[1][1:]))}" if match[1] else "v0"
        headers = {"X-Api-Version": served, "On-Version": RELEASE}
        with self._lock:
            refused = self._gate.refuses(method, target, received)
        if refused:
            return 401, error_body(401, refused), headers
        if method == "POST":
            with self._lock:
                reply, document = self.replies.post(match[2], sent)
                if document is not self.document:
                    self.edit(document)
            return reply.status, reply.body, headers
        if method != "GET":
            return 405, error_body(405, "Method not allowed."), headers
        with self._lock:
            key = (id(self.replies), target)
            kept = self._cache.get(key)
            if kept is None:
                kept = self._reply(match[1], match[2], match[3])
                self._cache[key] = kept
        reply, own = kept
        if reply.endpoint == "gltf" and "model/gltf" not in received.get("Accept", ""):
            return 406, error_body(406, "Request not acceptable."), headers
        headers |= own
        left = WINDOW.get(reply.endpoint, 3000) - self._asked(reply.endpoint)
        return reply.status, reply.body, {**headers, "X-Rate-Limit-Remaining": str(max(0, left))}

    def _reply(self, version, path, query):
        """The reply, and headers of its own; without a version in the path, as other clients ask."""
        if version is None:
            return PeerReplies(self.replies, self.url).answer(path, query)
        return self.replies.answer(path, query, int(version[1:])), {}

    def _asked(self, endpoint):
        suffix = {"definition": "/assemblies/"}.get(endpoint, f"/{endpoint}")
        return sum(suffix in target for _, target, _ in self.calls)

    def _handler(server):  # noqa: N805 - the handler has a self of its own
        class Handler(BaseHTTPRequestHandler):
            protocol_version = "HTTP/1.1"
            disable_nagle_algorithm = True

            def do_GET(self):
                length = int(self.headers.get("Content-Length") or 0)
                sent = self.rfile.read(length) if length else b""
                status, body, own, fault = server.answer(self.command, self.path, self.headers, sent)
                kind = {"Content-Type": "application/json;charset=UTF-8"}
                headers = {"X-Request-Id": ids.hex_id(self.path), **kind, **own}
                send(self, status, headers, body, fault)

            do_POST = do_PUT = do_DELETE = do_GET  # noqa: N815 - the names http.server calls

            def log_message(self, *_):
                pass

        return Handler
