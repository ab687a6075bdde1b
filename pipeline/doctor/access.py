"""Examines the API key, the network's settings, and Onshape itself."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from urllib.parse import urlsplit

from linkwright.pipeline.doctor.examination import ExaminationResult, State
from linkwright.stages.fetch.onshape.api import credentials, network_settings
from linkwright.stages.fetch.onshape.api.client import Client
from linkwright.stages.fetch.onshape.api.ledger import FOLDER, Ledger
from linkwright.stages.fetch.onshape.url import AssemblyUrl, parse
from linkwright.stages.robot.errors import ConfigError, LinkwrightError
from linkwright.stages.robot.text.plural import count

HOST = "https://cad.onshape.com"

_REQUEST = "documents?filter=0&limit=1"
"""The smallest request that needs the permission to read."""

_KEY_NEED = "a document of Onshape needs one; the sample, a bundle, a URDF and an MJCF need none"


def examine(
    environ: Mapping[str, str], cache: Path, url: str, *, online: bool
) -> Iterator[ExaminationResult]:
    """Yields the rows about the access to Onshape. `cache`: the folder in which API calls are counted; `url`:
    a document on the host to ask, "" for the public host. If `online` is true and there is a key, makes one
    API call, which counts. Raises ConfigError if `url` is not the URL of an Onshape assembly."""
    assembly = parse(url) if url else AssemblyUrl(HOST, "", "", "", "default")
    yield _network(environ)
    try:
        key = credentials.find(environ)
    except ConfigError as error:
        # Without any key nothing is broken: most sources need none.
        state: State = "wrong" if credentials.known_secrets(environ) else "note"
        yield ExaminationResult("key", state, f"{error.message}: {_KEY_NEED}", error.hint)
        return
    calls = count(Ledger(cache / FOLDER, key.owner_id).counted(), "call")
    kind = "a bearer token" if key.kind == "bearer" else "a pair of keys"
    yield ExaminationResult("key", "ok", f"{kind}; {calls} counted this year with this cache")
    for remark in credentials.remarks():
        yield ExaminationResult("key", "note", f"{remark.where}: {remark.message}", remark.hint)
    if online:
        yield _onshape(key, cache, assembly)
    else:
        hint = "linkwright doctor --online asks it, by one call, which counts"
        yield ExaminationResult("onshape", "note", "not tried", hint)


def _network(environ: Mapping[str, str]) -> ExaminationResult:
    try:
        network_settings.require(environ)
    except ConfigError as error:
        return ExaminationResult("network", "wrong", f"{error.where}: {error.message}", error.hint)
    variable = network_settings.proxy_variable(environ)
    # The address of a proxy may contain a password.
    detail = f"a proxy, from {variable}" if variable in environ else "no proxy is set"
    return ExaminationResult("network", "ok", detail)


def _onshape(key: credentials.Credentials, cache: Path, url: AssemblyUrl) -> ExaminationResult:
    try:
        with Client(url, key, ledger=Ledger(cache / FOLDER, key.owner_id)) as client:
            client.get(_REQUEST)
            release = client.server_facts.get("release", "")
    except LinkwrightError as error:
        return ExaminationResult("onshape", "wrong", error.message, error.hint)
    detail = f"{urlsplit(url.origin).netloc} answers, and the key may read documents"
    return ExaminationResult("onshape", "ok", f"{detail} (release {release})" if release else detail)
