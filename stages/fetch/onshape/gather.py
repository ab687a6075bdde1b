"""Makes the bundle of an assembly: definition, then the part studios, then their replies.

All Onshape sources use it: the server, a bundle and the sample differ only in their `Answers`.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from hashlib import sha256
from typing import Protocol

from linkwright.stages.fetch.onshape import definition
from linkwright.stages.fetch.onshape.replies import features
from linkwright.stages.fetch.onshape.replies.features import Owner
from linkwright.stages.robot.bundle import ElementKey, Features, OnshapeBundle, Studio


@dataclass(frozen=True, slots=True)
class Reply:
    """A checked reply, under its pinned request."""

    request: str
    body: bytes


@dataclass(frozen=True, slots=True)
class Needs:
    """The needs of a build from a part studio."""

    studio: ElementKey
    parts: tuple[str, ...]
    """The ids of the parts used, sorted."""

    root: str
    """The id of the root assembly's document."""

    solids: tuple[str, ...] = ()
    """The parts that are solid bodies by the definition."""


@dataclass(frozen=True, slots=True)
class StudioReplies:
    """The replies about a part studio."""

    mass: tuple[Reply, ...]
    """A reply for the whole studio, or a reply for each part."""

    triangles: Reply | None
    """The reply with triangles; None without meshes."""


@dataclass(frozen=True, slots=True)
class LimitReplies:
    """The replies about the limits of an assembly's mates; None if they cannot be fetched."""

    features: Reply | None
    variables: Reply | None = None


class Answers(Protocol):
    """The interface of a source of replies: a server or a recording."""

    def versions(self) -> tuple[str, str]:
        """Returns the API versions of the definition (once it is fetched) and of all other replies."""
        ...

    def definition(self) -> Reply:
        """Returns the assembly definition, under a request pinned to a version or microversion."""
        ...

    def configuration(self) -> str:
        """Returns the configuration of the root assembly."""
        ...

    def studios(self, needs: Sequence[Needs]) -> Sequence[StudioReplies]:
        """Returns the replies about part studios, in the order of `needs`."""
        ...

    def features(self, owners: Sequence[Owner], root: str) -> Sequence[LimitReplies]:
        """Returns the replies about limits, in the order of `owners`; `root` is the root's document."""
        ...


def gather(answers: Answers) -> OnshapeBundle:
    """Makes the bundle of the assembly that `answers` is about.

    Raises AssemblyError if the assembly has no part; SourceError or a subclass if a reply is not available or
    is invalid.
    """
    first = answers.definition()
    assembly = definition.read(first.body)
    definition.require_parts(assembly)
    needs = needs_of(assembly)
    replies = [first]
    studios = []
    for need, answer in zip(needs, answers.studios(needs), strict=True):
        replies += [*answer.mass, *([answer.triangles] if answer.triangles else [])]
        triangles = digest(answer.triangles.body) if answer.triangles else None
        studios.append(Studio(need.studio, tuple(digest(reply.body) for reply in answer.mass), triangles))
    limits = []
    owners = features.owners(first.body)
    for owner, limit_replies in zip(owners, answers.features(owners, assembly.document), strict=True):
        if limit_replies.features is None:
            continue
        replies += [limit_replies.features, *([limit_replies.variables] if limit_replies.variables else [])]
        variables = digest(limit_replies.variables.body) if limit_replies.variables else None
        limits.append(Features(owner.key, digest(limit_replies.features.body), variables))
    definition_api, api = answers.versions()
    return OnshapeBundle(
        kind="onshape",
        api=api,
        definition_api=definition_api,
        root={
            "document": assembly.document,
            "microversion": assembly.microversion,
            "element": assembly.element,
            "configuration": answers.configuration(),
        },
        definition=digest(first.body),
        studios=tuple(studios),
        requests=_by_request(replies),
        blobs={digest(reply.body): reply.body for reply in replies},
        features=tuple(limits),
    )


def needs_of(assembly: definition.Definition) -> list[Needs]:
    """Returns the needs of a build from each part studio of an assembly."""
    return [
        Needs(key, parts, assembly.document, assembly.solids[key]) for key, parts in assembly.parts.items()
    ]


def digest(body: bytes) -> str:
    """Returns the name of a body: its SHA-256 in hex."""
    return sha256(body).hexdigest()


def _by_request(replies: Sequence[Reply]) -> Mapping[str, str]:
    return {reply.request: digest(reply.body) for reply in sorted(replies, key=lambda reply: reply.request)}
