"""Faults in their order, and what must hold of a fetch that meets them.

The robot is made from the bundle alone, so the right bundle is the right robot.
"""

from collections import Counter
from dataclasses import replace

from linkwright.pipeline.caching.actions import Cache
from linkwright.pipeline.caching.maintenance import verify
from linkwright.pipeline.caching.store import Store
from linkwright.stages import fetch as stage
from linkwright.stages.fetch.onshape.api.ledger import years
from linkwright.stages.fetch.source import Calls, FetchContext
from linkwright.stages.robot.errors import SourceError
from tests.fake_onshape import solids
from tests.fake_onshape.document import Document
from tests.fake_onshape.faults import Fault
from tests.fake_onshape.server import OnshapeServer
from tests.support.kept import QUICK, fetched, onshape

MOST_BILLED = 2
"""How often one run may ask for a reply that is billed and then lost."""

HURRIED = replace(QUICK, read=0.5)
"""For a server that is slow on purpose; with all others, a busy machine would count as slow."""

PAGE = b"<!doctype html><html><body>502 Bad Gateway</body></html>"

PASSING = {
    "429": Fault(429, headers={"Retry-After": "0"}),
    "429 without a time": Fault(429),
    "499": Fault(499, b'{"message": "The call is taking too long."}'),
    "500": Fault(500, b'{"message": "An internal error has occurred."}'),
    "502": Fault(502, PAGE, {"Content-Type": "text/html"}),
    "503": Fault(503, headers={"Retry-After": "0"}),
    "hangs up": Fault(silent=True),
    "resets at once": Fault(silent=True, reset=True),
    "cut short": Fault(body=None, cut=100),
    "cut to nothing": Fault(body=None, cut=0),
    "length too long": Fault(body=None, claimed=7),
    "length too short": Fault(body=None, claimed=-40),
    "resets within": Fault(body=None, cut=60, reset=True),
    "not JSON": Fault(body=b'{"bodies": {"a": nope'),
    "empty": Fault(body=b""),
    "another thing": Fault(body=b'{"message": "hello"}'),
}
"""What may pass: a fetch that meets one of these once ends with the right bundle."""

FINAL = {
    "204": Fault(204),
    "400": Fault(400, b'{"message": "Bad."}'),
    "401": Fault(401, b'{"message": "Unauthenticated API request."}'),
    "402": Fault(402),
    "403": Fault(403, PAGE),
    "404": Fault(404, PAGE),
    "406": Fault(406, b'{"message": "Request not acceptable."}'),
    "410": Fault(410),
    "429 for an hour": Fault(429, headers={"Retry-After": "3600"}),
    "503 for an hour": Fault(503, headers={"Retry-After": "3600"}),
    "307 to nowhere": Fault(307),
    "307 to others": Fault(307, headers={"Location": "https://example.org/api/v16/x"}),
    "a page": Fault(200, PAGE, {"Content-Type": "text/html"}),
}
"""What does not pass: a fetch that meets one of these once ends with an error."""

DECLINED = ("400", "404", "406", "410")
"""The faults among these that ask for another way: glTF replaces the triangles that meet them."""

SLOW = {"slow": Fault(body=None, pause_s=1.0)}
"""What takes longer than `HURRIED` waits."""


def desk():
    """Three part studios, one of them in a linked document: seven calls."""
    document = Document("Desk")
    wood, steel = document.studio("Wood"), document.studio("Steel")
    bolts = document.library("Bolts").studio("Bolts")
    root = document.assembly("Desk")
    root.add(wood.part("Top", solids.box(1, 0.5, 0.02), density=700), fixed=True)
    root.add(steel.part("Plate", solids.box(0.1, 0.1, 0.005), density=7800))
    root.add(bolts.part("M5", solids.box(0.005, 0.005, 0.02), density=7800))
    return document


CALLS = 7


class Trouble:
    """A fault hook that takes down which calls it left alone. `faults`: by number of the call;
    `stubborn` puts the same one in place of each later call for the same."""

    def __init__(self, faults, *, stubborn=False):
        self.faults, self.stubborn = faults, stubborn
        self.sound = Counter()
        self.lost = Counter()
        self._held = {}

    def __call__(self, method, target, number):
        fault = self.faults.get(number) or self._held.get(target)
        if fault is None:
            self.sound[target] += 1
        elif not fault.silent and 200 <= fault.status < 300:
            self.lost[target] += 1
        if fault is not None and self.stubborn:
            self._held[target] = fault
        return fault


class Fetching:
    """Fetches of one document into one cache, as builds do it. `kind`: as `document_url`."""

    def __init__(self, server, folder, kind="m"):
        self.server, self.folder = server, folder
        self.keys = onshape(server.document_url(kind), max_wait=1)

    def run(self, faults, *, stubborn=False, check_ledger=True):
        """The bundle, or the error, and the fault hook. Checks what holds of every run."""
        server, calls, billed = self.server, Calls(), self.server.count
        before = len(server.calls)
        trouble = Trouble({before + number: fault for number, fault in faults.items()}, stubborn=stubborn)
        server.fault = trouble
        patience = HURRIED if any(fault.pause_s for fault in faults.values()) else QUICK
        replies, ledger = Cache(Store(self.folder)).replies(), self.folder / "ledger"
        try:
            context = FetchContext(replies, server.environ, ledger=ledger, calls=calls, patience=patience)
            outcome = stage.fetch(self.keys, context).bundle
        except SourceError as error:
            outcome = error
        assert calls.made == server.count - billed
        if check_ledger:
            assert sum(year.counted for year in years(ledger)) == server.count
        assert max(trouble.lost.values(), default=0) <= MOST_BILLED
        assert verify(self.folder).broken == ()
        return outcome, trouble


def reference(document, kind="m"):
    """The bundle of a fetch that meets no fault, and its replies."""
    with OnshapeServer(document) as server:
        keys = onshape(server.document_url(kind))
        return fetched(keys, environ=server.environ).bundle
