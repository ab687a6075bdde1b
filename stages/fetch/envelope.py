"""Whether a reply is what its request promises: checked before it is kept or used."""

import orjson

from stages.fetch import definition
from stages.fetch.requests import describe, is_definition
from stages.robot.errors import ProtocolError


def check(request: str, body: bytes) -> None:
    """ProtocolError where `body` does not parse or lacks the keys that every such reply has.

    Both envelopes of triangles pass: an object with `bodies`, and a bare list of bodies.
    """
    if is_definition(request):
        definition.read(body)
        return
    try:
        data = orjson.loads(body)
    except orjson.JSONDecodeError:
        msg = f"the reply with {describe(request)} is not JSON, or was cut short"
        raise ProtocolError(msg, hint="run the same command again; what was fetched is kept") from None
    if request.partition("?")[0].endswith("/massproperties"):
        fits = isinstance(data, dict) and isinstance(data.get("bodies"), dict)
    else:
        bodies = data.get("bodies") if isinstance(data, dict) else data
        fits = isinstance(bodies, list)
    if not fits:
        msg = f"the reply with {describe(request)} has no bodies"
        raise ProtocolError(
            msg, hint="run the same command again; if it fails each time, the API has changed"
        )
