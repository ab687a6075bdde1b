"""Explains errors of the connection (DNS, TCP, proxy, TLS certificate), each with a hint."""

import errno
import os
import socket
import ssl
from collections.abc import Iterator
from dataclasses import dataclass

from linkwright.stages.fetch.onshape.api.network_settings import CERTIFICATES, proxy_variable

_NETWORK_HINT = (
    "check the network and the host in source.url, or build offline: source.offline=true, source=bundle, "
    "source=sample"
)
_DNS_ERRORS = {
    socket.EAI_NONAME: "its name is not known (DNS)",
    socket.EAI_AGAIN: "no name server answers (DNS)",
}
_UNREACHABLE = {
    errno.ECONNREFUSED: "nothing listens there (connection refused)",
    errno.ENETUNREACH: "the network is unreachable",
    errno.EHOSTUNREACH: "there is no route to the host",
    errno.ECONNRESET: "it closed the connection",
    errno.ETIMEDOUT: "it does not answer",
}
_SELF_SIGNED, _IN_CHAIN, _NO_ISSUER, _UNVERIFIED_LEAF = 18, 19, 20, 21
"""OpenSSL's numbers of errors about the issuer of a certificate."""

_EARLY, _EXPIRED = 9, 10
"""OpenSSL's numbers of errors about the dates of a certificate."""

_OTHER_HOST, _OTHER_ADDRESS = 62, 64
"""OpenSSL's numbers of errors about the host of a certificate."""

_CERTIFICATES = {
    _SELF_SIGNED: "its certificate is self-signed",
    _IN_CHAIN: "its certificate chain ends in a self-signed certificate",
    _NO_ISSUER: "its certificate is not signed by a trusted authority",
    _UNVERIFIED_LEAF: "its certificate is not signed by a trusted authority",
    _EARLY: "its certificate is not valid yet",
    _EXPIRED: "its certificate has expired",
    _OTHER_HOST: "its certificate is for another host",
    _OTHER_ADDRESS: "its certificate is for another host",
}


@dataclass(frozen=True, slots=True)
class ConnectionFault:
    """The reason why a request did not reach its server."""

    message: str
    hint: str
    is_lasting: bool = False
    """Whether another attempt will fail too."""


def connection_fault(error: BaseException, host: str, endpoint: tuple[str, int] | None) -> ConnectionFault:
    """Explains the cause of `error` with a message and a hint about the connection to `host`.

    `endpoint`: the host and port of the connection; if the host differs from `host`, it is a proxy.
    """
    causes = list(_causes(error))
    for cause in causes:
        if isinstance(cause, ssl.SSLCertVerificationError):
            return _untrusted(cause, host)
        if isinstance(cause, ssl.SSLError):
            reason = (cause.reason or "no TLS").replace("_", " ").lower()
            return ConnectionFault(f"no secure connection to {host}: TLS failed ({reason})", _NETWORK_HINT)
    subject, hint = host, _NETWORK_HINT
    if endpoint is not None and endpoint[0] != host:
        variable = proxy_variable(os.environ)
        subject = f"the proxy {endpoint[0]}:{endpoint[1]} ({variable})"
        hint = f"correct or unset {variable}; NO_PROXY={host} bypasses the proxy"
    why = next((words for cause in causes if (words := _why(cause))), type(error).__name__)
    return ConnectionFault(f"{subject} cannot be reached: {why}", hint)


def refused_by_proxy(status_line: str, host: str, endpoint: tuple[str, int] | None) -> ConnectionFault:
    """Returns the trouble with a proxy that refuses; `status_line`: "407 Proxy Authentication Required"."""
    variable = proxy_variable(os.environ)
    subject = f"the proxy {endpoint[0]}:{endpoint[1]} ({variable})" if endpoint else f"the proxy ({variable})"
    status = status_line.partition(" ")[0]
    if status == "407":
        hint = f"write user and password into {variable}: http://USER:PASSWORD@HOST:PORT"
        return ConnectionFault(f"{subject} requires a login (407)", hint, is_lasting=True)
    code = f" ({status})" if status.isdigit() else ""
    hint = f"ask its administrator to allow {host}; NO_PROXY={host} bypasses the proxy"
    return ConnectionFault(
        f"{subject} refuses to connect to {host}{code}", hint, is_lasting=not status.startswith("5")
    )


def _untrusted(error: ssl.SSLCertVerificationError, host: str) -> ConnectionFault:
    code = error.verify_code
    why = _CERTIFICATES.get(code) or f"its certificate is not accepted ({error.verify_message})"
    if code in (_EARLY, _EXPIRED):
        hint = "check this computer's clock; if it is right, report this to the server's administrator"
    elif code in (_OTHER_HOST, _OTHER_ADDRESS):
        hint = "check the host in source.url, and whether the network requires a login first"
    else:
        hint = (
            f"if your network inspects TLS traffic, name its certificate: {CERTIFICATES}=FILE.pem;  "
            "otherwise another server may be answering (your key was not sent)"
        )
    return ConnectionFault(f"no secure connection to {host}: {why}", hint, is_lasting=True)


def _why(cause: BaseException) -> str:
    if isinstance(cause, socket.gaierror):
        return _DNS_ERRORS.get(cause.errno or 0) or f"its name is not found (DNS: {cause.strerror})"
    if isinstance(cause, UnicodeError):
        return "its name is not valid"
    if isinstance(cause, OSError) and cause.errno:
        return _UNREACHABLE.get(cause.errno) or (cause.strerror or "").lower()
    return ""


def _causes(error: BaseException) -> Iterator[BaseException]:
    """Yields the error and the chain of its causes."""
    earlier_ids: set[int] = set()
    cause: BaseException | None = error
    while cause is not None and id(cause) not in earlier_ids:
        earlier_ids.add(id(cause))
        yield cause
        cause = cause.__cause__ or cause.__context__
