"""API keys: where they come from, how a request shows them, and that nothing else does."""

import os
from email.utils import formatdate
from time import time

import pytest

from linkwright.stages.fetch.onshape.api import signing
from linkwright.stages.fetch.onshape.api.credentials import Credentials, find, remarks
from linkwright.stages.robot.errors import AuthError, ConfigError
from tests.fake_onshape.server import ACCESS_KEY, SECRET_KEY, Fault, OnshapeServer
from tests.support.faulty import desk
from tests.support.kept import client_at

KEYS = {"ONSHAPE_ACCESS_KEY": "a", "ONSHAPE_SECRET_KEY": "s"}


def test_the_environment_wins_over_dotenv_variable_by_variable(tmp_path):
    (tmp_path / ".env").write_text("ONSHAPE_ACCESS_KEY=file-a\nONSHAPE_SECRET_KEY='file-s'\n")
    assert find({}, tmp_path) == Credentials("file-a", "file-s")
    assert find({"ONSHAPE_ACCESS_KEY": "env-a"}, tmp_path) == Credentials("env-a", "file-s")
    assert find({"ONSHAPE_ACCESS_KEY": " "}, tmp_path) == Credentials("file-a", "file-s")


def test_a_missing_key_is_named(tmp_path):
    with pytest.raises(ConfigError, match="ONSHAPE_ACCESS_KEY and ONSHAPE_SECRET_KEY"):
        find({}, tmp_path)
    with pytest.raises(ConfigError, match="ONSHAPE_SECRET_KEY not set"):
        find({"ONSHAPE_ACCESS_KEY": "a"}, tmp_path)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs pipes")
def test_a_dotenv_that_is_no_plain_small_text_is_not_read(tmp_path):
    path = tmp_path / ".env"
    for make, words in (
        (lambda: os.mkfifo(path), r"nor in .env \(it is a device, a pipe or a socket"),
        (lambda: path.symlink_to("/dev/zero"), "a device"),
        (path.mkdir, r"nor in .env\n"),
        (lambda: path.write_bytes(b"# " * (1 << 20)), "cannot be read: it is larger than"),
        (lambda: path.write_bytes(b"ONSHAPE_SECRET_KEY=hush\xff\xfe"), r"\.env"),
    ):
        make()
        with pytest.raises(ConfigError, match=words) as caught:
            find({}, tmp_path)
        assert "hush" not in str(caught.value)
        assert not path.is_fifo() or find(KEYS, tmp_path) == Credentials("a", "s")
        path.rmdir() if path.is_dir() else path.unlink()


def test_a_key_with_a_line_break_is_refused_without_showing_it(tmp_path):
    with pytest.raises(ConfigError) as caught:
        find({"ONSHAPE_ACCESS_KEY": "a", "ONSHAPE_SECRET_KEY": "zq\nxj"}, tmp_path)
    assert "zq" not in str(caught.value)


def test_a_token_goes_before_a_key_of_the_same_place(tmp_path):
    assert find({**KEYS, "ONSHAPE_ACCESS_TOKEN": "t"}, tmp_path) == Credentials(kind="bearer", token="t")
    (tmp_path / ".env").write_text("ONSHAPE_SECRET_BEARER=from-file\n")
    assert find({}, tmp_path) == Credentials(kind="bearer", token="from-file")
    assert find(KEYS, tmp_path) == Credentials("a", "s")


@pytest.mark.parametrize(
    ("mode", "who"),
    [
        (0o600, None),
        (0o400, None),
        (0o640, "its group on this computer (mode 0640)"),
        (0o604, "everybody"),
        (0o644, "its group and everybody"),
    ],
)
def test_a_dotenv_with_a_key_that_others_can_read_gets_a_remark(tmp_path, mode, who):
    path = tmp_path / ".env"
    assert remarks(tmp_path) == ()
    path.write_text("PORT=8000\n")
    path.chmod(0o644)
    assert remarks(tmp_path) == ()
    path.write_text("ONSHAPE_SECRET_KEY=hush-hush\n")
    path.chmod(mode)
    problems = [(problem.code, problem.where, problem.hint) for problem in remarks(tmp_path)]
    assert problems == ([("I-DOTENV", ".env", "chmod 600 .env")] if who else [])
    assert all(who in problem.message and "hush" not in problem.message for problem in remarks(tmp_path))


def test_signing_is_chosen_by_name(tmp_path):
    assert find({**KEYS, "ONSHAPE_AUTH": "Signature"}, tmp_path) == Credentials("a", "s", "signature")
    with pytest.raises(ConfigError, match="neither basic nor signature"):
        find({**KEYS, "ONSHAPE_AUTH": "oauth"}, tmp_path)


def test_a_ledgers_name_does_not_tell_the_key():
    key = Credentials("my-access", "my-secret")
    assert len(key.owner_id) == 16
    assert (
        key.owner_id
        == Credentials("my-access", "another", "signature").owner_id
        != Credentials("x", "y").owner_id
    )
    assert "access" not in key.owner_id
    assert Credentials(kind="bearer", token="t").owner_id == "bearer"


def test_the_key_is_in_neither_repr_nor_scrubbed_text():
    key = Credentials("my-access", "my-secret")
    assert "my-" not in repr(key)
    header = "bXktYWNjZXNzOm15LXNlY3JldA=="
    assert key.scrub(f"my-access:my-secret Basic {header}") == "***:*** Basic ***"
    bearer = Credentials(kind="bearer", token="my-token")
    assert "my-" not in repr(bearer)
    assert bearer.scrub("Bearer my-token, and more") == "Bearer ***, and more"


TARGET = "/api/v16/partstudios/d/D/w/W/e/E/massproperties?configuration=a%3Db%2Bc"


def test_the_signature_is_that_of_openssl():
    """The same text through `openssl dgst -sha256 -hmac 'The-Secret' -binary | base64`."""
    signed = signing.signature(
        "The-Secret", "GET", "aBcDeFgHiJkLmNoPqRsTuVwXy", "Mon, 02 Mar 2026 10:11:12 GMT", TARGET
    )
    assert signed == "BuokfNIrcOxmccvY5gWwjaqZLnYhT0t3g65BsHbGub0="


def test_a_signed_request_has_its_own_nonce_and_no_secret():
    key = Credentials("acc", "sec-ret", "signature")
    first, second = signing.headers(key, "GET", TARGET), signing.headers(key, "GET", TARGET)
    assert "sec-ret" not in str(first)
    assert first["On-Nonce"] != second["On-Nonce"]
    assert first["On-Nonce"].isalnum()
    assert len(first["On-Nonce"]) == 25


@pytest.fixture(scope="module")
def document():
    return desk()


@pytest.mark.parametrize(
    ("key", "said"),
    [
        (Credentials(ACCESS_KEY, "wrong"), "a key works only on the host where it was made"),
        (Credentials(ACCESS_KEY, "wrong", "signature"), "The signature is not good."),
        (Credentials("wrong", SECRET_KEY, "signature"), "API key"),
        (Credentials(kind="bearer", token="stale"), "valid for about an hour"),
    ],
)
def test_a_wrong_key_is_refused_and_explained_after_one_call(document, key, said):
    with OnshapeServer(document) as server:
        with client_at(server.url, key) as client, pytest.raises(AuthError) as caught:
            client.get(f"/documents/d/{document.id}/m/{document.microversion}/elements")
        assert len(server.calls) == 1
    assert said in str(caught.value)
    assert "wrong" not in str(caught.value)
    assert "stale" not in str(caught.value)


@pytest.mark.parametrize(("away", "said"), [(600, "10 min behind"), (-600, "10 min ahead of")])
def test_a_clock_that_is_wrong_is_named(document, away, said):
    """The server's clock is ours; here it tells another time in what it refuses."""

    def elsewhen(method, path, number):
        return Fault(401, b"{}", {"Date": formatdate(time() + away, usegmt=True)})

    with OnshapeServer(document, fault=elsewhen) as server:
        key = Credentials(ACCESS_KEY, SECRET_KEY, "signature")
        with client_at(server.url, key) as client, pytest.raises(AuthError, match=said):
            client.get("/documents/d/D/w/W/currentmicroversion")
