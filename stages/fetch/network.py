"""Answers from an Onshape server, each paid for once."""

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import FIRST_EXCEPTION, ThreadPoolExecutor, wait
from threading import Lock

from stages.fetch import definition, requests
from stages.fetch.client import AT_ONCE, Client
from stages.fetch.credentials import find
from stages.fetch.envelope import check
from stages.fetch.onshape import Answer, Needs, Reply
from stages.fetch.replies import Replies
from stages.fetch.url import AssemblyUrl
from stages.robot.errors import ProtocolError


class Network:
    """Asks the kept replies first and the server for the rest; keeps what arrives at once.

    A context manager: the connections live as long as it.
    """

    def __init__(
        self,
        url: AssemblyUrl,
        quality: requests.Tessellation,
        replies: Replies,
        environ: Mapping[str, str],
        tell: Callable[[str], None],
    ) -> None:
        self._url = url
        self._quality = quality
        self._replies = replies
        self._environ = environ
        self._tell = tell
        self._lock = Lock()
        self._client: Client | None = None
        self.saved = 0
        """Calls that kept replies made needless."""

    def __enter__(self) -> "Network":
        return self

    def __exit__(self, *reason: object) -> None:
        if self._client is not None:
            self._client.__exit__(None, None, None)

    @property
    def calls(self) -> int:
        """Calls made that count against the quota."""
        return self._client.calls if self._client else 0

    def configuration(self) -> str:
        return self._url.configuration

    def definition(self) -> Reply:
        url = self._url
        request = requests.definition(url.document, url.pin, url.element, url.configuration)
        if url.pinned:
            body = self._kept(request)
            if body is None:
                self._tell("asking for the assembly definition")
                body = self._fetched(request, keep=request)
            return Reply(request, body)
        self._tell("asking for the assembly definition")
        body = self._fetched(request, keep=None)
        # What a workspace holds changes; what its microversion holds does not.
        found = definition.read(body)
        pinned = requests.definition(url.document, f"m/{found.microversion}", url.element, url.configuration)
        self._keep(pinned, body)
        return Reply(pinned, body)

    def studios(self, needs: Sequence[Needs]) -> Sequence[Answer]:
        wanted = [
            (
                requests.mass_properties(need.studio, need.root),
                requests.tessellated_faces(need.studio, need.root, self._quality),
            )
            for need in needs
        ]
        bodies = self._all([request for pair in wanted for request in pair])
        return [
            Answer((Reply(mass, bodies[mass]),), Reply(triangles, bodies[triangles]))
            for mass, triangles in wanted
        ]

    def _all(self, wanted: Sequence[str]) -> dict[str, bytes]:
        """The bodies of all requests, kept or fetched, a few at a time.

        After a failure no further call begins, but those on their way are finished and kept, since
        they are paid for. Of several failures the first in order is told.
        """
        kept = {request: self._kept(request) for request in wanted}
        bodies = {request: body for request, body in kept.items() if body is not None}
        missing = [request for request in wanted if request not in bodies]
        studios = len(wanted) // 2
        self._tell(f"{_count(studios, 'part studio')}: {_count(len(missing), 'call')}, {len(bodies)} kept")
        if not missing:
            return bodies
        self._connection()
        pool = ThreadPoolExecutor(AT_ONCE, thread_name_prefix="fetch")
        try:
            futures = [pool.submit(self._fetched, request, request) for request in missing]
            wait(futures, return_when=FIRST_EXCEPTION)
        finally:
            pool.shutdown(wait=True, cancel_futures=True)
        for future in futures:
            if not future.cancelled() and (error := future.exception()):
                raise error
        return bodies | {request: future.result() for request, future in zip(missing, futures, strict=True)}

    def _fetched(self, request: str, keep: str | None) -> bytes:
        """The reply from the server, checked, and kept under `keep`."""
        client = self._connection()
        body = client.get(request)
        try:
            check(request, body)
            if requests.is_definition(request):
                self._same_assembly(body)
        except ProtocolError as error:
            raise ProtocolError(error.message, client.host, error.hint) from error
        if keep is not None:
            self._keep(keep, body)
        return body

    def _same_assembly(self, body: bytes) -> None:
        found = definition.read(body)
        if (found.document, found.element) != (self._url.document, self._url.element):
            msg = f"the server gave assembly {found.element} where {self._url.element} was asked for"
            raise ProtocolError(msg, hint="run the same command again")

    def _kept(self, request: str) -> bytes | None:
        with self._lock:
            body = self._replies.get(request)
        if body is not None:
            self.saved += 1
        return body

    def _keep(self, request: str, body: bytes) -> None:
        with self._lock:
            self._replies.put(request, body)

    def _connection(self) -> Client:
        """The client, made when the first call is due: a build from kept replies needs no key."""
        if self._client is None:
            self._client = Client(self._url, find(self._environ))
        return self._client


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"
