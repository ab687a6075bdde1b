"""The user's API key: from the environment, or from `.env` where they work."""

from base64 import b64encode
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from stages.robot.errors import ConfigError

ACCESS = "ONSHAPE_ACCESS_KEY"
SECRET = "ONSHAPE_SECRET_KEY"


@dataclass(frozen=True, slots=True)
class Credentials:
    """An API key. Its text never shows in `repr`, so that no log or traceback holds it."""

    access: str = field(repr=False)
    secret: str = field(repr=False)

    def scrub(self, text: str) -> str:
        """`text` with the key blotted out, for what a server sent back."""
        header = b64encode(f"{self.access}:{self.secret}".encode()).decode()
        for private in (header, self.secret, self.access):
            text = text.replace(private, "***")
        return text


def find(environ: Mapping[str, str], folder: Path | None = None) -> Credentials:
    """The API key of `environ`, else of `.env` in `folder` (default: the working folder).

    ConfigError names the variable that is missing.
    """
    path = (folder or Path.cwd()) / ".env"
    values = _dotenv(path) | {
        name: environ[name] for name in (ACCESS, SECRET) if environ.get(name, "").strip()
    }
    access, secret = (values.get(name, "").strip() for name in (ACCESS, SECRET))
    missing = [name for name, value in ((ACCESS, access), (SECRET, secret)) if not value]
    if missing:
        msg = f"no Onshape API key: {' and '.join(missing)} not set, neither in the environment nor in .env"
        hint = (
            "make a key with read permission in Onshape (My account > Developer > API keys) and set both "
            "variables, or build without the network: linkwright source=sample"
        )
        raise ConfigError(msg, hint=hint)
    if not (access + secret).isascii() or not (access + secret).isprintable():
        msg = f"{ACCESS} or {SECRET} holds characters that no Onshape key has"
        raise ConfigError(msg, hint="copy the key again, without quotes or line breaks")
    return Credentials(access, secret)


def _dotenv(path: Path) -> dict[str, str]:
    if not path.is_file():
        return {}
    from dotenv import dotenv_values

    try:
        values = dotenv_values(path, interpolate=False)
    except (OSError, UnicodeDecodeError) as error:
        msg = f"the file .env cannot be read: {type(error).__name__}"
        raise ConfigError(msg, ".env", f"write lines such as {ACCESS}=... in it, as UTF-8 text") from None
    return {name: value for name, value in values.items() if value}
