"""Defines an API call: method, request, body and headers."""

from dataclasses import dataclass

from linkwright.stages.fetch.onshape.api import signing
from linkwright.stages.fetch.onshape.api.credentials import Credentials
from linkwright.stages.fetch.onshape.requests import describe


@dataclass(frozen=True, slots=True)
class ApiCall:
    """An API call."""

    method: str
    request: str
    accept: str
    content: bytes | None = None
    restores: bool = False
    """Whether the call undoes a change, so that it is made even after all other calls were stopped."""

    @property
    def subject(self) -> str:
        """Describes the request in words, for messages."""
        return describe(self.request)

    def headers(self, credentials: Credentials, target: str) -> dict[str, str]:
        """Returns the headers, signed for the address `target`."""
        content = {} if self.content is None else {"Content-Type": signing.CONTENT_TYPE}
        return {"Accept": self.accept, **content, **signing.headers(credentials, self.method, target)}
