"""Authenticates a request: Basic, signed with the secret key, or by a bearer token.

A signed request never carries the secret: method, nonce, date, content type, path and query, each
with a line feed, in lower case, go through HMAC-SHA256 with the secret key. The path and the query
are signed as they are sent. Source: Onshape's documentation, "API keys > request signature".
"""

import hmac
import secrets
import time
from base64 import b64encode
from email.utils import formatdate

from linkwright.stages.fetch.onshape.api.credentials import Credentials

CONTENT_TYPE = "application/json"
"""The content type: part of the signature, so it is sent with a GET too."""

_NONCE_LENGTH = 25


def headers(credentials: Credentials, method: str, target: str) -> dict[str, str]:
    """Returns the headers that authenticate a request; new for each request and for each followed redirect.

    `target`: path and query exactly as they are sent.
    """
    if credentials.kind == "bearer":
        return {"Authorization": f"Bearer {credentials.token}"}
    if credentials.kind == "basic":
        pair = f"{credentials.access}:{credentials.secret}".encode()
        return {"Authorization": f"Basic {b64encode(pair).decode()}"}
    nonce = secrets.token_hex(_NONCE_LENGTH)[:_NONCE_LENGTH]
    date = formatdate(time.time(), usegmt=True)
    signed = signature(credentials.secret, method, nonce, date, target)
    return {
        "Authorization": f"On {credentials.access}:HmacSHA256:{signed}",
        "On-Nonce": nonce,
        "Date": date,
        "Content-Type": CONTENT_TYPE,
    }


def signature(secret: str, method: str, nonce: str, date: str, target: str) -> str:
    """Returns the signature of a request, in base64."""
    path, _, query = target.partition("?")
    fields = (method, nonce, date, CONTENT_TYPE, path, query)
    text = "".join(f"{field}\n" for field in fields).lower()
    return b64encode(hmac.digest(secret.encode(), text.encode(), "sha256")).decode()
