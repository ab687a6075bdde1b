"""Interface of the store that the pipeline provides: replies kept for ever, facts until they change."""

from collections.abc import Mapping
from contextlib import AbstractContextManager
from typing import Any, Protocol


class ReplyStore(Protocol):
    """Kept replies by request. Only pinned, hence immutable, replies come here.

    Fetch calls it from one thread at a time, except for `alone`.
    """

    def get(self, request: str) -> bytes | None:
        """The reply to `request`, or None where it is not kept."""
        ...

    def put(self, request: str, body: bytes) -> None:
        """Keep `body` as the reply to `request`, in place of any other."""
        ...

    def recall(self, subject: str) -> Mapping[str, Any] | None:
        """What was last remembered of `subject`, or None."""
        ...

    def remember(self, subject: str, fact: Mapping[str, Any]) -> None:
        """Keep `fact` (plain data) of `subject`, in place of what was remembered before."""
        ...

    def alone(self, subject: str) -> AbstractContextManager[None]:
        """Only one thread of one process at a time is inside, for each `subject`."""
        ...
