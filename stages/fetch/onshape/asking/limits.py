"""Fetches limits that the definition lacks from an Onshape server.

A call is made for each assembly that owns a movable mate, and a call for the variables of each assembly whose
limits are expressions with variables. The server gives variables only of a workspace or a version; at a
microversion such limits stay unknown.
"""

from collections.abc import Sequence
from dataclasses import replace

from linkwright.stages.fetch.onshape import requests
from linkwright.stages.fetch.onshape.asking.cached_client import CachedClient
from linkwright.stages.fetch.onshape.gather import LimitReplies, Reply
from linkwright.stages.fetch.onshape.replies import documents, features
from linkwright.stages.fetch.onshape.replies.features import Owner
from linkwright.stages.fetch.onshape.url import AssemblyUrl


def limits_of(
    owners: Sequence[Owner], root: str, url: AssemblyUrl, client: CachedClient
) -> list[LimitReplies]:
    """Returns the limits of each owner; `root` is the id of the root assembly's document, `url` its
    address."""
    list_requests = [requests.features(owner.key, root) for owner in owners]
    bodies = client.all(list_requests)
    owners_with_variables = [
        owner
        for owner, request in zip(owners, list_requests, strict=True)
        if features.name_variables(bodies[request], owner)
    ]
    variables = _variables(owners_with_variables, root, url, client)
    return [
        LimitReplies(Reply(request, bodies[request]), variables.get(owner))
        for owner, request in zip(owners, list_requests, strict=True)
    ]


def _variables(
    owners: Sequence[Owner], root: str, url: AssemblyUrl, client: CachedClient
) -> dict[Owner, Reply]:
    """Returns the variables of the owners for which the server gives them."""
    variables: dict[Owner, Reply] = {}
    replies: dict[Owner, Reply] = {}
    for owner in owners:
        # The reply is cached, and written in bundles, under the owner's own pin, whatever the request.
        name = requests.variables(owner.key, root)
        body = client.lookup(name)
        if body is not None:
            client.count_saved(1)
            variables[owner] = Reply(name, body)
        elif owner.key.pin.startswith("v/"):
            variables[owner] = Reply(name, client.reply(name))
        elif owner.key.document == url.document and url.pin.startswith("v/"):
            variables[owner] = Reply(
                name, client.reply(requests.variables(replace(owner.key, pin=url.pin), root))
            )
        elif owner.key.document == url.document and not url.pinned and not client.offline:
            request_now = requests.variables(replace(owner.key, pin=url.pin), root)
            replies[owner] = Reply(name, client.uncached_reply(request_now))
    if not replies:
        return variables
    # The workspace may have changed since: then these are not the variables of the build.
    microversion = documents.microversion(
        client.uncached_reply(requests.current_microversion(url.document, url.pin[2:]))
    )
    replies = {owner: reply for owner, reply in replies.items() if owner.key.pin == f"m/{microversion}"}
    for reply in replies.values():
        client.keep(reply.request, reply.body)
    return {**variables, **replies}
