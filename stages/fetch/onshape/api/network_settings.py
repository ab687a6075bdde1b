"""The environment variables of the network: proxies and trusted certificates.

The HTTP library does not check these variables, and reports an invalid one unclearly, or
only when it connects. So they are checked first. Their values are not shown: a proxy's may contain a
password.
"""

import importlib.util
from collections.abc import Mapping
from pathlib import Path
from urllib.parse import SplitResult, urlsplit

from linkwright.stages.robot.errors import ConfigError
from linkwright.stages.robot.system.install import install

CERTIFICATES, FOLDER = "SSL_CERT_FILE", "SSL_CERT_DIR"

_PROXIES = ("https_proxy", "all_proxy", "http_proxy")
_EXAMPLE = "http://proxy.example.org:3128"
_SOCKS = ("socks5", "socks5h")


def require(environ: Mapping[str, str], *, proxies: bool = True) -> None:
    """ConfigError for an invalid variable. `proxies`: whether proxies are used."""
    if proxies and "*" not in _either(environ, "no_proxy")[1]:
        for variable in _PROXIES:
            name, value = _either(environ, variable)
            if value:
                _require_proxy(name, value)
    _require_certificates(environ)


def proxy_variable(environ: Mapping[str, str]) -> str:
    """The variable that names the proxy for https, for messages."""
    found = (_either(environ, variable) for variable in _PROXIES[:2])
    return next((name for name, value in found if value), "the system's settings")


def _either(environ: Mapping[str, str], name: str) -> tuple[str, str]:
    """A variable in lower or upper case, and its value; lower case has precedence."""
    return (name, environ[name]) if name in environ else (name.upper(), environ.get(name.upper(), ""))


def _require_proxy(name: str, value: str) -> None:
    """ConfigError where `value` is not the address of a proxy; without a scheme, http is meant."""
    try:
        parts = urlsplit(value if "://" in value else f"http://{value}")
        fits = bool(parts.hostname) and parts.port != 0 and value.isprintable() and " " not in value
    except ValueError:
        parts, fits = SplitResult("", "", "", "", ""), False
    if not fits or parts.scheme not in ("http", "https", *_SOCKS):
        msg = "it is not the address of a proxy"
        raise ConfigError(msg, name, f"set it to an address such as {_EXAMPLE}, or unset it")
    if parts.scheme in _SOCKS and importlib.util.find_spec("socksio") is None:
        msg = "it names a SOCKS proxy, and the package for SOCKS proxies is not installed"
        raise ConfigError(msg, name, f"{install('socksio')}, or name a proxy such as {_EXAMPLE}")


def _require_certificates(environ: Mapping[str, str]) -> None:
    file, folder = environ.get(CERTIFICATES, ""), environ.get(FOLDER, "")
    hint = "name a file of PEM certificates, or unset it: those that come with Python packages count then"
    if file:
        # Late: an unchanged source is not read again.
        import ssl

        why = "" if Path(file).is_file() else f"{file} is not a file"
        try:
            if not why:
                ssl.create_default_context(cafile=file)
        except ssl.SSLError:
            why = f"{file} contains no certificate"
        except OSError as error:
            why = f"{file} cannot be read: {error.strerror or type(error).__name__}"
        if why:
            raise ConfigError(why, CERTIFICATES, hint)
    elif folder and not Path(folder).is_dir():
        hint = "name a folder of certificates (made by openssl rehash), or unset it"
        raise ConfigError(f"{folder} is not a folder", FOLDER, hint)
