"""Gets replies from a recording: a bundle or the sample."""

from collections.abc import Sequence

import orjson

from linkwright.stages.fetch.onshape import definition, requests
from linkwright.stages.fetch.onshape.gather import LimitReplies, Needs, Reply, StudioReplies
from linkwright.stages.fetch.onshape.replies.checks import cached_form, compact_triangles
from linkwright.stages.fetch.onshape.replies.features import Owner
from linkwright.stages.fetch.recording import Recording
from linkwright.stages.robot.errors import ProtocolError, SourceError


class RecordedAnswers:
    """The replies of a recording. `where` names it in messages."""

    def __init__(self, recording: Recording, where: str) -> None:
        self._recording = recording
        self._where = where
        self._by_subject: dict[object, str] = {}
        for request in sorted(recording.requests):
            self._by_subject.setdefault(requests.subject(request), request)

    def configuration(self) -> str:
        return self._recording.root["configuration"]

    def versions(self) -> tuple[str, str]:
        return self._recording.definition_api, self._recording.api

    def definition(self) -> Reply:
        recording, root = self._recording, self._recording.root
        body = recording.blobs[recording.definition]
        try:
            recorded = definition.read(body)
        except ProtocolError as error:
            raise ProtocolError(error.message, self._where, "make the bundle again") from error
        names_in_manifest = (root["document"], root["microversion"], root["element"])
        if (recorded.document, recorded.microversion, recorded.element) != names_in_manifest:
            msg = f"the manifest names assembly {root['element']}, but the definition is of another assembly"
            raise SourceError(msg, self._where, "make the bundle again")
        pinned = requests.definition(
            root["document"], f"m/{root['microversion']}", root["element"], root["configuration"]
        )
        recorded_requests = [
            request for request, name in recording.requests.items() if name == recording.definition
        ]
        return Reply(min(recorded_requests, default=pinned), body)

    def studios(self, needs: Sequence[Needs]) -> Sequence[StudioReplies]:
        masses = [self._mass(need) for need in needs]
        return [
            StudioReplies(mass, self._triangles(need, mass)) for need, mass in zip(needs, masses, strict=True)
        ]

    def features(self, owners: Sequence[Owner], root: str) -> Sequence[LimitReplies]:
        pairs = [(requests.features(o.key, root), requests.variables(o.key, root)) for o in owners]
        return [LimitReplies(self._find(features), self._find(variables)) for features, variables in pairs]

    def _mass(self, need: Needs) -> tuple[Reply, ...]:
        """Returns a reply for the whole studio, or else a reply for each part used. Raises SourceError if any
        is missing."""
        studio_reply = self._find(requests.mass_properties(need.studio, need.root))
        if studio_reply is not None:
            return (studio_reply,)
        part_replies = {
            part: self._find(requests.part_mass_properties(need.studio, part)) for part in need.parts
        }
        missing_parts = [part for part, reply in part_replies.items() if reply is None]
        if missing_parts:
            parts = (
                "any of its parts"
                if len(missing_parts) == len(part_replies)
                else f"its parts {', '.join(missing_parts)}"
            )
            msg = f"the bundle lacks the mass properties of part studio {need.studio.element} or of {parts}"
            raise SourceError(msg, self._where, "make the bundle again from a complete build")
        return tuple(reply for reply in part_replies.values() if reply is not None)

    def _triangles(self, need: Needs, mass: tuple[Reply, ...]) -> Reply | None:
        """Returns the tessellated faces, or else the glTF, in the compact form; None if neither is
        recorded."""
        reply = self._find(requests.recorded_faces(need.studio))
        reply = reply or self._find(requests.recorded_gltf(need.studio))
        if reply is None:
            return None
        try:
            return Reply(reply.request, compact_triangles(reply.request, reply.body, _joined(mass)))
        except ProtocolError as error:
            raise ProtocolError(error.message, self._where, "make the bundle again") from error

    def _find(self, request: str) -> Reply | None:
        recording = self._recording
        if request not in recording.requests:
            request = self._by_subject.get(requests.subject(request), "")
        if not request:
            return None
        body = recording.blobs[recording.requests[request]]
        try:
            body = cached_form(request, body)
        except ProtocolError as error:
            raise ProtocolError(error.message, self._where, "make the bundle again") from error
        return Reply(request, body)


def _joined(mass: tuple[Reply, ...]) -> bytes:
    """Returns the mass properties of all parts of a studio as a single reply."""
    if len(mass) == 1:
        return mass[0].body
    return orjson.dumps(
        {
            "bodies": {
                part: body for reply in mass for part, body in orjson.loads(reply.body)["bodies"].items()
            }
        }
    )
