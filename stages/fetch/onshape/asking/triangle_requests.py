"""Requests the triangles of a part studio: tessellated faces, or glTF if the server refuses them.

Tessellated faces are requested: of all parts, or only of those used where the studio holds many others. Where
they are refused, glTF is requested, and the next build asks for the faces once more. As a file glTF is half
as large as faces with a table of points, but compressed, as both are sent, a third larger; it has single
precision, and does not identify the parts of its bodies (`python -m tests.benchmarks.tessellation` measures
both).
"""

from collections.abc import Iterable, Mapping, Sequence
from types import MappingProxyType

import orjson

from linkwright.stages.fetch.onshape import requests
from linkwright.stages.fetch.onshape.api.http_errors import Declined
from linkwright.stages.fetch.onshape.asking.cached_client import CachedClient, RefusalErrors
from linkwright.stages.fetch.onshape.asking.triangle_refusals import Refusals
from linkwright.stages.fetch.onshape.gather import Needs, Reply, StudioReplies
from linkwright.stages.fetch.onshape.replies.checks import compact_triangles
from linkwright.stages.formats import triangles
from linkwright.stages.robot.errors import ConfigError, Diagnostic, NotFound, ProtocolError, SourceError

NOTHING: Mapping[str, bytes] = MappingProxyType({})
"""The bodies when none are known besides the cached ones."""

_MAX_UNUSED_PARTS = 8
"""Number of unused parts up to which all parts are requested: another robot may use them."""

_NO_MASS = b'{"bodies":{}}'

_NOT_KEPT = (
    "run the same command again (source.refresh=true is not needed: nothing of that reply was kept); "
    "if it fails each time, open the part studio in the browser and check that it regenerates without errors"
)
"""The hint for a reply that was not cached, since it lacks content."""

_MAX_NAMED = 200
"""Largest number of part ids in a request: servers take lines of about 8 kB."""


class Shapes:
    """The requests for triangles of this `quality`. `bodies`: bodies by request, besides the cached ones."""

    def __init__(self, client: CachedClient, quality: requests.Tessellation) -> None:
        self._client = client
        self._quality = quality
        self._reasons: dict[str, str] = {}
        self.refusals = Refusals(client)

    def mass(self, need: Needs) -> str:
        """Returns the request for the mass properties of a part studio, which must cover all solids."""
        request = requests.mass_properties(need.studio, need.root)
        self._client.require(request, lambda body: _require_masses(need, body))
        return request

    def request(self, need: Needs, bodies: Mapping[str, bytes]) -> str:
        """Returns the request for its triangles: a request with a known reply, or else the request to make.

        A reply for all parts has precedence: a reply for some parts may lack a requested part.
        """
        some_parts, all_parts, gltf = self._candidate_requests(need, self._body(self.mass(need), bodies))
        known_requests = (
            candidate
            for candidate in (all_parts, some_parts, gltf)
            if self._body(candidate, bodies) is not None
        )
        return next(known_requests, some_parts)

    def same(self, need: Needs, before: Needs) -> tuple[str, str]:
        """Returns the request for `need`, and the request with a known reply for `before`."""
        mass = self._body(self.mass(before), NOTHING)
        old = self.request(before, NOTHING)
        new = dict(
            zip(self._candidate_requests(before, mass), self._candidate_requests(need, mass), strict=True)
        )[old]
        self.refusals.carry(old, new)
        return new, old

    def fetch_missing(self, needs: Sequence[Needs], bodies: Mapping[str, bytes]) -> dict[str, bytes]:
        """Fetches the replies about triangles that are not in `bodies`, which must have the masses."""
        pending = {request: need for need in needs if (request := self.request(need, bodies)) not in bodies}
        refused: RefusalErrors = {}
        # After a refusal no further call begins: the missing replies are then requested individually.
        fetched = self._client.all(list(pending), refused)
        for need in pending.values():
            request, body = self._fetch_single(need, {**bodies, **fetched}, refused)
            fetched[request] = body
        return fetched

    def doubtful(self, needs: Sequence[Needs], bodies: Mapping[str, bytes]) -> list[Needs]:
        """Returns the part studios whose faces a build that may call asks for again, since they were refused
        once."""
        requests_by_need = [(need, self.request(need, bodies)) for need in needs]
        once_refused = [
            need
            for need, request in requests_by_need
            if requests.is_gltf(request) and self.refusals.is_due(request)
        ]
        return once_refused if once_refused and self._client.may_call else []

    def faces_again(self, needs: Sequence[Needs], bodies: Mapping[str, bytes]) -> dict[str, bytes]:
        """Returns the faces of `doubtful` part studios that are not refused again.

        No failure ends the build, since it has their glTF. Failures other than refusals do not change the
        count.
        """
        requests_by_studio = {
            need.studio: self._candidate_requests(need, bodies[self.mass(need)]) for need in needs
        }
        refused: RefusalErrors = {}
        fetched: dict[str, bytes] = {}
        try:
            fetched |= self._client.all(
                [some_parts for some_parts, _, _ in requests_by_studio.values()], refused
            )
            for studio, (some_parts, all_parts, gltf) in requests_by_studio.items():
                try:
                    request, body = self._first_reply(
                        (some_parts, all_parts), fetched, refused, studio.element
                    )
                    fetched[request] = body
                except (NotFound, Declined):
                    self.refusals.record_second(gltf)
        except (SourceError, ConfigError) as error:
            for studio, (_, _, gltf) in requests_by_studio.items():
                if not self.refusals.is_settled(gltf):
                    self._reasons[studio.element] = f"earlier, and asking again failed: {error.message}"
        return fetched

    def lasts(self, needs: Sequence[Needs], bodies: Mapping[str, bytes]) -> bool:
        """Tells whether a later build asks for no faces again."""
        studio_requests = (self.request(need, bodies) for need in needs)
        return all(
            self.refusals.is_settled(request) for request in studio_requests if requests.is_gltf(request)
        )

    def answer(self, need: Needs, bodies: Mapping[str, bytes]) -> StudioReplies:
        """Returns the replies about a part studio, once they are known."""
        mass, request = self.mass(need), self.request(need, bodies)
        body = self._body(request, bodies)
        assert body is not None
        body = compact_triangles(request, body, bodies[mass])
        return StudioReplies((Reply(mass, bodies[mass]),), Reply(request, body))

    def diagnostics(self, needs: Sequence[Needs], bodies: Mapping[str, bytes]) -> tuple[Diagnostic, ...]:
        """Reports I-TESSELLATION for each part studio whose triangles are from its glTF."""
        requests_by_element = [(need.studio.element, self.request(need, bodies)) for need in needs]
        return tuple(
            Diagnostic(
                "I-TESSELLATION",
                "the triangles are from glTF, which has single precision and no part ids, since "
                f"tessellated faces were refused: {self._reasons.get(element, 'earlier')}",
                f"part studio {element}",
                "to ask for tessellated faces again, build with source.refresh=true"
                if self.refusals.is_settled(request)
                else "the next build asks for tessellated faces once more",
            )
            for element, request in requests_by_element
            if requests.is_gltf(request)
        )

    def _fetch_single(
        self, need: Needs, bodies: Mapping[str, bytes], refused: RefusalErrors
    ) -> tuple[str, bytes]:
        """Returns the first request for triangles that is not refused, and its reply."""
        some_parts, all_parts, gltf = self._candidate_requests(need, bodies[self.mass(need)])
        candidates = (self.request(need, bodies), some_parts, all_parts, gltf)
        request, body = self._first_reply(candidates, bodies, refused, need.studio.element)
        if request == gltf:
            self.refusals.record_first(gltf)
        return request, body

    def _first_reply(
        self, candidates: Iterable[str], bodies: Mapping[str, bytes], refused: RefusalErrors, element: str
    ) -> tuple[str, bytes]:
        """Returns the first request that is not refused, and its reply; raises the first refusal if all
        are."""
        first: NotFound | Declined | None = None
        for request in dict.fromkeys(candidates):
            try:
                if request in refused:
                    raise refused[request]
                body = self._body(request, bodies)
                return request, self._client.reply(request) if body is None else body
            except (NotFound, Declined) as error:
                first = first or error
                self._reasons.setdefault(element, error.message)
        assert first is not None
        raise first

    def _candidate_requests(self, need: Needs, mass: bytes | None) -> tuple[str, str, str]:
        """Returns the requests for triangles: of the needed parts, of all parts, as glTF.

        Each must contain all needed parts. If the faces of all parts lack some, no other request is tried.
        """
        studio, root, part_ids = need.studio, need.root, parts_to_request(need.parts, mass)
        needed_parts = requests.tessellated_faces(studio, root, self._quality, part_ids)
        all_parts = requests.tessellated_faces(studio, root, self._quality)
        gltf = requests.gltf(studio, root, self._quality, part_ids)
        weights = mass or _NO_MASS
        self._client.require(needed_parts, lambda body: _require_complete(need, needed_parts, body, weights))
        self._client.require(gltf, lambda body: _require_complete(need, gltf, body, weights))
        self._client.require(all_parts, lambda body: _require_solids(need, all_parts, body, weights))
        return needed_parts, all_parts, gltf

    def _body(self, request: str, bodies: Mapping[str, bytes]) -> bytes | None:
        return bodies[request] if request in bodies else self._client.lookup(request)


def parts_to_request(parts: Sequence[str], mass: bytes | None) -> tuple[str, ...]:
    """Returns the parts to request if a studio holds many others; empty to request all.

    `mass`: the reply with the mass properties of the studio, if it is known. Parts that it does not list as
    solids are not requested by id: whether a server then gives them is not known.
    """
    if mass is None or len(parts) > _MAX_NAMED:
        return ()
    solids = {name for name, volume in _volumes(mass).items() if volume > 0}
    unneeded = len(solids) - len(parts)
    return tuple(parts) if unneeded > max(len(parts), _MAX_UNUSED_PARTS) and solids.issuperset(parts) else ()


def _require_complete(need: Needs, request: str, body: bytes, mass: bytes) -> None:
    """Raises Declined if triangles that were requested by part, or identified by shape, lack one of the
    parts."""
    try:
        missing_parts = sorted(
            set(need.parts) - triangles.ids_with_triangles(compact_triangles(request, body, mass))
        )
    except ProtocolError as error:
        raise Declined(error.message, error.where, error.hint) from error
    if missing_parts:
        msg = f"the triangles of part studio {need.studio.element} lack the parts {', '.join(missing_parts)}"
        raise Declined(msg, hint="run the same command again; if it fails each time, report it")


def _require_masses(need: Needs, body: bytes) -> None:
    """Raises ProtocolError if a reply with mass properties lacks those of a needed solid."""
    bodies = orjson.loads(body)["bodies"]
    missing_parts = [part for part in need.solids if not bodies.get(part)]
    if missing_parts:
        parts = ", ".join(missing_parts)
        msg = f"the mass properties of part studio {need.studio.element} lack the parts {parts}"
        raise ProtocolError(msg, hint=_NOT_KEPT)


def _require_solids(need: Needs, request: str, body: bytes, mass: bytes) -> None:
    """Raises ProtocolError if the triangles of all parts lack a needed solid that has a volume.

    A solid whose volume is not known, since `mass` lacks it, counts as having a volume.
    """
    volumes, bodies_with_triangles = (
        _volumes(mass),
        triangles.ids_with_triangles(compact_triangles(request, body, mass)),
    )
    missing_parts = [
        part for part in need.solids if volumes.get(part, 1.0) > 0 and part not in bodies_with_triangles
    ]
    if missing_parts:
        msg = f"the triangles of part studio {need.studio.element} lack the parts {', '.join(missing_parts)}"
        raise ProtocolError(msg, hint=_NOT_KEPT)


def _volumes(mass: bytes) -> dict[str, float]:
    """Returns the volume [m³] of each body in a reply with mass properties; empty for any other reply."""
    try:
        bodies = orjson.loads(mass)["bodies"]
        return {name: float(record["volume"][0]) for name, record in bodies.items()}
    except (AttributeError, IndexError, KeyError, TypeError, ValueError):
        return {}
