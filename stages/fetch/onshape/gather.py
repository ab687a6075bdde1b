"""From an assembly to its bundle: definition, then the part studios, then their replies.

All Onshape sources use it: the server, a bundle and the sample differ only in their `Answers`.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from hashlib import sha256
from typing import Protocol

from linkwright.stages.fetch.onshape import definition
from linkwright.stages.fetch.onshape.replies import features
from linkwright.stages.fetch.onshape.replies.features import Owner
from linkwright.stages.robot.bundle import Features, OnshapeBundle, Studio, StudioKey


@dataclass(frozen=True, slots=True)
class Reply:
    """A checked reply, under its pinned request."""

    request: str
    body: bytes


@dataclass(frozen=True, slots=True)
class Needs:
    """What a build needs of one part studio: `parts` are the ids used, sorted; `root` the document.

    `solids`: those of the parts that are solid bodies by the definition.
    """

    studio: StudioKey
    parts: tuple[str, ...]
    root: str
    solids: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class StudioReplies:
    """The replies about one part studio: one for its mass or one a part, and its triangles if any."""

    mass: tuple[Reply, ...]
    triangles: Reply | None


@dataclass(frozen=True, slots=True)
class LimitReplies:
    """The replies about the limits of one assembly's mates; None where they cannot be fetched."""

    features: Reply | None
    variables: Reply | None = None


class Answers(Protocol):
    """The origin of replies: a server or a recording."""

    def versions(self) -> tuple[str, str]:
        """The API versions of the definition (once it is fetched) and of all other replies."""
        ...

    def definition(self) -> Reply:
        """The assembly definition, under a request pinned to a version or microversion."""
        ...

    def configuration(self) -> str:
        """The configuration of the root assembly."""
        ...

    def studios(self, needs: Sequence[Needs]) -> Sequence[StudioReplies]:
        """The answers about part studios, in the order of `needs`."""
        ...

    def features(self, owners: Sequence[Owner], root: str) -> Sequence[LimitReplies]:
        """The replies about limits, in the order of `owners`; `root` is the root's document."""
        ...


def gather(answers: Answers) -> OnshapeBundle:
    """The bundle of the assembly that `answers` is about.

    AssemblyError where the assembly has no part; SourceError and its kinds where a reply is not
    available or is invalid.
    """
    first = answers.definition()
    assembly = definition.read(first.body)
    definition.require_parts(assembly)
    needs = [
        Needs(key, parts, assembly.document, assembly.solids[key]) for key, parts in assembly.parts.items()
    ]
    replies = [first]
    studios = []
    for need, answer in zip(needs, answers.studios(needs), strict=True):
        replies += [*answer.mass, *([answer.triangles] if answer.triangles else [])]
        triangles = digest(answer.triangles.body) if answer.triangles else None
        studios.append(Studio(need.studio, tuple(digest(reply.body) for reply in answer.mass), triangles))
    limits = []
    owners = features.owners(first.body)
    for owner, found in zip(owners, answers.features(owners, assembly.document), strict=True):
        if found.features is None:
            continue
        replies += [found.features, *([found.variables] if found.variables else [])]
        variables = digest(found.variables.body) if found.variables else None
        limits.append(Features(owner.key, digest(found.features.body), variables))
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


def digest(body: bytes) -> str:
    """The name of a body: its SHA-256 in hex."""
    return sha256(body).hexdigest()


def _by_request(replies: Sequence[Reply]) -> Mapping[str, str]:
    return {reply.request: digest(reply.body) for reply in sorted(replies, key=lambda reply: reply.request)}
