"""The bundle that a build read: filed in the cache under its own digest, and found again by it.

The digest is that of the fetch stage's manifest, which names every reply by its digest; `report.json`
holds it as `bundle.manifest`. So what a build read is found for as long as the cache keeps it, also
where the source was a workspace, of which no action can be recorded.
"""

import json
from typing import TYPE_CHECKING

from pipeline.caching.actions import Action, Cache, Files
from stages.robot.codec import REPLIES

if TYPE_CHECKING:
    from stages.robot.bundle import Bundle

_MANIFEST = "manifest.json"


def remember(cache: Cache, fetched: Files) -> str:
    """Files the fetch stage's `fetched` under the digest of its manifest; the digest."""
    digest = fetched.digests[_MANIFEST]
    bundle = {path: d for path, d in fetched.digests.items() if path == _MANIFEST or path.startswith(REPLIES)}
    cache.name(_action(digest), Files(cache.store, bundle))
    return digest


def recall(cache: Cache, digest: str) -> "Bundle | None":
    """The bundle with that manifest; None where the cache lacks it or any reply of it."""
    files = cache.find(_action(digest).key)
    if files is None:
        return None
    from stages.robot.codec import decode_bundle

    return decode_bundle(files)


def named(bundle: "Bundle") -> dict[str, bytes]:
    """What a bundle holds, by names that people know: the robot's own file, or the request of a reply."""
    from stages.robot.bundle import FileBundle

    names = {digest: request for request, digest in bundle.requests.items()}
    about = {"root": dict(bundle.root), "requests": dict(bundle.requests)}
    if isinstance(bundle, FileBundle):
        names[bundle.definition] = bundle.root["document"]
        about["options"] = dict(bundle.options)
    bodies = {names.get(digest, digest): body for digest, body in bundle.blobs.items()}
    return {**bodies, _MANIFEST: json.dumps(about, ensure_ascii=False).encode()}


def _action(digest: str) -> Action:
    return Action("bundle", 2, inputs={_MANIFEST: digest})
