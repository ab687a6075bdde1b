"""Computes digests of contents."""

import hashlib


def sha256(data: bytes) -> str:
    """Returns the SHA-256 of data, in hexadecimal."""
    return hashlib.sha256(data).hexdigest()
