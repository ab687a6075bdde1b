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

MAX_TEXT_BYTES = 64 << 20
"""Largest size [bytes] of a robot file or model in a bundle."""

MAX_TRIANGLES_BYTES = 1 << 30
"""Largest size [bytes] of the triangles of a mesh in a bundle."""


class RobotFileSource(FileSource):
    """A source that is a URDF or an MJCF file."""

    recorded: ClassVar[bool] = True

    @staticmethod
    def replay(recording: Recording, where: str) -> Bundle:
        """Returns the bundle of a recorded robot file. Raises SourceError if a mesh or an image is invalid,
        or an image is missing."""
        fault = _fault(recording)
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
            return png.MAX_BYTES
        return MAX_TRIANGLES_BYTES if request.startswith(MESH) else MAX_TEXT_BYTES

    @staticmethod
    def summary(bundle: Bundle) -> str:
        meshes = sum(request.startswith(MESH) for request in bundle.requests)
        return f"{bundle.root['document']} and {count(meshes, 'mesh', 'meshes')}"


def _fault(recording: Recording) -> str:
    """Returns what is wrong with the meshes and images of a recorded robot file; "" if nothing is."""
    meshes = {name for request, name in recording.requests.items() if request.startswith(MESH)}
    images = {name for request, name in recording.requests.items() if request.startswith(IMAGE)}
    try:
        used_images = {digest for name in meshes for digest in triangles.textures(recording.blobs[name])}
        for digest in sorted(used_images - images):
            return f"it lacks the image {digest}"
        for name in sorted(images):
            if problem := png.problem(recording.blobs[name]):
                return f"an image: {problem}"
    except ProtocolError as error:
        return error.message
    return ""
