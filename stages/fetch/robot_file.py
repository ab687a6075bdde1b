"""Defines the base class of sources that are a robot file with its meshes (URDF, MJCF)."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from linkwright.stages.fetch.source import FileSource
from linkwright.stages.formats import png, triangles
from linkwright.stages.robot.bundle import FileBundle
from linkwright.stages.robot.errors import ProtocolError, SourceError
from linkwright.stages.robot.text.plural import count

if TYPE_CHECKING:
    from linkwright.stages.fetch.recording import Recording
    from linkwright.stages.robot.bundle import Bundle

MESH = "mesh/"
"""Prefix of requests for meshes in a bundle."""

IMAGE = "image/"
"""Prefix of requests for images of meshes in a bundle."""

LARGEST_TEXT = 64 << 20
"""Largest size [bytes] of a robot file or model in a bundle."""

LARGEST_TRIANGLES = 1 << 30
"""Largest size [bytes] of the triangles of a mesh in a bundle."""


class RobotFileSource(FileSource):
    """A source that is a URDF or an MJCF file."""

    recorded: ClassVar[bool] = True

    @staticmethod
    def replay(recording: Recording, where: str) -> Bundle:
        """Returns the bundle of a recorded robot file. Raises SourceError if a mesh or an image is invalid,
        or an image is missing."""
        meshes = {name for request, name in recording.requests.items() if request.startswith(MESH)}
        recorded_images = {name for request, name in recording.requests.items() if request.startswith(IMAGE)}
        try:
            used_images = frozenset[str]().union(
                *(triangles.textures(recording.blobs[name]) for name in meshes)
            )
            fault = next(
                (f"it lacks the image {digest}" for digest in sorted(used_images - recorded_images)), ""
            )
            image_faults = (png.problem(recording.blobs[name]) for name in sorted(recorded_images))
            fault = fault or next((f"an image: {problem}" for problem in image_faults if problem), "")
        except ProtocolError as error:
            fault = error.message
        if fault:
            msg = f"not readable as a bundle: {fault}"
            hint = "make the bundle again, or copy it again from its source"
            raise SourceError(msg, where, hint)
        digests = {recording.definition, *recording.requests.values()}
        return FileBundle(
            kind=recording.kind,
            root=recording.root,
            definition=recording.definition,
            requests=recording.requests,
            blobs={name: recording.blobs[name] for name in sorted(digests)},
            options=recording.options,
        )

    @staticmethod
    def largest_reply(request: str) -> int:
        if request.startswith(IMAGE):
            return png.LARGEST
        return LARGEST_TRIANGLES if request.startswith(MESH) else LARGEST_TEXT

    @staticmethod
    def summary(bundle: Bundle) -> str:
        meshes = sum(request.startswith(MESH) for request in bundle.requests)
        return f"{bundle.root['document']} and {count(meshes, 'mesh', 'meshes')}"
