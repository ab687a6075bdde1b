"""Finds the user's Onshape credentials: in the environment, or in `.env` in the working folder."""

import contextlib
import html
import io
import itertools
import json
import os
import re
import stat
from base64 import b64encode, urlsafe_b64encode
from collections.abc import Mapping
from dataclasses import dataclass, field
from hashlib import sha256
from pathlib import Path
from typing import Literal
from urllib.parse import quote

from linkwright.stages.robot.errors import ConfigError, Diagnostic
from linkwright.stages.robot.system import regular_files

ACCESS = "ONSHAPE_ACCESS_KEY"
SECRET = "ONSHAPE_SECRET_KEY"
TOKEN = "ONSHAPE_ACCESS_TOKEN"
OLD_TOKEN = "ONSHAPE_SECRET_BEARER"
AUTH = "ONSHAPE_AUTH"

PRIVATE = (ACCESS, SECRET, TOKEN, OLD_TOKEN)
"""Variables whose values are secret."""

DOTENV = ".env"
_MAX_DOTENV = 1 << 20
"""Largest size of a `.env` that is read [bytes]."""

Kind = Literal["basic", "signature", "bearer"]


@dataclass(frozen=True, slots=True)
class Credentials:
    """An API key, or a bearer `token`. `repr` hides its text, so that no log or traceback contains it."""

    access: str = field(default="", repr=False)
    secret: str = field(default="", repr=False)
    kind: Kind = "basic"
    """The way of authenticating a request."""

    token: str = field(default="", repr=False)

    @property
    def owner_id(self) -> str:
        """An identifier of the owner of the calls, which does not reveal the key.

        All bearer tokens share an identifier, since each is valid for only an hour.
        """
        return "bearer" if self.kind == "bearer" else sha256(self.access.encode()).hexdigest()[:16]

    @property
    def private(self) -> tuple[str, ...]:
        """The texts that must never be written anywhere, the longest first."""
        secrets = {text for text in (self.access, self.secret, self.token) if text}
        pair = {f"{self.access}:{self.secret}"} if self.access and self.secret else set()
        spellings = {form for text in secrets | pair for form in forms(text)} - pair
        return tuple(sorted(spellings, key=lambda text: (-len(text), text)))

    def scrub(self, text: str) -> str:
        """Returns `text` (such as a server's reply) with the key removed."""
        for secret in self.private:
            text = text.replace(secret, "***")
        return text


def forms(text: str) -> frozenset[str]:
    """Returns the forms in which files and servers may write `text`: plain, in base64, with escapes of URLs,
    JSON, XML."""
    raw = text.encode("utf-8", "replace")
    packed = {b64encode(raw).decode(), urlsafe_b64encode(raw).decode()}
    bare = {text, *packed, *(encoded.rstrip("=") for encoded in packed)}
    escaped = {quote(form, safe="") for form in bare}
    escaped |= {re.sub("%..", lambda code: code[0].lower(), form) for form in escaped}
    for form in bare:
        json_text = json.dumps(form)[1:-1]
        escaped |= {
            json_text,
            json_text.replace("/", "\\/"),
            html.escape(form),
            html.escape(form, quote=False),
        }
    return frozenset(bare | escaped)


def known_secrets(environ: Mapping[str, str], folder: Path | None = None) -> dict[str, str]:
    """Returns every form of every key in `environ` and in `.env`, used by a build or not: the text → its
    variable."""
    file_values: Mapping[str, str] = {}
    with contextlib.suppress(ConfigError, OSError):
        file_values = _dotenv((folder or Path.cwd()) / DOTENV)
    values: dict[str, set[str]] = {}
    for name in PRIVATE:
        texts = (variables.get(name, "").strip() for variables in (environ, file_values))
        values[name] = {text for text in texts if text}
    owners: dict[str, str] = {}
    for access, secret in itertools.product(sorted(values[ACCESS]), sorted(values[SECRET])):
        owners |= dict.fromkeys(sorted(forms(f"{access}:{secret}")), f"{ACCESS} and {SECRET}")
    for name in PRIVATE:
        for text in sorted(values[name]):
            owners |= dict.fromkeys(sorted(forms(text)), name)
    return owners


def remarks(folder: Path | None = None) -> tuple[Diagnostic, ...]:
    """Reports I-DOTENV if other users can read the key in `.env`."""
    path = (folder or Path.cwd()) / DOTENV
    if os.name != "posix":
        return ()
    try:
        mode = stat.S_IMODE(path.stat().st_mode)
        reader_names = [
            owner_id for owner_id, bits in (("its group", 0o070), ("everybody", 0o007)) if mode & bits
        ]
        if not reader_names or not any(name in PRIVATE for name in _dotenv(path)):
            return ()
    except (OSError, ConfigError):
        return ()
    msg = f"the API key in it is open to {' and '.join(reader_names)} on this computer (mode {mode:04o})"
    return (Diagnostic("I-DOTENV", msg, DOTENV, f"chmod 600 {DOTENV}"),)


def find(environ: Mapping[str, str], folder: Path | None = None) -> Credentials:
    """Returns the key in `environ`, or else in `.env` in `folder` (default: the working folder).

    It is a bearer token if one is set, or else an API key. Raises ConfigError, which names the variable that
    is missing.
    """
    names = (ACCESS, SECRET, TOKEN, OLD_TOKEN, AUTH)
    environ_values = {name: environ[name].strip() for name in names if environ.get(name, "").strip()}
    file_values = {name: value.strip() for name, value in _dotenv((folder or Path.cwd()) / DOTENV).items()}
    values = file_values | environ_values
    kind = _kind(values.get(AUTH, "basic").lower())
    # A whole key in the environment goes before a token in the file.
    whole_key = ACCESS in environ_values and SECRET in environ_values
    tokens = environ_values if whole_key else values
    token = tokens.get(TOKEN) or tokens.get(OLD_TOKEN)
    if token:
        _require_plain(token, f"{TOKEN} or {OLD_TOKEN}")
        return Credentials(kind="bearer", token=token)
    access, secret = (values.get(name, "") for name in (ACCESS, SECRET))
    missing = [name for name, value in ((ACCESS, access), (SECRET, secret)) if not value]
    if missing:
        msg = f"no Onshape API key: {' and '.join(missing)} not set, neither in the environment nor in .env"
        if regular_files.is_special((folder or Path.cwd()) / DOTENV):
            msg += f" ({regular_files.NOT_REGULAR})"
        hint = (
            "make a key with read permission in Onshape (My account > Developer > API keys) and set both "
            "variables, or build without the network: linkwright source=sample"
        )
        raise ConfigError(msg, hint=hint)
    _require_plain(access + secret, f"{ACCESS} or {SECRET}")
    return Credentials(access, secret, kind)


def _kind(text: str) -> Kind:
    if text == "basic":
        return "basic"
    if text == "signature":
        return "signature"
    msg = f"{AUTH} is neither basic nor signature"
    raise ConfigError(msg, hint=f"set {AUTH}=signature to sign each request, or leave it out")


def _require_plain(text: str, names: str) -> None:
    """Raises ConfigError for text that cannot be a key; the text itself is not shown."""
    if not text.isascii() or not text.isprintable():
        msg = f"{names} contains characters that no Onshape key has"
        raise ConfigError(msg, hint="copy the key again, without quotes or line breaks")


def _dotenv(path: Path) -> dict[str, str]:
    # A pipe or a device of that name is ignored: it may block, or never end.
    if not regular_files.is_file(path):
        return {}
    # Late: only where there is such a file.
    from dotenv import dotenv_values

    try:
        text = regular_files.content(path, _MAX_DOTENV).decode()
        values = dotenv_values(stream=io.StringIO(text), interpolate=False)
    except (OSError, UnicodeDecodeError, regular_files.FileTooLarge) as error:
        msg = f"the file .env cannot be read: {_reason(error)}"
        raise ConfigError(msg, DOTENV, f"write lines such as {ACCESS}=... in it, as UTF-8 text") from None
    return {name: value for name, value in values.items() if value and value.strip()}


def _reason(error: Exception) -> str:
    if isinstance(error, regular_files.FileTooLarge):
        return f"it is larger than {_MAX_DOTENV} bytes"
    return "it is not UTF-8 text" if isinstance(error, UnicodeDecodeError) else type(error).__name__
