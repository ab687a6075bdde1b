"""What fetch asks of the pipeline: a place that keeps replies for ever."""

from typing import Protocol


class Replies(Protocol):
    """Kept replies by request. Only pinned, hence immutable, replies come here.

    Fetch calls it from one thread at a time.
    """

    def get(self, request: str) -> bytes | None:
        """The reply to `request`, or None where it is not kept."""
        ...

    def put(self, request: str, body: bytes) -> None:
        """Keep `body` as the reply to `request`."""
        ...
