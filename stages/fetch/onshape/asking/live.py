"""Replies from an Onshape server, in as few calls as the changes to the assembly allow."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from linkwright.stages.fetch.onshape import requests
from linkwright.stages.fetch.onshape.asking.cached_client import CachedClient
from linkwright.stages.fetch.onshape.asking.freshness import Workspace, tabs_to_ask, unchanged
from linkwright.stages.fetch.onshape.asking.limits import limits_of
from linkwright.stages.fetch.onshape.asking.triangle_requests import NOTHING, Shapes
from linkwright.stages.fetch.onshape.configured import Configured
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
    """Replies about the assembly at `url`; `keys`: the configuration of the source.

    Pinned replies are cached for ever. After a change of the workspace, replies about part studios that
    did not change are taken from the microversion of the last build, and stored under the new one once
    the mass of the assembly confirms them.
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
        self._then: str | None = None
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
            self._then = self._workspace.last()
            self._ask("asking whether the document changed" if self._then else _ASKING)
            self._pin = f"m/{self._workspace.current(force=self._keys.refresh)}"
        url = self._url
        request = requests.definition(url.document, self._pin, url.element, url.configuration)
        if self._client.kept(request) is None:
            self._ask(_ASKING)
        self._definition = Reply(request, self._client.one(request))
        return self._definition

    def _configure(self) -> None:
        """Sets the address to the wanted configuration, and its microversion."""
        configured = Configured(self._url, self._keys.configuration, self._client)
        if self._workspace is None:
            self._url = configured.at(self._pin)
            return
        self._ask("asking how the assembly can be configured, and whether it changed")
        self._url, self._then, microversion = configured.now(force=self._keys.refresh)
        self._pin = f"m/{microversion}"
        self._workspace = Workspace(self._url, self._client)

    def _ask(self, what: str) -> None:
        """Tells what the server is asked, where it is."""
        if not self._client.offline:
            self._progress(what)

    def title(self) -> str:
        """The name of the assembly's tab from any cached reply, else ""; makes no call."""
        url, client = self._url, self._client
        subject = f"/documents/d/{url.document}/e/{url.element}#name"
        known = str(client.recall(subject).get("name", ""))
        kept = client.kept(requests.elements(url.document, self._pin[2:]))
        name = documents.tab_name(kept, url.element) if kept is not None else known
        if name != known:
            client.remember(subject, {"name": name})
        return name

    def features(self, owners: Sequence[Owner], root: str) -> Sequence[LimitReplies]:
        if owners:
            self._ask(f"{count(len(owners), 'list')} of features for limits that the definition lacks")
            self._keep_lists(owners)
        return limits_of(owners, root, self._url, self._client)

    def studios(self, needs: Sequence[Needs]) -> Sequence[StudioReplies]:
        client = self._client
        known = [request for need in needs for request in self._requests(need)]
        kept = {request: body for request in known if (body := client.kept(request)) is not None}
        reused = self._reused(needs, kept)
        wanted = [request for need in needs for request in self._requests(need, {**kept, **reused})]
        missing = [request for request in wanted if request not in kept and request not in reused]
        suspects = {*reused, *self._unchecked(wanted)}
        calls = len(missing) + self._to_weigh(suspects)
        again = self._shapes.doubtful(needs, {**kept, **reused})
        again = again if client.affords(calls + len(again)) else []
        calls += len(again)
        cached = len(kept) + len(reused)
        self._progress(f"{count(len(needs), 'part studio')}: {count(calls, 'call')}, {cached} kept")
        client.spare(cached)
        if missing and not client.offline:
            client.allow(calls)
        weights = set(wanted[::2])
        bodies = {**kept, **reused, **client.all([request for request in missing if request in weights])}
        # After the masses, which show how much of a part studio the assembly uses.
        bodies |= self._shapes.gathered(needs, bodies)
        fresh, checked = self._verified(needs, bodies, suspects)
        # Before they are stored: a kill between the two must not make them look checked.
        self._check_later(() if checked else suspects)
        for request in reused.keys() - fresh.keys():
            client.keep(request, reused[request])
        self._shapes.refusals.keep(reused, fresh)
        if self._workspace is not None and not client.offline:
            self._workspace.completed(self._pin[2:])
        bodies |= fresh
        bodies |= self._shapes.asked_again(again, bodies)
        self.lasts = self._shapes.lasts(needs, bodies)
        self.diagnostics += self._shapes.diagnostics(needs, bodies)
        return [self._shapes.answer(need, bodies) for need in needs]

    def _lists(self, owners: Sequence[Owner]) -> dict[str, tuple[str, bytes]]:
        """Feature lists that are not cached, from the microversion `then`: request → element and body."""
        found = {}
        for owner in owners:
            if (owner.key.document, owner.key.pin) != (self._url.document, self._pin):
                continue
            new, old = (
                requests.features(replace(owner.key, pin=pin), self._url.document)
                for pin in (self._pin, f"m/{self._then}")
            )
            body = self._client.kept(old) if self._client.kept(new) is None else None
            if body is not None:
                found[new] = owner.key.element, body
        return found

    def _keep_lists(self, owners: Sequence[Owner]) -> None:
        """Keeps the feature lists of assemblies that did not change since `then`, where that saves calls."""
        if self._then is None or self._then == self._pin[2:]:
            return
        found = self._lists(owners)
        if len(found) <= len(self._tabs_to_ask()):
            return
        same = unchanged(tabs_to_ask(self._url, self._then, self._pin[2:], self._client), self._client)
        for request, (element, body) in found.items():
            if element in same:
                self._client.keep(request, body)
                self._client.spare(1)

    def _tabs_to_ask(self) -> list[str]:
        """The requests that show which tabs changed since `then`, without those that are cached."""
        assert self._then is not None
        asked = tabs_to_ask(self._url, self._then, self._pin[2:], self._client)
        return [request for request in asked if self._client.kept(request) is None]

    def _requests(self, need: Needs, known: Mapping[str, bytes] = NOTHING) -> tuple[str, str]:
        """The requests for the mass properties and for the triangles of a part studio.

        `known`: bodies besides the cached ones; they decide which triangles are requested.
        """
        return self._shapes.mass(need), self._shapes.request(need, known)

    def _reused(self, needs: Sequence[Needs], kept: Mapping[str, bytes]) -> _Bodies:
        """Replies that are not cached, taken from the microversion `then` where their tab did not change.

        Empty where finding the unchanged tabs would cost as many calls as fetching everything again.
        """
        then, now = self._then, self._pin[2:]
        if then is None or then == now:
            return {}
        found = [(need.studio.element, self._earlier(need, kept, then)) for need in needs]
        spared = sum(len(bodies) for _, bodies in found)
        assert self._definition is not None
        # The requests that show which tabs changed serve the feature lists too.
        lists = len(self._lists(features.owners(self._definition.body))) if spared else 0
        if spared + lists <= len(self._tabs_to_ask()) + self._to_weigh(["any"]):
            return {}
        same = unchanged(tabs_to_ask(self._url, then, now, self._client), self._client)
        return {
            request: body for element, bodies in found if element in same for request, body in bodies.items()
        }

    def _earlier(self, need: Needs, kept: Mapping[str, bytes], then: str) -> _Bodies:
        """Replies that a part studio of this document lacks, from the microversion `then`."""
        studio = need.studio
        if (studio.document, studio.pin) != (self._url.document, self._pin):
            return {}
        before = replace(need, studio=replace(studio, pin=f"m/{then}"))
        pairs = [(self._shapes.mass(need), self._shapes.mass(before)), self._shapes.same(need, before)]
        bodies = {new: body for new, old in pairs if (body := self._client.kept(old)) is not None}
        mass = pairs[0][0]
        # Where the masses differ, the studio changed: its old triangles are wrong too.
        if mass not in bodies or kept.get(mass, bodies[mass]) != bodies[mass]:
            return {}
        return {request: body for request, body in bodies.items() if request not in kept}

    def _verified(self, needs: Sequence[Needs], bodies: _Bodies, suspects: set[str]) -> tuple[_Bodies, bool]:
        """The replies of `suspects`, fetched again, where the assembly's mass shows that one is stale.

        Also whether `suspects` need no further check; they do where that mass is not available.
        """
        client = self._client
        total = client.kept(self._total())
        if total is None and self._to_weigh(suspects) == 0:
            return {}, self._keys.verify
        if total is None:
            self._progress("comparing the mass of the assembly with the sum of its parts")
            try:
                total = client.one(self._total())
            except (NotFound, ProtocolError) as error:
                self.diagnostics += (mass_check.unchecked(self._url.element, error),)
                return {}, False
        fresh: _Bodies = {}
        masses = self._masses(needs, bodies, total)
        lasting = not masses.agree and self._differed(needs, masses)
        if not masses.agree and not lasting and suspects and not client.offline:
            again = sorted(suspects)
            self._progress(
                f"a part studio changed through one that it depends on:  {count(len(again), 'call')}"
            )
            client.doubt(again)
            fresh = client.all(again)
            masses = self._masses(needs, {**bodies, **fresh}, total)
            if self._workspace is not None:
                excess = {"excess": list(masses.excess), "studios": _tabs(needs)}
                self._workspace.differs({} if masses.agree else excess)
        if not masses.agree:
            self.diagnostics += (masses.diagnostic(self._url.element, lasting=lasting),)
        return fresh, self._keys.verify

    def _differed(self, needs: Sequence[Needs], masses: mass_check.Masses) -> bool:
        """Whether the masses differed by the same amount after all these part studios were fetched again."""
        known = self._workspace.discrepancy() if self._workspace is not None else {}
        if not known or not set(_tabs(needs)) <= set(known["studios"]):
            return False
        return masses.as_before(known["excess"])

    def _masses(self, needs: Sequence[Needs], bodies: Mapping[str, bytes], total: bytes) -> mass_check.Masses:
        weights = {need.studio: mass_check.read_weights(bodies[self._requests(need)[0]]) for need in needs}
        assert self._definition is not None
        return mass_check.compare(self._definition.body, weights, total)

    def _to_weigh(self, suspects: Iterable[str]) -> int:
        """Calls for the assembly's mass: one where replies are in doubt and it is not kept."""
        wanted = self._keys.verify and not self._client.offline
        return int(wanted and any(suspects) and self._client.kept(self._total()) is None)

    def _total(self) -> str:
        url = self._url
        return requests.assembly_mass_properties(url.document, self._pin, url.element, url.configuration)

    def _unchecked(self, wanted: Iterable[str]) -> set[str]:
        """Kept replies that were taken from an earlier microversion without a check."""
        if self._workspace is None or self._client.offline:
            return set()
        found = self._client.recall(self._total()).get("unchecked", ())
        return set(wanted).intersection(found)

    def _check_later(self, unchecked: Iterable[str]) -> None:
        if self._workspace is None or self._client.offline:
            return
        listed = sorted(unchecked)
        if listed != self._client.recall(self._total()).get("unchecked", []):
            self._client.remember(self._total(), {"unchecked": listed})


def _tabs(needs: Sequence[Needs]) -> list[str]:
    """The part studios, without the microversions of their documents."""
    return sorted({f"{n.studio.document}/{n.studio.element}/{n.studio.configuration}" for n in needs})


_ASKING = "asking for the assembly definition"
