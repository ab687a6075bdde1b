"""Counts the refusals of tessellated faces whose glTF is cached.

The first refusal may be a temporary fault, so the next build that may call asks for the faces once more.
After the second the glTF is used until `source.refresh`. All fetches of a sweep count as one build.
"""

import time
from collections.abc import Iterable

from linkwright.stages.fetch.onshape.asking.cached_client import CachedClient
from linkwright.stages.fetch.onshape.requests import is_gltf


class Refusals:
    """The count of refusals of the faces that a glTF, named by its request, replaces."""

    def __init__(self, client: CachedClient) -> None:
        self._client = client
        self._carried: set[str] = set()

    def record_first(self, gltf: str) -> None:
        """Records a refusal that begins the count: the glTF was just fetched."""
        self._client.remember(_subject(gltf), {"refusals": 1, "at": time.time()})

    def record_second(self, gltf: str) -> None:
        """Records that the faces were refused again."""
        self._client.remember(_subject(gltf), {"refusals": 2, "at": time.time()})

    def is_settled(self, gltf: str) -> bool:
        """Tells whether the faces were refused twice. A glTF of an earlier version of the program has no
        record."""
        return gltf in self._carried or self._client.recall(_subject(gltf)).get("refusals", 1) > 1

    def is_due(self, gltf: str) -> bool:
        """Tells whether this build must ask for the faces again, if it may call."""
        refused_at = self._client.recall(_subject(gltf)).get("at", 0.0)
        is_earlier = self._client.sweep is None or refused_at < self._client.sweep.began
        return is_earlier and not self.is_settled(gltf)

    def carry(self, old: str, new: str) -> None:
        """Copies the count of `old` to `new`, the same reply at a later microversion; `keep` stores it."""
        if is_gltf(new) and self.is_settled(old):
            self._carried.add(new)

    def keep(self, reused: Iterable[str], refetched: Iterable[str]) -> None:
        """Stores the carried counts for replies that are `reused`; the count of `refetched` replies
        begins."""
        for gltf in self._carried.intersection(reused).difference(refetched):
            self.record_second(gltf)
        for gltf in filter(is_gltf, refetched):
            self.record_first(gltf)
        self._carried.clear()


def _subject(gltf: str) -> str:
    return f"{gltf}#faces"
