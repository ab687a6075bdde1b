"""Checks the environment variables of the network: proxies and trusted certificates.

The HTTP library does not check these variables, and reports an invalid one unclearly, or
only when it connects. So they are checked first. Their values are not shown: a proxy's may contain a
password.
"""

import functools
import importlib.util
from collections.abc import Mapping
from pathlib import Path
from urllib.parse import SplitResult, urlsplit

from linkwright.stages.robot.errors import ConfigError
from linkwright.stages.robot.system.install import install

CERTIFICATES, CERTIFICATE_FOLDER = "SSL_CERT_FILE", "SSL_CERT_DIR"

_PROXIES = ("https_proxy", "all_proxy", "http_proxy")
_EXAMPLE = "http://proxy.example.org:3128"
_SOCKS = ("socks5", "socks5h")


def require(environ: Mapping[str, str], *, proxies: bool = True) -> None:
    """Raises ConfigError for an invalid variable. `proxies`: whether proxies are used."""
    if proxies and "*" not in _either(environ, "no_proxy")[1]:
        for variable in _PROXIES:
            name, value = _either(environ, variable)
            if value:
                _require_proxy(name, value)
    _require_certificates(environ)


def proxy_variable(environ: Mapping[str, str]) -> str:
    """Returns the name of the variable that sets the proxy for https, for messages."""
    variables = (_either(environ, variable) for variable in _PROXIES[:2])
    return next((name for name, value in variables if value), "the system's settings")


def _either(environ: Mapping[str, str], name: str) -> tuple[str, str]:
    """Returns a variable in lower or upper case, and its value; lower case has precedence."""
    return (name, environ[name]) if name in environ else (name.upper(), environ.get(name.upper(), ""))


def _require_proxy(name: str, value: str) -> None:
    """Raises ConfigError if `value` is not the address of a proxy; without a scheme, http is meant."""
    try:
        parts = urlsplit(value if "://" in value else f"http://{value}")
        is_address = bool(parts.hostname) and parts.port != 0 and value.isprintable() and " " not in value
    except ValueError:
        parts, is_address = SplitResult("", "", "", "", ""), False
    if not is_address or parts.scheme not in ("http", "https", *_SOCKS):
        msg = "it is not the address of a proxy"
        raise ConfigError(msg, name, f"set it to an address such as {_EXAMPLE}, or unset it")
    if parts.scheme in _SOCKS and importlib.util.find_spec("socksio") is None:
        msg = "it names a SOCKS proxy, and the package for SOCKS proxies is not installed"
        raise ConfigError(msg, name, f"{install('socksio')}, or name a proxy such as {_EXAMPLE}")


def _require_certificates(environ: Mapping[str, str]) -> None:
    file, folder = environ.get(CERTIFICATES, ""), environ.get(CERTIFICATE_FOLDER, "")
    hint = "name a file of PEM certificates, or unset it: those that come with Python packages count then"
    if file:
        why = f"{file} is not a file"
        if Path(file).is_file():
            why = _unreadable(file, Path(file).stat().st_mtime_ns)
        if why:
            raise ConfigError(why, CERTIFICATES, hint)
    elif folder and not Path(folder).is_dir():
        hint = "name a folder of certificates (made by openssl rehash), or unset it"
        raise ConfigError(f"{folder} is not a folder", CERTIFICATE_FOLDER, hint)


@functools.lru_cache(maxsize=8)
def _unreadable(file: str, changed: int) -> str:
    """Returns the reason why a file of certificates cannot be read; "" if it can.

    `changed`: the time of its last change, for the cache: reading takes 0.05 s, which each job of a sweep
    would spend.
    """
    # Late: an unchanged source is not read again.
    import ssl

    try:
        ssl.create_default_context(cafile=file)
    except ssl.SSLError:
        return f"{file} contains no certificate"
    except OSError as error:
        return f"{file} cannot be read: {error.strerror or type(error).__name__}"
    return ""
