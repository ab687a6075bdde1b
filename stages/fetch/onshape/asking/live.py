"""Gets replies from an Onshape server, in as few calls as the changes to the assembly allow."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from linkwright.stages.fetch.onshape import requests
from linkwright.stages.fetch.onshape.asking.cached_client import CachedClient
from linkwright.stages.fetch.onshape.asking.freshness import Workspace, tabs_to_ask, unchanged_tabs
from linkwright.stages.fetch.onshape.asking.limits import limits_of
from linkwright.stages.fetch.onshape.asking.triangle_requests import NOTHING, Shapes
from linkwright.stages.fetch.onshape.configured import ConfiguredAddress
from linkwright.stages.fetch.onshape.gather import LimitReplies, Needs, Reply, StudioReplies
from linkwright.stages.fetch.onshape.replies import documents, features, mass_check
from linkwright.stages.fetch.onshape.replies.features import Owner
from linkwright.stages.fetch.onshape.url import AssemblyUrl
from linkwright.stages.robot.errors import Diagnostic, NotFound, ProtocolError
from linkwright.stages.robot.text.plural import count

if TYPE_CHECKING:
    from linkwright.stages.fetch.onshape.section import OnshapeSourceSection

_Bodies = dict[str, bytes]


class LiveAnswers:
    """The replies of a server about the assembly at `url`; `keys`: the configuration of the source.

    Pinned replies are cached for ever. After a change of the workspace, replies about part studios that did
    not change are taken from the microversion of the last build, and stored under the new one once the mass
    of the assembly confirms them.
    """

    def __init__(
        self,
        url: AssemblyUrl,
        keys: "OnshapeSourceSection",
        client: CachedClient,
        progress: Callable[[str], None],
    ) -> None:
        self._url = url
        self._keys = keys
        self._client = client
        self._progress = progress
        self._shapes = Shapes(client, keys.tessellation)
        self._workspace = None if url.pinned else Workspace(url, client)
        self._last_built: str | None = None
        self._pin = url.pin
        self._definition: Reply | None = None
        self.lasts = True
        """Whether a later build of the same microversion uses the same replies."""
        self.diagnostics: tuple[Diagnostic, ...] = ()
        """Diagnostics about the replies."""

    def versions(self) -> tuple[str, str]:
        assert self._definition is not None
        return self._client.api(self._definition.request), requests.API

    def configuration(self) -> str:
        return self._url.configuration

    def definition(self) -> Reply:
        if self._keys.configuration:
            self._configure()
        elif self._workspace is not None:
            self._last_built = self._workspace.last_microversion()
            self._ask("asking whether the document changed" if self._last_built else _ASKING)
            self._pin = f"m/{self._workspace.current(force=self._keys.refresh)}"
        url = self._url
        request = requests.definition(url.document, self._pin, url.element, url.configuration)
        if self._client.lookup(request) is None:
            self._ask(_ASKING)
        self._definition = Reply(request, self._client.reply(request))
        return self._definition

    def _configure(self) -> None:
        """Sets the address to the user's configuration, and its microversion."""
        configured = ConfiguredAddress(self._url, self._keys.configuration, self._client)
        if self._workspace is None:
            self._url = configured.address_at(self._pin)
            return
        self._ask("asking how the assembly can be configured, and whether it changed")
        self._url, self._last_built, microversion = configured.current(force=self._keys.refresh)
        self._pin = f"m/{microversion}"
        self._workspace = Workspace(self._url, self._client)

    def _ask(self, line: str) -> None:
        """Reports a question to the server, unless offline."""
        if not self._client.offline:
            self._progress(line)

    def title(self) -> str:
        """Returns the name of the assembly's tab from any cached reply, or else ""; makes no call."""
        url, client = self._url, self._client
        subject = f"/documents/d/{url.document}/e/{url.element}#name"
        remembered = str(client.recall(subject).get("name", ""))
        kept = client.lookup(requests.elements(url.document, self._pin[2:]))
        name = documents.tab_name(kept, url.element) if kept is not None else remembered
        if name != remembered:
            client.remember(subject, {"name": name})
        return name

    def ahead(self, needs: Sequence[Needs]) -> tuple[str, dict[str, tuple[str, ...]], bool]:
        """Returns the pin, the requests of `studios`, and whether it makes no other requests."""
        pairs = [(request, need) for need in needs for request in self._requests(need)]
        kept = {request: body for request, _ in pairs if (body := self._client.lookup(request)) is not None}
        tabs = self._reusable(needs, kept)
        reused = {request: body for _, bodies in tabs for request, body in bodies.items()}
        pending = {request: need.parts for request, need in pairs if request not in kept | reused}
        suspects = {*reused, *self._unchecked(request for request, _ in pairs)}
        check_requests = [*(self._tabs_to_ask() if tabs else ()), *[self._total()] * self._to_weigh(suspects)]
        exact = not tabs and not self._shapes.doubtful(needs, {**kept, **reused})
        return self._pin, pending | dict.fromkeys(check_requests, ()), exact

    def features(self, owners: Sequence[Owner], root: str) -> Sequence[LimitReplies]:
        if owners:
            self._ask(f"{count(len(owners), 'list')} of features for limits that the definition lacks")
            self._keep_lists(owners)
        return limits_of(owners, root, self._url, self._client)

    def studios(self, needs: Sequence[Needs]) -> Sequence[StudioReplies]:
        client = self._client
        all_requests = [request for need in needs for request in self._requests(need)]
        kept = {request: body for request in all_requests if (body := client.lookup(request)) is not None}
        reused = self._reused(needs, kept)
        studio_requests = [request for need in needs for request in self._requests(need, {**kept, **reused})]
        missing = [request for request in studio_requests if request not in kept and request not in reused]
        suspects = {*reused, *self._unchecked(studio_requests)}
        calls = len(missing) + self._to_weigh(suspects)
        doubtful = self._shapes.doubtful(needs, {**kept, **reused})
        doubtful = doubtful if client.affords(calls + len(doubtful)) else []
        calls += len(doubtful)
        cached = len(kept) + len(reused)
        self._progress(f"{count(len(needs), 'part studio')}: {count(calls, 'call')}, {cached} kept")
        client.count_saved(cached)
        if missing and not client.offline:
            client.allow(calls)
        weights = set(studio_requests[::2])
        bodies = {**kept, **reused, **client.all([request for request in missing if request in weights])}
        # After the masses, which show how much of a part studio the assembly uses.
        bodies |= self._shapes.fetch_missing(needs, bodies)
        refetched, checked = self._verified(needs, bodies, suspects)
        # This is recorded before they are stored: a kill in between must not make them look checked.
        self._check_later(() if checked else suspects)
        for request in reused.keys() - refetched.keys():
            client.keep(request, reused[request])
        self._shapes.refusals.keep(reused, refetched)
        if self._workspace is not None and not client.offline:
            self._workspace.record_complete(self._pin[2:])
        bodies |= refetched
        bodies |= self._shapes.faces_again(doubtful, bodies)
        self.lasts = self._shapes.lasts(needs, bodies)
        self.diagnostics += self._shapes.diagnostics(needs, bodies)
        return [self._shapes.answer(need, bodies) for need in needs]

    def _lists(self, owners: Sequence[Owner]) -> dict[str, tuple[str, bytes]]:
        """Returns uncached feature lists, from the microversion `then`: request → element and body."""
        lists = {}
        for owner in owners:
            if (owner.key.document, owner.key.pin) != (self._url.document, self._pin):
                continue
            new, old = (
                requests.features(replace(owner.key, pin=pin), self._url.document)
                for pin in (self._pin, f"m/{self._last_built}")
            )
            body = self._client.lookup(old) if self._client.lookup(new) is None else None
            if body is not None:
                lists[new] = owner.key.element, body
        return lists

    def _keep_lists(self, owners: Sequence[Owner]) -> None:
        """Caches the feature lists of assemblies unchanged since `then`, if that saves calls."""
        if self._last_built is None or self._last_built == self._pin[2:]:
            return
        lists = self._lists(owners)
        if len(lists) <= len(self._tabs_to_ask()):
            return
        same_tabs = unchanged_tabs(
            tabs_to_ask(self._url, self._last_built, self._pin[2:], self._client), self._client
        )
        for request, (element, body) in lists.items():
            if element in same_tabs:
                self._client.keep(request, body)
                self._client.count_saved(1)

    def _tabs_to_ask(self) -> list[str]:
        """Returns the uncached requests that show the tabs that changed since `then`."""
        assert self._last_built is not None
        pair = tabs_to_ask(self._url, self._last_built, self._pin[2:], self._client)
        return [request for request in pair if self._client.lookup(request) is None]

    def _requests(self, need: Needs, bodies: Mapping[str, bytes] = NOTHING) -> tuple[str, str]:
        """Returns the requests for the masses and the triangles of a part studio.

        `bodies`: bodies besides the cached ones; they decide which triangles are requested.
        """
        return self._shapes.mass(need), self._shapes.request(need, bodies)

    def _reused(self, needs: Sequence[Needs], kept: Mapping[str, bytes]) -> _Bodies:
        """Returns uncached replies, taken from the microversion `then` if their tab did not change.

        Empty if finding the unchanged tabs would cost as many calls as fetching everything again.
        """
        tabs = self._reusable(needs, kept)
        if not tabs:
            return {}
        pair = tabs_to_ask(self._url, str(self._last_built), self._pin[2:], self._client)
        same = unchanged_tabs(pair, self._client)
        return {
            request: body for element, bodies in tabs if element in same for request, body in bodies.items()
        }

    def _reusable(self, needs: Sequence[Needs], kept: Mapping[str, bytes]) -> list[tuple[str, _Bodies]]:
        """Returns the replies that `_reused` takes if nothing changed, with the tab of each."""
        then = self._last_built
        if then is None or then == self._pin[2:]:
            return []
        earlier = [(need.studio.element, self._earlier(need, kept, then)) for need in needs]
        spared = sum(len(bodies) for _, bodies in earlier)
        assert self._definition is not None
        # The requests that show the changed tabs serve the feature lists too.
        lists = len(self._lists(features.owners(self._definition.body))) if spared else 0
        costs_too_much = spared + lists <= len(self._tabs_to_ask()) + self._to_weigh(["any"])
        return [] if costs_too_much else earlier

    def _earlier(self, need: Needs, kept: Mapping[str, bytes], then: str) -> _Bodies:
        """Returns replies that a part studio of this document lacks, from the microversion `then`."""
        studio = need.studio
        if (studio.document, studio.pin) != (self._url.document, self._pin):
            return {}
        old_need = replace(need, studio=replace(studio, pin=f"m/{then}"))
        pairs = [(self._shapes.mass(need), self._shapes.mass(old_need)), self._shapes.same(need, old_need)]
        bodies = {new: body for new, old in pairs if (body := self._client.lookup(old)) is not None}
        mass = pairs[0][0]
        # Where the masses differ, the studio changed: its old triangles are wrong too.
        if mass not in bodies or kept.get(mass, bodies[mass]) != bodies[mass]:
            return {}
        return {request: body for request, body in bodies.items() if request not in kept}

    def _verified(self, needs: Sequence[Needs], bodies: _Bodies, suspects: set[str]) -> tuple[_Bodies, bool]:
        """Returns the replies of `suspects`, fetched again if the assembly's mass shows a stale reply.

        The second value: whether `suspects` need no further check. They do if that mass is not available.
        """
        client = self._client
        total = client.lookup(self._total())
        if total is None and self._to_weigh(suspects) == 0:
            return {}, self._keys.verify
        if total is None:
            self._progress("comparing the mass of the assembly with the sum of its parts")
            try:
                total = client.reply(self._total())
            except (NotFound, ProtocolError) as error:
                self.diagnostics += (mass_check.unchecked(self._url.element, error),)
                return {}, False
        refetched: _Bodies = {}
        masses = self._masses(needs, bodies, total)
        differed_before = not masses.agree and self._differed_before(needs, masses)
        if not masses.agree and not differed_before and suspects and not client.offline:
            suspect_requests = sorted(suspects)
            calls = count(len(suspect_requests), "call")
            self._progress(f"a part studio changed through one that it depends on:  {calls}")
            client.refetch(suspect_requests)
            refetched = client.all(suspect_requests)
            masses = self._masses(needs, {**bodies, **refetched}, total)
            if self._workspace is not None:
                excess = {"excess": list(masses.excess), "studios": _tabs(needs)}
                self._workspace.record_discrepancy({} if masses.agree else excess)
        if not masses.agree:
            self.diagnostics += (masses.diagnostic(self._url.element, lasting=differed_before),)
        return refetched, self._keys.verify

    def _differed_before(self, needs: Sequence[Needs], masses: mass_check.Masses) -> bool:
        """Tells whether the masses differed equally after all these part studios were fetched again."""
        recorded = self._workspace.discrepancy() if self._workspace is not None else {}
        if not recorded or not set(_tabs(needs)) <= set(recorded["studios"]):
            return False
        return masses.differs_as_before(recorded["excess"])

    def _masses(self, needs: Sequence[Needs], bodies: Mapping[str, bytes], total: bytes) -> mass_check.Masses:
        weights = {need.studio: mass_check.read_weights(bodies[self._requests(need)[0]]) for need in needs}
        assert self._definition is not None
        return mass_check.compare(self._definition.body, weights, total)

    def _to_weigh(self, suspects: Iterable[str]) -> int:
        """Returns the number of calls for the assembly's mass: 1 if it is needed and not cached."""
        checks = self._keys.verify and not self._client.offline
        return int(checks and any(suspects) and self._client.lookup(self._total()) is None)

    def _total(self) -> str:
        url = self._url
        return requests.assembly_mass_properties(url.document, self._pin, url.element, url.configuration)

    def _unchecked(self, needed: Iterable[str]) -> set[str]:
        """Returns cached replies taken from an earlier microversion without a check."""
        if self._workspace is None or self._client.offline:
            return set()
        unchecked = self._client.recall(self._total()).get("unchecked", ())
        return set(needed).intersection(unchecked)

    def _check_later(self, unchecked: Iterable[str]) -> None:
        if self._workspace is None or self._client.offline:
            return
        request_list = sorted(unchecked)
        if request_list != self._client.recall(self._total()).get("unchecked", []):
            self._client.remember(self._total(), {"unchecked": request_list})


def _tabs(needs: Sequence[Needs]) -> list[str]:
    """Returns the part studios, without the microversions of their documents."""
    return sorted({f"{n.studio.document}/{n.studio.element}/{n.studio.configuration}" for n in needs})


_ASKING = "asking for the assembly definition"
