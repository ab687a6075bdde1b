"""The one HTTP client: authenticated, counted, a few calls at a time.

The only module that imports httpx.
"""

import threading
from types import TracebackType
from urllib.parse import urlsplit

import httpx

from stages.fetch.credentials import Credentials
from stages.fetch.refusals import refusal
from stages.fetch.requests import API, describe
from stages.fetch.url import AssemblyUrl
from stages.robot.errors import Offline, ProtocolError

AT_ONCE = 4
"""Calls in flight at most: the server's limits are per window, and it answers no faster to more."""

_CONNECT_S = 30.0
_READ_S = 300.0
_LARGEST = 1 << 30
_LARGEST_REFUSAL = 64 * 1024
_PAGE = b"<"


class Client:
    """Asks one host. Safe to call from several threads; a context manager."""

    def __init__(self, url: AssemblyUrl, credentials: Credentials) -> None:
        self.host = urlsplit(url.origin).netloc
        self._credentials = credentials
        self._lock = threading.Lock()
        self._calls = 0
        self._http = httpx.Client(
            base_url=f"{url.origin}/api/{API}",
            auth=httpx.BasicAuth(credentials.access, credentials.secret),
            headers={"Accept": "application/json;charset=UTF-8; qs=0.09", "User-Agent": "linkwright"},
            timeout=httpx.Timeout(_READ_S, connect=_CONNECT_S),
            limits=httpx.Limits(max_connections=AT_ONCE, max_keepalive_connections=AT_ONCE),
            follow_redirects=False,
            # A proxy is for the world outside; it cannot reach this computer's own loopback.
            trust_env=not url.loopback,
        )

    def __enter__(self) -> "Client":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._http.close()

    @property
    def calls(self) -> int:
        """Calls that count against the quota so far: every 2xx and 3xx."""
        return self._calls

    def get(self, request: str) -> bytes:
        """The body of the reply to `request`.

        AuthError, NotFound, QuotaExhausted, RateLimited, SourceError or ProtocolError where the
        server refuses or answers with something else; Offline where it cannot be reached.
        """
        answered = False
        try:
            # Built by hand: the canonical request is sent as it is, never encoded a second time.
            url = httpx.URL(str(self._http.base_url).rstrip("/") + request)
            with self._http.stream("GET", url) as response:
                answered = True
                self._count(response.status_code)
                if response.status_code != 200:
                    raise self._refusal(response, request)
                return self._body(response, request)
        except httpx.TimeoutException as error:
            msg = f"{self.host} did not answer in time for {describe(request)}"
            raise Offline(msg, self.host, "run the same command again; what was fetched is kept") from error
        except (httpx.RemoteProtocolError, httpx.DecodingError) as error:
            raise self._broken(request) from error
        except httpx.HTTPError as error:
            if answered:
                raise self._broken(request) from error
            msg = f"{self.host} cannot be reached: {type(error).__name__}"
            hint = (
                "check the network and the host in source.url, or build offline: source=sample, source=bundle"
            )
            raise Offline(msg, self.host, hint) from error

    def _count(self, status: int) -> None:
        if 200 <= status < 400:
            with self._lock:
                self._calls += 1

    def _body(self, response: httpx.Response, request: str) -> bytes:
        body = bytearray()
        for chunk in response.iter_bytes():
            body += chunk
            if len(body) > _LARGEST:
                msg = f"the reply with {describe(request)} is larger than {_LARGEST >> 20} MiB"
                raise ProtocolError(msg, self.host, "use a coarser source.tessellation")
        promised = response.headers.get("Content-Length", "")
        if promised.isdigit() and int(promised) != response.num_bytes_downloaded:
            raise self._broken(request)
        if body.lstrip()[:1] == _PAGE:
            msg = f"the server sent a web page instead of {describe(request)}"
            raise ProtocolError(
                msg, self.host, "check the host in source.url, and that no proxy asks for a login"
            )
        return bytes(body)

    def _refusal(self, response: httpx.Response, request: str) -> Exception:
        body = b""
        try:
            for chunk in response.iter_bytes():
                body += chunk
                if len(body) > _LARGEST_REFUSAL:
                    break
        except httpx.HTTPError:
            pass  # the status says enough; only the server's own words are lost
        text = self._credentials.scrub(body.decode("utf-8", "replace"))
        return refusal(response.status_code, response.headers, text, request, self.host)

    def _broken(self, request: str) -> ProtocolError:
        msg = f"the reply with {describe(request)} was cut short"
        return ProtocolError(msg, self.host, "run the same command again; what was fetched is kept")
