"""Interface of the store that the pipeline provides: replies are kept for ever, records until they change."""

from collections.abc import Mapping
from contextlib import AbstractContextManager
from typing import Any, Protocol


class ReplyStore(Protocol):
    """Stores replies by request. Only pinned, hence immutable, replies are stored.

    Fetch calls it from one thread at a time, except for `alone`.
    """

    def get(self, request: str) -> bytes | None:
        """The stored reply to `request`, or None."""
        ...

    def put(self, request: str, body: bytes) -> None:
        """Stores `body` as the reply to `request`; replaces an earlier one."""
        ...

    def recall(self, subject: str) -> Mapping[str, Any] | None:
        """The record stored for `subject`, or None."""
        ...

    def remember(self, subject: str, fact: Mapping[str, Any]) -> None:
        """Stores `fact` (plain data) for `subject`; replaces an earlier record."""
        ...

    def alone(self, subject: str) -> AbstractContextManager[None]:
        """A lock for each `subject`, between threads and processes."""
        ...
