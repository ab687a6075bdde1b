"""No key in anything that a build leaves: a failing and a passing one, in every way of showing a key.

The server repeats everything that it was sent, wherever a reply has room for it.
"""

import base64
import json
import re
import subprocess
import zipfile
from collections.abc import Mapping
from urllib.parse import quote

import pytest

from tests.fake_onshape import solids
from tests.fake_onshape.document import Document
from tests.fake_onshape.sample import sample_document
from tests.fake_onshape.server import Fault, OnshapeServer
from tests.support.cases import mostly_slow
from tests.support.command import called, environment, linkwright

ACCESS, SECRET = "AkZq7Distinct0Access1Key", "SkXw9Distinct2Secret3Key4Long"
TOKEN, USER = "TkVv5Distinct6Bearer7Token", "zaphod-beeblebrox"
KEY = {"ONSHAPE_ACCESS_KEY": ACCESS, "ONSHAPE_SECRET_KEY": SECRET}
WAYS: dict[str, Mapping[str, str]] = {
    "basic": KEY,
    "signature": {**KEY, "ONSHAPE_AUTH": "signature"},
    "bearer": {"ONSHAPE_ACCESS_TOKEN": TOKEN},
}


def packed(text):
    return base64.b64encode(text.encode()).decode()


PRIVATE = {
    "the access key": ACCESS,
    "the secret key": SECRET,
    "the token": TOKEN,
    "both in base64": packed(f"{ACCESS}:{SECRET}"),
    "the access key in base64": packed(ACCESS).rstrip("="),
    "the secret key in base64": packed(SECRET).rstrip("="),
    "the token in base64": packed(TOKEN).rstrip("="),
    "the user's name": USER,
}
ECHOES = {
    "basic": f"Basic {packed(f'{ACCESS}:{SECRET}')} / {ACCESS}:{SECRET}",
    "signature": f"On {ACCESS}:HmacSHA256:x / {SECRET} / {packed(ACCESS)} / {packed(SECRET)}",
    "bearer": f"Bearer {TOKEN} / {packed(TOKEN)}",
}
"""What a server may know of a key, and some more."""


def escaped(echo):
    """A message in JSON, each of its letters as an escape: no search of the bytes finds what it says."""
    return b'{"message": "%s"}' % "".join(f"\\u{ord(letter):04x}" for letter in echo).encode()


def faults(way):
    """Replies of a server that repeats the key, by name."""
    echo = ECHOES[way]
    refusal = json.dumps({"message": f"You sent Authorization: {echo}", "status": 0}).encode()
    page = f"<html><title>{echo}</title><body>{echo}</body></html>".encode()
    return {
        "401": Fault(401, refusal, {"WWW-Authenticate": echo}),
        "403": Fault(403, refusal),
        "403, in escapes": Fault(403, escaped(echo)),
        "400, in escapes": Fault(400, escaped(echo)),
        "402": Fault(402, refusal),
        "404, a page": Fault(404, page),
        "429": Fault(429, refusal, {"Retry-After": "3600", "X-Echo": echo}),
        "429, nonsense": Fault(429, refusal, {"Retry-After": echo}),
        "a redirect": Fault(307, b"", {"Location": f"https://example.com/?key={quote(echo)}"}),
        "a redirect with a user": Fault(307, b"", {"Location": f"https://{ACCESS}:{SECRET}@example.com/"}),
        "500": Fault(500, refusal),
        "200, a page": Fault(200, page),
        "200, no definition": Fault(200, json.dumps({"rootAssembly": {echo: echo}}).encode()),
        "200, cut short": Fault(200, refusal, cut=30),
    }


TRANSIENT = {"500", "200, a page", "200, no definition", "200, cut short"}
"""These are asked for again after a while, so they take long."""


def left(here):
    """Name and content of everything below `here` but `.env`; of zip files also what is in them."""
    for path in sorted(here.rglob("*")):
        name = path.relative_to(here).as_posix()
        yield f"the name {name}", name.encode()
        if path.is_file() and name != ".env":
            yield name, path.read_bytes()
            if zipfile.is_zipfile(path):
                with zipfile.ZipFile(path) as archive:
                    yield from ((f"{name}: {member}", archive.read(member)) for member in archive.namelist())


def printed(here, done):
    """Which secret is where, in what a command said and left."""
    streams = [("stdout", done.stdout.encode()), ("stderr", done.stderr.encode())]
    return [
        f"{kind} in {name}"
        for name, content in [*streams, *left(here)]
        for kind, secret in PRIVATE.items()
        if secret.encode() in content
    ]


def run(here, server, way, place, command=called):
    """Builds with the key in the environment or in `.env`, tracebacks shown."""
    variables = dict(WAYS[way])
    if place == ".env":
        (here / ".env").write_text("".join(f"{name}={value}\n" for name, value in variables.items()))
        variables = {}
    variables |= {"USER": USER, "LOGNAME": USER, "LINKWRIGHT_TRACEBACK": "1"}
    source = ["source=onshape", f"source.url='{server.document_url()}'", "source.max_wait=0"]
    return command(here, "robot=sample", *source, "until=graph", environ=environment(here, **variables))


@pytest.mark.parametrize("place", mostly_slow([".env", "environment"], keep=1))
@pytest.mark.parametrize("way", mostly_slow(WAYS, keep=1))
def test_a_build_that_passes_and_its_bundle_show_no_secret(tmp_path, way, place):
    with OnshapeServer(sample_document(), keys=(ACCESS, SECRET), token=TOKEN) as server:
        done = run(tmp_path, server, way, place, linkwright)
        assert done.returncode == 0, done.stderr
        assert printed(tmp_path, done) == []
        host = server.url.partition("//")[2]
    bundled = called(tmp_path, "bundle", "sample.graph", "arm.zip", status=0)
    assert printed(tmp_path, bundled) == []
    with zipfile.ZipFile(tmp_path / "arm.zip") as archive:
        contents = b"".join(archive.read(name) for name in archive.namelist())
    assert not any(text.encode() in contents for text in (host, "127.0.0.1", str(tmp_path)))
    counted = called(tmp_path, "cache", "info", status=0)
    assert printed(tmp_path, counted) == []


def _fails(tmp_path, way, place, fault, call):
    with OnshapeServer(sample_document(), keys=(ACCESS, SECRET), token=TOKEN) as server:
        put = faults(way)[fault]
        server.fault = lambda method, target, number: put if number >= call else None
        done = run(tmp_path, server, way, place)
    assert done.returncode == 1, done.stderr
    assert "\nerror: " in done.stderr
    assert "a bug in linkwright" not in done.stderr
    assert [*tmp_path.glob("outputs/sample*.failed")]
    assert printed(tmp_path, done) == []


REFUSALS = sorted(faults("basic").keys() - TRANSIENT)
EACH_REFUSED = [
    # Some faults meet one way of signing each; all of them meet all ways in the slow suite.
    pytest.param(way, fault, marks=() if number < 6 and number % len(WAYS) == place else pytest.mark.slow)
    for number, fault in enumerate(REFUSALS)
    for place, way in enumerate(WAYS)
]


@pytest.mark.parametrize(("way", "fault"), EACH_REFUSED)
def test_a_build_that_a_server_refuses_shows_no_secret(tmp_path, way, fault):
    _fails(tmp_path, way, ".env" if fault == "403" else "environment", fault, call=0)


@pytest.mark.slow
@pytest.mark.parametrize("call", [0, 1])
@pytest.mark.parametrize("fault", sorted(TRANSIENT))
@pytest.mark.parametrize("way", WAYS)
def test_a_build_that_a_server_fails_shows_no_secret(tmp_path, way, fault, call):
    _fails(tmp_path, way, "environment", fault, call)


@pytest.mark.parametrize("way", mostly_slow(WAYS, keep=1))
def test_a_wrong_key_is_not_shown_either(tmp_path, way):
    with OnshapeServer(sample_document(), keys=("another", "key"), token="and-another") as server:
        done = run(tmp_path, server, way, "environment")
    assert done.returncode == 1
    assert "(401)" in done.stderr
    assert printed(tmp_path, done) == []


def test_a_key_in_the_address_is_refused_without_being_repeated(tmp_path):
    for secret in (f"{ACCESS}:{SECRET}@cad.onshape.com/documents/x", f"cad.onshape.com/?token={TOKEN}"):
        done = called(tmp_path, "source=onshape", f"source.url='https://{secret}'", status=2)
        assert printed(tmp_path, done) == []


def holding(secret):
    """A document whose designer pasted the key into the name of a part."""
    document = Document("Small")
    root = document.assembly("Root")
    root.add(document.studio("Parts").part(f"Arm {secret}", solids.box(0.1, 0.1, 0.1), density=1000))
    return document


@pytest.mark.parametrize("until", ["fetch", "validate"])
def test_a_document_that_holds_the_key_is_not_kept_anywhere(tmp_path, until):
    with OnshapeServer(holding(SECRET), keys=(ACCESS, SECRET)) as server:
        source = ["source=onshape", f"source.url='{server.document_url()}'", f"until={until}"]
        done = called(tmp_path, *source, environ=environment(tmp_path, **KEY))
    assert done.returncode == 1
    assert "would hold the value of ONSHAPE_SECRET_KEY; nothing was written" in done.stderr
    assert ", rootAssembly" in done.stderr or ", parts[" in done.stderr
    assert printed(tmp_path, done) == []


@pytest.mark.slow
def test_a_cached_robot_is_not_handed_out_with_a_key_that_it_holds(tmp_path):
    """Its files come from the cache; neither a build nor a bundle gives them on."""
    (tmp_path / "arm.urdf").write_text(
        f'<robot name="arm">\n<link name="base"/>\n<link name="{SECRET}"/>\n'
        f'<joint name="j" type="fixed"><parent link="base"/><child link="{SECRET}"/></joint>\n</robot>\n'
    )
    source = ["source=urdf", "source.path=arm.urdf", "root=fixed", "until=graph"]
    linkwright(tmp_path, *source, status=0)
    knows = environment(tmp_path, **KEY)
    again = linkwright(tmp_path, *source, "output=again", environ=knows, status=1)
    assert re.search(r"(robot\.json, \S+|graph\.svg, line \d+): would hold the value", again.stderr)
    bundled = linkwright(tmp_path, "bundle", "arm.graph", "arm.zip", environ=knows, status=1)
    assert "arm.urdf, line " in bundled.stderr
    for done in (again, bundled):
        assert SECRET not in done.stdout + done.stderr
    assert not (tmp_path / "arm.zip").exists()
    files = [path for path in tmp_path.glob("again*/**/*") if path.is_file()]
    assert files
    assert not any(SECRET[:12] in path.read_text() for path in files)


@pytest.mark.parametrize("key", ["name", "output", "cache.dir", "names.links.base_plate"])
def test_key_from_an_interpolation_is_refused_without_a_trace(tmp_path, key):
    environ = environment(tmp_path, seeded=False, **KEY)
    done = called(
        tmp_path, "robot=sample", f"{key}=${{oc.env:ONSHAPE_ACCESS_KEY}}", environ=environ, status=2
    )
    assert f"E-SECRET {key}: holds the value of ONSHAPE_ACCESS_KEY" in done.stderr
    assert list(tmp_path.iterdir()) == []
    assert printed(tmp_path, done) == []


def test_the_search_finds_what_is_there(tmp_path):
    """What the tests above rely on: a secret in a file, a name, a zip or a message is found."""
    silent = subprocess.CompletedProcess([], 0, "", "")
    assert printed(tmp_path, silent) == []
    (tmp_path / ".env").write_text(SECRET)
    assert printed(tmp_path, silent) == []
    (tmp_path / "log").write_text(f"Basic {packed(f'{ACCESS}:{SECRET}')}")
    (tmp_path / TOKEN).mkdir()
    with zipfile.ZipFile(tmp_path / "a.zip", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("x", f"{USER} " * 50)
    assert printed(tmp_path, silent) == [
        f"the token in the name {TOKEN}",
        "the user's name in a.zip: x",
        "both in base64 in log",
        "the access key in base64 in log",
    ]
    assert printed(tmp_path, subprocess.CompletedProcess([], 0, SECRET, ""))[0] == "the secret key in stdout"
