"""Replies that are kept in memory, and a fetch that uses them."""

import contextlib
from collections import defaultdict
from threading import Lock, RLock

from linkwright.stages import fetch as stage
from linkwright.stages.fetch.onshape.api.client import Client
from linkwright.stages.fetch.onshape.api.credentials import Credentials
from linkwright.stages.fetch.onshape.api.retries import Patience
from linkwright.stages.fetch.onshape.url import AssemblyUrl
from linkwright.stages.fetch.section import FetchSections
from linkwright.stages.fetch.source import FetchContext

QUICK = Patience(first_wait=0.001, longest_wait=0.004, jitter=0.001, connect=5, read=10, whole=20)
"""Asks again at once: tests have no time to wait."""


class Kept(dict):
    """Replies by request, and `facts`; asserts that one thread at a time comes."""

    def __init__(self):
        super().__init__()
        self.facts = {}
        self._lock = Lock()
        self._alone = defaultdict(RLock)

    def get(self, request):
        with self._one_at_a_time():
            return super().get(request)

    def put(self, request, body):
        with self._one_at_a_time():
            self[request] = body

    def recall(self, subject):
        with self._one_at_a_time():
            return self.facts.get(subject)

    def remember(self, subject, fact):
        with self._one_at_a_time():
            self.facts[subject] = fact

    def lock(self, subject):
        return self._alone[subject]

    @contextlib.contextmanager
    def _one_at_a_time(self):
        assert self._lock.acquire(blocking=False)
        try:
            yield
        finally:
            self._lock.release()


ADDRESS = "https://cad.onshape.com/documents/{}/w/{}/e/{}".format("a" * 24, "b" * 24, "c" * 24)
"""An address that has the shape of one, and is nobody's."""


def onshape(url, **keys):
    """The fetch stage's keys for an address."""
    return FetchSections.model_validate({"source": {"kind": "onshape", "url": url, **keys}})


def recording(path):
    """The fetch stage's keys for a bundle in a zip file."""
    return FetchSections.model_validate({"source": {"kind": "bundle", "path": str(path)}})


KEY = Credentials("the-access", "the-secret")


def client_at(origin, key=KEY, patience=QUICK, **more):
    """A client for an assembly at this origin, whose document does not exist."""
    return Client(AssemblyUrl(origin, "D", "w/W", "ROOT", "default"), key, patience=patience, **more)


def fetched(keys, kept=None, environ=None, lines=None, **more):
    """What the stage fetches, with replies in memory."""
    more.setdefault("patience", QUICK)
    progress = (lines if lines is not None else []).append
    return stage.fetch(keys, FetchContext(Kept() if kept is None else kept, environ or {}, progress, **more))
