"""One request over HTTP and its reply, whole or not at all. The only module that imports httpx."""

import contextlib
import socket
import tempfile
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from threading import Lock
from typing import Any
from weakref import WeakSet

import httpx

from stages.fetch.retries import Patience

AT_ONCE = 4
"""Connections at most: the server's limits are per window, and it answers no faster to more."""

_IN_MEMORY = 1 << 20
_LARGEST = 1 << 30
_LARGEST_REFUSAL = 64 * 1024


@dataclass(frozen=True, slots=True)
class Answer:
    """A reply. `headers` looks names up without regard to case; `body` is unpacked."""

    status: int
    headers: Mapping[str, str]
    body: bytes


class Lost(Exception):
    """There is no whole reply. Its text says why and holds nothing that was sent.

    `begun`: the request may have reached the server; `status`: what it answered before the rest
    was lost, 0 where it answered nothing; `late`: it took too long.
    """

    def __init__(self, why: str, *, begun: bool, status: int, late: bool = False) -> None:
        super().__init__(why)
        self.begun = begun
        self.status = status
        self.late = late


class TooLarge(Exception):
    """A reply beyond any size that makes sense."""


class Wire:
    """Connections that are kept alive. Safe to use from several threads."""

    def __init__(
        self, patience: Patience, *, loopback: bool, arrived: Callable[[int], None] = lambda _: None
    ) -> None:
        """`arrived` hears of each piece of a reply, how many bytes it took."""
        self._arrived = arrived
        self._whole = patience.whole
        self._sockets: WeakSet[socket.socket] = WeakSet()
        self._lock = Lock()
        self._http = httpx.Client(
            headers={"User-Agent": "linkwright"},
            # A call that waits for a free connection has not begun; no limit fits that.
            timeout=httpx.Timeout(patience.read, connect=patience.connect, pool=None),
            limits=httpx.Limits(max_connections=AT_ONCE, max_keepalive_connections=AT_ONCE),
            follow_redirects=False,
            # A proxy is for the world outside; it cannot reach this computer's own loopback.
            trust_env=not loopback,
        )

    def close(self) -> None:
        self._http.close()

    def hang_up(self) -> None:
        """Ends what is on its way: whoever waits for it gets Lost at once. New requests may be sent.

        To close a socket does not wake a thread that waits for it; to shut it down does.
        """
        with self._lock:
            sockets = list(self._sockets)
        for connected in sockets:
            with contextlib.suppress(OSError):
                # Not the method of a TLS socket, which first takes the encryption off.
                socket.socket.shutdown(connected, socket.SHUT_RDWR)

    def _trace(self, event: str, told: Mapping[str, Any]) -> None:
        """Takes down each socket as it is made. TLS puts another in the place of the plain one."""
        if event.endswith(("connect_tcp.complete", "start_tls.complete")):
            with self._lock:
                self._sockets.add(told["return_value"].get_extra_info("socket"))

    def send(
        self,
        method: str,
        address: str,
        headers: Callable[[str], Mapping[str, str]],
        content: bytes | None,
        met: Callable[[int, Mapping[str, str]], None],
    ) -> Answer:
        """The reply to one request; Lost or TooLarge where there is none.

        `headers` gets path and query as they are sent; `met` gets status and headers as soon as
        they are there, since that is when a call is billed.
        """
        # The address goes out as it is, never encoded a second time.
        url = httpx.URL(address)
        status, until = 0, time.monotonic() + self._whole
        try:
            request = self._http.build_request(
                method,
                url,
                headers=dict(headers(url.raw_path.decode("ascii"))),
                content=content,
                extensions={"trace": self._trace},
            )
            response = self._http.send(request, stream=True)
            try:
                status = response.status_code
                met(status, response.headers)
                return Answer(status, response.headers, self._body(response, until))
            finally:
                response.close()
        except (httpx.ConnectError, httpx.ConnectTimeout, httpx.UnsupportedProtocol) as error:
            late = isinstance(error, httpx.TimeoutException)
            raise Lost(type(error).__name__, begun=False, status=0, late=late) from error
        except httpx.HTTPError as error:
            late = isinstance(error, httpx.TimeoutException)
            raise Lost(type(error).__name__, begun=True, status=status, late=late) from error

    def _body(self, response: httpx.Response, until: float) -> bytes:
        """The body, gathered in a file without a name, which no kill can leave behind."""
        good = response.status_code < 300
        with tempfile.SpooledTemporaryFile(_IN_MEMORY) as file:
            try:
                downloaded = 0
                for chunk in response.iter_bytes():
                    file.write(chunk)
                    self._arrived(response.num_bytes_downloaded - downloaded)
                    downloaded = response.num_bytes_downloaded
                    if time.monotonic() > until:
                        raise Lost("too slow", begun=True, status=response.status_code, late=True)
                    if good and file.tell() > _LARGEST:
                        raise TooLarge
                    if not good and file.tell() > _LARGEST_REFUSAL:
                        break
            except httpx.HTTPError:
                if good:
                    raise
                # The status says enough; only the server's own words are lost.
            promised = response.headers.get("Content-Length", "")
            if good and promised.isdigit() and int(promised) != response.num_bytes_downloaded:
                raise Lost("length", begun=True, status=response.status_code)
            file.seek(0)
            return file.read()
