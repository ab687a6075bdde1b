"""Requests the triangles of a part studio: tessellated faces, or glTF where the server refuses them.

Tessellated faces are asked for: of all parts, or only of those used where the studio holds many
others. Where they are refused, glTF is, and the next build asks for them once more. As files it is half
as large as faces with a table of points, but compressed, as both are sent, a third larger; it has single
precision, and does not show which body is which part (`python -m tests.benchmarks.tessellation` measures
both).
"""

from collections.abc import Iterable, Mapping, Sequence
from types import MappingProxyType

import orjson

from linkwright.stages.fetch.onshape import requests
from linkwright.stages.fetch.onshape.api.http_errors import Declined
from linkwright.stages.fetch.onshape.asking.cached_client import CachedClient, Refused
from linkwright.stages.fetch.onshape.asking.triangle_refusals import Refusals
from linkwright.stages.fetch.onshape.gather import Needs, Reply, StudioReplies
from linkwright.stages.fetch.onshape.replies.checks import compacted
from linkwright.stages.formats import triangles
from linkwright.stages.robot.errors import ConfigError, Diagnostic, NotFound, ProtocolError, SourceError

NOTHING: Mapping[str, bytes] = MappingProxyType({})

_FEW = 8
"""With no more unused parts than this, all parts are requested: another robot may use them."""

_NO_MASS = b'{"bodies":{}}'

_NOT_KEPT = (
    "run the same command again (source.refresh=true is not needed: nothing of that reply was kept); "
    "if it fails each time, open the part studio in the browser and check that it regenerates without errors"
)

_MOST_NAMED = 200
"""Part ids in one request at most: servers take lines of about 8 kB."""


class Shapes:
    """Requests triangles of this `quality`. `known`: bodies by request, besides the cached ones."""

    def __init__(self, client: CachedClient, quality: requests.Tessellation) -> None:
        self._client = client
        self._quality = quality
        self._reasons: dict[str, str] = {}
        self.refusals = Refusals(client)

    def mass(self, need: Needs) -> str:
        """The request for the mass properties of a part studio, which must cover all solids."""
        request = requests.mass_properties(need.studio, need.root)
        self._client.require(request, lambda body: _require_masses(need, body))
        return request

    def request(self, need: Needs, known: Mapping[str, bytes]) -> str:
        """The request for its triangles: one with a known reply, else the one to make.

        A reply for all parts has precedence: a reply for some parts may lack a requested part.
        """
        some, whole, gltf = self._ways(need, self._body(self.mass(need), known))
        there = (way for way in (whole, some, gltf) if self._body(way, known) is not None)
        return next(there, some)

    def same(self, need: Needs, before: Needs) -> tuple[str, str]:
        """The request for `need`, and the request with a known reply for `before`."""
        mass = self._body(self.mass(before), NOTHING)
        old = self.request(before, NOTHING)
        new = dict(zip(self._ways(before, mass), self._ways(need, mass), strict=True))[old]
        self.refusals.carry(old, new)
        return new, old

    def gathered(self, needs: Sequence[Needs], known: Mapping[str, bytes]) -> dict[str, bytes]:
        """Fetches the replies about triangles that are not `known`; the masses must be known."""
        wanted = {request: need for need in needs if (request := self.request(need, known)) not in known}
        refused: Refused = {}
        # After a refusal no further call begins: what lacks then is asked for one by one.
        found = self._client.all(list(wanted), refused)
        for need in wanted.values():
            request, body = self._one(need, {**known, **found}, refused)
            found[request] = body
        return found

    def doubtful(self, needs: Sequence[Needs], known: Mapping[str, bytes]) -> list[Needs]:
        """The part studios whose faces a build that may call asks for again, since they were refused once."""
        ways = [(need, self.request(need, known)) for need in needs]
        found = [need for need, way in ways if requests.is_gltf(way) and self.refusals.due(way)]
        return found if found and self._client.may_call else []

    def asked_again(self, needs: Sequence[Needs], known: Mapping[str, bytes]) -> dict[str, bytes]:
        """The faces of `doubtful` part studios that are not refused again.

        No failure ends the build, since it has their glTF. One that is no refusal leaves the count as it is.
        """
        ways = {need.studio: self._ways(need, known[self.mass(need)]) for need in needs}
        refused: Refused = {}
        found: dict[str, bytes] = {}
        try:
            found |= self._client.all([some for some, _, _ in ways.values()], refused)
            for studio, (some, whole, gltf) in ways.items():
                try:
                    request, body = self._first((some, whole), found, refused, studio.element)
                    found[request] = body
                except (NotFound, Declined):
                    self.refusals.second(gltf)
        except (SourceError, ConfigError) as error:
            for studio, (_, _, gltf) in ways.items():
                if not self.refusals.settled(gltf):
                    self._reasons[studio.element] = f"earlier, and asking again failed: {error.message}"
        return found

    def lasts(self, needs: Sequence[Needs], known: Mapping[str, bytes]) -> bool:
        """Whether a later build asks for no faces again."""
        ways = (self.request(need, known) for need in needs)
        return all(self.refusals.settled(way) for way in ways if requests.is_gltf(way))

    def answer(self, need: Needs, known: Mapping[str, bytes]) -> StudioReplies:
        """The replies about a part studio, once they are known."""
        mass, request = self.mass(need), self.request(need, known)
        body = self._body(request, known)
        assert body is not None
        body = compacted(request, body, known[mass])
        return StudioReplies((Reply(mass, known[mass]),), Reply(request, body))

    def diagnostics(self, needs: Sequence[Needs], known: Mapping[str, bytes]) -> tuple[Diagnostic, ...]:
        """I-TESSELLATION for each part studio whose triangles are from its glTF."""
        found = [(need.studio.element, self.request(need, known)) for need in needs]
        return tuple(
            Diagnostic(
                "I-TESSELLATION",
                "the triangles are from glTF, which has single precision and no part ids, since "
                f"tessellated faces were refused: {self._reasons.get(element, 'earlier')}",
                f"part studio {element}",
                "to ask for tessellated faces again, build with source.refresh=true"
                if self.refusals.settled(way)
                else "the next build asks for tessellated faces once more",
            )
            for element, way in found
            if requests.is_gltf(way)
        )

    def _one(self, need: Needs, known: Mapping[str, bytes], refused: Refused) -> tuple[str, bytes]:
        """The first request for triangles that is not refused, and its reply."""
        some, whole, gltf = self._ways(need, known[self.mass(need)])
        ways = (self.request(need, known), some, whole, gltf)
        request, body = self._first(ways, known, refused, need.studio.element)
        if request == gltf:
            self.refusals.first(gltf)
        return request, body

    def _first(
        self, ways: Iterable[str], known: Mapping[str, bytes], refused: Refused, element: str
    ) -> tuple[str, bytes]:
        """The first request that is not refused, and its reply; raises the first refusal if all are."""
        first: NotFound | Declined | None = None
        for request in dict.fromkeys(ways):
            try:
                if request in refused:
                    raise refused[request]
                body = self._body(request, known)
                return request, self._client.one(request) if body is None else body
            except (NotFound, Declined) as error:
                first = first or error
                self._reasons.setdefault(element, error.message)
        assert first is not None
        raise first

    def _ways(self, need: Needs, mass: bytes | None) -> tuple[str, str, str]:
        """The requests for triangles: of what is needed, of all parts, as glTF.

        Each must contain all needed parts. Where the faces of all parts lack some, no other request is tried.
        """
        studio, root, only = need.studio, need.root, selected(need.parts, mass)
        some = requests.tessellated_faces(studio, root, self._quality, only)
        whole = requests.tessellated_faces(studio, root, self._quality)
        gltf = requests.gltf(studio, root, self._quality, only)
        known = mass or _NO_MASS
        self._client.require(some, lambda body: _require_complete(need, some, body, known))
        self._client.require(gltf, lambda body: _require_complete(need, gltf, body, known))
        self._client.require(whole, lambda body: _require_solids(need, whole, body, known))
        return some, whole, gltf

    def _body(self, request: str, known: Mapping[str, bytes]) -> bytes | None:
        return known[request] if request in known else self._client.kept(request)


def selected(parts: Sequence[str], mass: bytes | None) -> tuple[str, ...]:
    """The parts to ask for where a studio holds many others; none where all are asked for.

    `mass`: the reply with the mass properties of the studio, if it is known. Parts that it does not
    list as solids are not asked for by id: whether a server then gives them is not known.
    """
    if mass is None or len(parts) > _MOST_NAMED:
        return ()
    solids = {name for name, volume in _volumes(mass).items() if volume > 0}
    others = len(solids) - len(parts)
    return tuple(parts) if others > max(len(parts), _FEW) and solids.issuperset(parts) else ()


def _require_complete(need: Needs, request: str, body: bytes, mass: bytes) -> None:
    """Declined where triangles that were asked for by part, or identified by shape, lack one of the parts."""
    try:
        lacking = sorted(set(need.parts) - triangles.names(compacted(request, body, mass)))
    except ProtocolError as error:
        raise Declined(error.message, error.where, error.hint) from error
    if lacking:
        msg = f"the triangles of part studio {need.studio.element} lack the parts {', '.join(lacking)}"
        raise Declined(msg, hint="run the same command again; if it fails each time, report it")


def _require_masses(need: Needs, body: bytes) -> None:
    """ProtocolError where a reply with mass properties lacks those of a needed solid."""
    bodies = orjson.loads(body)["bodies"]
    lacking = [part for part in need.solids if not bodies.get(part)]
    if lacking:
        msg = f"the mass properties of part studio {need.studio.element} lack the parts {', '.join(lacking)}"
        raise ProtocolError(msg, hint=_NOT_KEPT)


def _require_solids(need: Needs, request: str, body: bytes, mass: bytes) -> None:
    """ProtocolError where the triangles of all parts lack a needed solid that has a volume.

    A solid whose volume is not known, since `mass` lacks it, counts as having one.
    """
    volumes, there = _volumes(mass), triangles.names(compacted(request, body, mass))
    lacking = [part for part in need.solids if volumes.get(part, 1.0) > 0 and part not in there]
    if lacking:
        msg = f"the triangles of part studio {need.studio.element} lack the parts {', '.join(lacking)}"
        raise ProtocolError(msg, hint=_NOT_KEPT)


def _volumes(mass: bytes) -> dict[str, float]:
    """The volume [m³] of each body in a reply with mass properties; nothing where it has none."""
    try:
        bodies = orjson.loads(mass)["bodies"]
        return {name: float(record["volume"][0]) for name, record in bodies.items()}
    except (AttributeError, IndexError, KeyError, TypeError, ValueError):
        return {}
