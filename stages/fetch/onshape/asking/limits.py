"""Fetches limits that the definition lacks from an Onshape server.

One call for each assembly that owns a mate that moves, and one for the variables of each whose
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
    """The limits of each owner; `root` is the id of the root assembly's document, `url` its address."""
    lists = [requests.features(owner.key, root) for owner in owners]
    bodies = client.all(lists)
    needy = [
        owner
        for owner, request in zip(owners, lists, strict=True)
        if features.name_variables(bodies[request], owner)
    ]
    variables = _variables(needy, root, url, client)
    return [
        LimitReplies(Reply(request, bodies[request]), variables.get(owner))
        for owner, request in zip(owners, lists, strict=True)
    ]


def _variables(
    owners: Sequence[Owner], root: str, url: AssemblyUrl, client: CachedClient
) -> dict[Owner, Reply]:
    """The variables of the owners for which the server gives them."""
    found: dict[Owner, Reply] = {}
    fresh: dict[Owner, Reply] = {}
    for owner in owners:
        # Kept, and written in bundles, under the owner's own pin, whatever was asked.
        name = requests.variables(owner.key, root)
        body = client.kept(name)
        if body is not None:
            client.spare(1)
            found[owner] = Reply(name, body)
        elif owner.key.pin.startswith("v/"):
            found[owner] = Reply(name, client.one(name))
        elif owner.key.document == url.document and url.pin.startswith("v/"):
            found[owner] = Reply(name, client.one(requests.variables(replace(owner.key, pin=url.pin), root)))
        elif owner.key.document == url.document and not url.pinned and not client.offline:
            there = requests.variables(replace(owner.key, pin=url.pin), root)
            fresh[owner] = Reply(name, client.now(there))
    if not fresh:
        return found
    # A workspace may have moved on since: then these are not the variables of what is built.
    now = documents.microversion(client.now(requests.current_microversion(url.document, url.pin[2:])))
    fresh = {owner: reply for owner, reply in fresh.items() if owner.key.pin == f"m/{now}"}
    for reply in fresh.values():
        client.keep(reply.request, reply.body)
    return {**found, **fresh}
