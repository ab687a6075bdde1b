"""Records the bundle of a build in the cache under its digest, and finds it by the digest.

The digest is that of the fetch stage's manifest, which names every reply by its digest; `report.json` has it
as `bundle.manifest`. It finds the inputs of a build while the cache keeps them, even for a workspace, whose
fetch has no key.
"""

import json
from typing import TYPE_CHECKING

from linkwright.pipeline.caching.actions import Action, Cache, Files
from linkwright.stages.robot.bundle import FileBundle
from linkwright.stages.robot.codec import REPLIES, decode_bundle

if TYPE_CHECKING:
    from linkwright.stages.robot.bundle import Bundle

_MANIFEST = "manifest.json"


def remember(cache: Cache, fetched: Files) -> str:
    """Records the result of the fetch stage under the digest of its manifest; returns the digest."""
    digest = fetched.digests[_MANIFEST]
    bundle = {
        path: file_digest
        for path, file_digest in fetched.digests.items()
        if path == _MANIFEST or path.startswith(REPLIES)
    }
    cache.name(_action(digest), Files(cache.store, bundle))
    return digest


def recall(cache: Cache, digest: str) -> "Bundle | None":
    """Returns the bundle whose manifest has this digest; None if the cache lacks any part of it."""
    files = cache.find(_action(digest).key)
    if files is None:
        return None

    return decode_bundle(files)


def readable_files(bundle: "Bundle") -> dict[str, bytes]:
    """Returns the content of a bundle by readable names: the robot's file, or the request of a reply."""
    names = {digest: request for request, digest in bundle.requests.items()}
    manifest = {"root": dict(bundle.root), "requests": dict(bundle.requests)}
    if isinstance(bundle, FileBundle):
        names[bundle.definition] = bundle.root["document"]
        manifest["options"] = dict(bundle.options)
    bodies = {names.get(digest, digest): body for digest, body in bundle.blobs.items()}
    return {**bodies, _MANIFEST: json.dumps(manifest, ensure_ascii=False).encode()}


def _action(digest: str) -> Action:
    return Action("bundle", 2, inputs={_MANIFEST: digest})
