"""Defines the interface of the pipeline's store: replies are kept for ever, records until they change."""

from collections.abc import Mapping
from contextlib import AbstractContextManager
from typing import Any, Protocol


class ReplyStore(Protocol):
    """The interface of a store of replies by request. Only pinned, hence immutable, replies are stored.

    Fetch calls it from one thread at a time, except for `lock`.
    """

    def get(self, request: str) -> bytes | None:
        """Returns the stored reply to `request`, or None."""
        ...

    def put(self, request: str, body: bytes) -> None:
        """Stores `body` as the reply to `request`; replaces an earlier one."""
        ...

    def recall(self, subject: str) -> Mapping[str, Any] | None:
        """Returns the record stored for `subject`, or None."""
        ...

    def remember(self, subject: str, fact: Mapping[str, Any]) -> None:
        """Stores `fact` (plain data) for `subject`; replaces an earlier record."""
        ...

    def lock(self, subject: str) -> AbstractContextManager[None]:
        """Returns a lock for each `subject`, between threads and processes."""
        ...
