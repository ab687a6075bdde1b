"""Ids like Onshape's, made from names: the same document always has the same ids."""

import base64
import hashlib


def _digest(names):
    return hashlib.sha256("\x1f".join(names).encode()).digest()


def hex_id(*names):
    """A document, workspace, version, microversion or element id: 24 hex digits."""
    return _digest(names).hex()[:24]


def node_id(*names):
    """An instance or feature id: 17 characters, "M" first; some hold "/" or "+"."""
    return "M" + base64.b64encode(_digest(names)).decode()[:16]


def deterministic_id(taken, *names):
    """A part or face id, short: "JHD", "Jj/", "R+bD"; not one of `taken`."""
    text = base64.b64encode(_digest(names)).decode()
    for length in range(2, 20):
        candidate = "JRK"[_digest(names)[-1] % 3] + text[:length] + "DH"[_digest(names)[-2] % 2]
        if candidate not in taken:
            return candidate
    msg = f"no id is left for {'/'.join(names)}"
    raise ValueError(msg)
