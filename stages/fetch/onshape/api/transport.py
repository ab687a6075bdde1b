"""Sends an HTTP request and returns its complete reply, and is the only module that imports httpx."""

import contextlib
import os
import re
import socket
import ssl
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from threading import Lock
from typing import Any
from weakref import WeakSet

import httpx

from linkwright.stages.fetch.onshape import reply_sizes
from linkwright.stages.fetch.onshape.api import connection_errors, decompression
from linkwright.stages.fetch.onshape.api.connection_errors import ConnectionFault
from linkwright.stages.fetch.onshape.api.retries import Patience
from linkwright.stages.robot.errors import ConfigError

AT_ONCE = 4
"""Largest number of connections: the server's limits are per window, and more are no faster."""

_MAX_IN_MEMORY = 1 << 20
"""Size up to which a body is collected in memory instead of a file [bytes]."""

_UNREACHED_ERRORS = (httpx.ConnectError, httpx.ConnectTimeout, httpx.ProxyError, httpx.UnsupportedProtocol)
_BROKEN_CONNECTION: Mapping[type[httpx.HTTPError], str] = {
    httpx.RemoteProtocolError: "it closed the connection, or does not speak HTTP",
    httpx.ReadError: "the connection broke off",
    httpx.WriteError: "the connection broke off",
}


@dataclass(frozen=True, slots=True)
class HttpReply:
    """A complete reply."""

    status: int
    headers: Mapping[str, str]
    """Looks names up without regard to case."""

    body: bytes
    """The unpacked body."""


class NoReply(Exception):
    """The error that a reply is missing or incomplete. Its text gives the reason and contains no secret.

    `begun`: the request may have reached the server; `status`: the status that arrived before the rest was
    lost, or 0; `late`: the reply took too long; `trouble`: the error of the connection, if it is known.
    """

    def __init__(
        self,
        why: str,
        *,
        begun: bool,
        status: int,
        late: bool = False,
        trouble: ConnectionFault | None = None,
    ) -> None:
        super().__init__(why)
        self.begun = begun
        self.status = status
        self.late = late
        self.trouble = trouble


class ReplyTooLarge(Exception):
    """The error that a reply is larger than the limit of its kind."""


class UnexpectedEncoding(Exception):
    """The error that a reply has an unexpected content encoding; its text names the encoding."""


class _TracedConnection:
    """The connection of a request: `met`, the host and port that were tried."""

    def __init__(self, wire: "Wire") -> None:
        self._wire = wire
        self.met: tuple[str, int] | None = None

    def trace(self, event: str, info: Mapping[str, Any]) -> None:
        if event.endswith("connect_tcp.started"):
            self.met = (str(info["host"]), int(info["port"]))
        # TLS replaces the plain socket.
        if event.endswith(("connect_tcp.complete", "start_tls.complete")):
            self._wire.connected(info["return_value"].get_extra_info("socket"))


class Wire:
    """The connections to a host, which are kept alive. Safe to use from several threads."""

    def __init__(
        self, patience: Patience, *, loopback: bool, arrived: Callable[[int], None] = lambda _: None
    ) -> None:
        """Prepares the connections. `arrived` is called with the size [bytes] of each piece of a reply."""
        self._arrived = arrived
        self._whole = patience.whole
        self._sockets: WeakSet[socket.socket] = WeakSet()
        self._lock = Lock()
        self._http = _client(patience, loopback=loopback)

    def close(self) -> None:
        """Closes the library's client."""
        self._http.close()

    def disconnect(self) -> None:
        """Closes all connections: every waiting caller gets Lost at once. New requests may be sent.

        Closing a socket does not wake a thread that waits for it; shutting it down does.
        """
        with self._lock:
            sockets = list(self._sockets)
        for connected in sockets:
            with contextlib.suppress(OSError):
                # Not the method of a TLS socket, which first takes the encryption off.
                socket.socket.shutdown(connected, socket.SHUT_RDWR)

    def connected(self, new_socket: socket.socket) -> None:
        """Records a new socket."""
        with self._lock:
            self._sockets.add(new_socket)

    def send(
        self,
        method: str,
        address: str,
        headers: Callable[[str], Mapping[str, str]],
        content: bytes | None,
        on_reply: Callable[[int, Mapping[str, str]], None],
        max_size: int,
    ) -> HttpReply:
        """Returns the reply to a request. Raises Lost, ReplyTooLarge or Packed if it is unusable.

        `headers` gets path and query as they are sent; `on_reply` gets status and headers as soon as they
        arrive, since that is when a call is billed; `max_size`: bytes that a reply may unpack to.
        """
        # The address goes out as it is, never encoded a second time.
        url = httpx.URL(address)
        status, deadline, connection = 0, time.monotonic() + self._whole, _TracedConnection(self)
        try:
            request = self._http.build_request(
                method,
                url,
                headers=dict(headers(url.raw_path.decode("ascii"))),
                content=content,
                extensions={"trace": connection.trace},
            )
            response = self._http.send(request, stream=True)
            try:
                status = response.status_code
                on_reply(status, response.headers)
                return HttpReply(status, response.headers, _body(response, deadline, max_size, self._arrived))
            finally:
                response.close()
        except _UNREACHED_ERRORS as error:
            late = isinstance(error, httpx.TimeoutException)
            if isinstance(error, httpx.ProxyError):
                problem = connection_errors.refused_by_proxy(str(error), url.host, connection.met)
            else:
                problem = connection_errors.connection_fault(error, url.host, connection.met)
            why = type(error).__name__
            raise NoReply(why, begun=False, status=0, late=late, trouble=problem) from error
        except httpx.HTTPError as error:
            late = isinstance(error, httpx.TimeoutException)
            why = _BROKEN_CONNECTION.get(type(error)) or type(error).__name__
            raise NoReply(why, begun=True, status=status, late=late) from error


def _client(patience: Patience, *, loopback: bool) -> httpx.Client:
    """Returns a client of the library. Raises ConfigError if the library rejects the proxy settings of the
    environment."""
    try:
        return httpx.Client(
            headers={"User-Agent": "linkwright", "Accept-Encoding": decompression.ACCEPTED},
            # A call that waits for a free connection has not begun; no limit fits that.
            timeout=httpx.Timeout(patience.read, connect=patience.connect, pool=None),
            limits=httpx.Limits(max_connections=AT_ONCE, max_keepalive_connections=AT_ONCE),
            follow_redirects=False,
            verify=_trusted(os.environ.get("SSL_CERT_FILE"), os.environ.get("SSL_CERT_DIR")),
            # A proxy is for the world outside; it cannot reach this computer's own loopback.
            trust_env=not loopback,
        )
    except (ValueError, ImportError, httpx.InvalidURL):
        # Its words may show a proxy's password. Known errors were reported before.
        msg = "the proxy settings cannot be read"
        hint = "set HTTPS_PROXY and NO_PROXY to what your network needs, or unset them"
        raise ConfigError(msg, "NO_PROXY", hint) from None


@lru_cache(maxsize=4)
def _trusted(file: str | None, folder: str | None) -> ssl.SSLContext:
    """Returns the certificate authorities that the environment names, or else those of the library.

    The function is cached: reading them takes longer than a request.
    """
    return httpx.create_ssl_context()


def _pieces(response: httpx.Response, arrived: Callable[[int], None]) -> Iterator[bytes]:
    """Yields the compressed body in pieces; `arrived` is called with the size of each."""
    for piece in response.iter_raw():
        arrived(len(piece))
        yield piece


def _body(response: httpx.Response, deadline: float, limit: int, arrived: Callable[[int], None]) -> bytes:
    """Returns the body, collected in an unnamed file, which does not outlive the process."""
    status = response.status_code
    is_success = status < 300
    length_header = response.headers.get("Content-Length", "")
    announced_length = int(length_header) if re.fullmatch("[0-9]{1,20}", length_header) else None
    encoding = response.headers.get("Content-Encoding", "")
    if is_success and announced_length is not None and announced_length > limit:
        raise ReplyTooLarge
    with tempfile.SpooledTemporaryFile(_MAX_IN_MEMORY) as file:
        try:
            for piece in decompression.decompressed(_pieces(response, arrived), encoding):
                file.write(piece)
                if time.monotonic() > deadline:
                    raise NoReply("too slow", begun=True, status=status, late=True)
                if is_success and max(file.tell(), response.num_bytes_downloaded) > limit:
                    raise ReplyTooLarge
                if not is_success and file.tell() > reply_sizes.REFUSAL:
                    break
        except (httpx.HTTPError, decompression.DamagedError, decompression.UnknownEncodingError) as error:
            # Of a refusal the status says enough; only the server's own words are lost.
            if is_success:
                raise _body_error(error, status) from error
        if is_success and announced_length is not None and announced_length != response.num_bytes_downloaded:
            raise NoReply("length", begun=True, status=status)
        file.seek(0)
        return file.read()


def _body_error(error: Exception, status: int) -> Exception:
    """Returns the error for an incomplete body."""
    if isinstance(error, decompression.UnknownEncodingError):
        return UnexpectedEncoding(str(error))
    if isinstance(error, decompression.DamagedError):
        return NoReply("damaged", begun=True, status=status)
    return error
