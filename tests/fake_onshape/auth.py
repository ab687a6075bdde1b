"""Who asks: the three ways in which a request can show its key, as the server checks them."""

import base64
import hashlib
import hmac
import re
from datetime import UTC, datetime, timedelta
from email.utils import parsedate_to_datetime

_SIGNED = re.compile(r"On (?P<access>[^:]+):HmacSHA256:(?P<signature>.+)")
_CLOCK = timedelta(minutes=5)


class Gate:
    """Lets in who has the API key `keys` (access, secret) or the bearer `token`; a nonce serves once."""

    def __init__(self, keys, token):
        self.keys, self.token = keys, token
        self._nonces = set()

    def refuses(self, method, target, headers):
        """Why a request is not let in; nothing if it is."""
        header = headers.get("Authorization", "")
        if header == f"Bearer {self.token}":
            return ""
        if header == "Basic " + base64.b64encode(":".join(self.keys).encode()).decode():
            return ""
        match = _SIGNED.fullmatch(header)
        if match is None or match["access"] != self.keys[0]:
            return "Unauthenticated API request."
        return self._signed(match["signature"], method, target, headers)

    def _signed(self, signature, method, target, headers):
        nonce, date = headers.get("On-Nonce", ""), headers.get("Date", "")
        if not re.fullmatch(r"[A-Za-z0-9]{16,}", nonce) or nonce in self._nonces:
            return "The nonce is not good."
        try:
            when = parsedate_to_datetime(date)
        except ValueError:
            return "The date is not good."
        if abs(datetime.now(UTC) - when) > _CLOCK:
            return "The date is too far from now."
        path, _, query = target.partition("?")
        lines = [method, nonce, date, headers.get("Content-Type", ""), path, query, ""]
        digest = hmac.new(self.keys[1].encode(), "\n".join(lines).lower().encode(), hashlib.sha256)
        if base64.b64encode(digest.digest()).decode() != signature:
            return "The signature is not good."
        self._nonces.add(nonce)
        return ""
