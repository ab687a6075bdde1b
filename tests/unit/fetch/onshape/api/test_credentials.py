"""API keys: where they come from, and that they never show."""

import os

import pytest

from linkwright.stages.fetch.onshape.api.credentials import Credentials, find, remarks
from linkwright.stages.robot.errors import ConfigError


def test_the_environment_wins_over_dotenv_variable_by_variable(tmp_path):
    (tmp_path / ".env").write_text("ONSHAPE_ACCESS_KEY=file-a\nONSHAPE_SECRET_KEY='file-s'\n")
    assert find({}, tmp_path) == Credentials("file-a", "file-s")
    assert find({"ONSHAPE_ACCESS_KEY": "env-a"}, tmp_path) == Credentials("env-a", "file-s")
    assert find({"ONSHAPE_ACCESS_KEY": " "}, tmp_path) == Credentials("file-a", "file-s")


@pytest.mark.parametrize(
    ("environ", "named"),
    [
        ({}, "ONSHAPE_ACCESS_KEY and ONSHAPE_SECRET_KEY"),
        ({"ONSHAPE_ACCESS_KEY": "a"}, "ONSHAPE_SECRET_KEY not set"),
    ],
)
def test_what_is_missing_is_named(tmp_path, environ, named):
    with pytest.raises(ConfigError, match=named):
        find(environ, tmp_path)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs pipes")
def test_a_dotenv_that_is_a_pipe_or_a_device_is_not_read(tmp_path):
    os.mkfifo(tmp_path / ".env")
    key = {"ONSHAPE_ACCESS_KEY": "a", "ONSHAPE_SECRET_KEY": "s"}
    assert find(key, tmp_path) == Credentials("a", "s")
    with pytest.raises(ConfigError, match=r"nor in .env \(it is a device, a pipe or a socket"):
        find({}, tmp_path)
    (tmp_path / ".env").unlink()
    (tmp_path / ".env").symlink_to("/dev/zero")
    with pytest.raises(ConfigError, match="a device"):
        find({}, tmp_path)
    (tmp_path / ".env").unlink()
    (tmp_path / ".env").mkdir()
    with pytest.raises(ConfigError, match=r"nor in .env\n"):
        find({}, tmp_path)


def test_a_dotenv_that_is_huge_is_not_read(tmp_path):
    (tmp_path / ".env").write_bytes(b"# " * (1 << 20))
    with pytest.raises(ConfigError, match="cannot be read: it is larger than"):
        find({}, tmp_path)


def test_a_dotenv_that_is_no_text_is_an_error_without_its_content(tmp_path):
    (tmp_path / ".env").write_bytes(b"ONSHAPE_SECRET_KEY=hush\xff\xfe")
    with pytest.raises(ConfigError) as caught:
        find({}, tmp_path)
    assert "hush" not in str(caught.value)


def test_a_key_with_a_line_break_is_refused_without_showing_it(tmp_path):
    with pytest.raises(ConfigError) as caught:
        find({"ONSHAPE_ACCESS_KEY": "a", "ONSHAPE_SECRET_KEY": "zq\nxj"}, tmp_path)
    assert "zq" not in str(caught.value)


def test_a_token_goes_before_a_key_but_a_whole_key_outside_goes_before_a_token_in_dotenv(tmp_path):
    keys = {"ONSHAPE_ACCESS_KEY": "a", "ONSHAPE_SECRET_KEY": "s"}
    assert find({**keys, "ONSHAPE_ACCESS_TOKEN": "t"}, tmp_path) == Credentials(kind="bearer", token="t")
    (tmp_path / ".env").write_text("ONSHAPE_SECRET_BEARER=from-file\n")
    assert find({}, tmp_path) == Credentials(kind="bearer", token="from-file")
    assert find(keys, tmp_path) == Credentials("a", "s")


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
def test_a_dotenv_that_others_can_read_gets_a_remark_with_the_command_to_paste(tmp_path, mode, who):
    (tmp_path / ".env").write_text("ONSHAPE_SECRET_KEY=hush-hush\n")
    (tmp_path / ".env").chmod(mode)
    found = remarks(tmp_path)
    assert [(one.code, one.where, one.hint) for one in found] == (
        [("I-DOTENV", ".env", "chmod 600 .env")] if who else []
    )
    assert all(who in one.message and "hush" not in one.message for one in found)


def test_a_dotenv_without_a_key_may_be_read_by_anyone(tmp_path):
    assert remarks(tmp_path) == ()
    (tmp_path / ".env").write_text("PORT=8000\n")
    (tmp_path / ".env").chmod(0o644)
    assert remarks(tmp_path) == ()


def test_signing_is_chosen_by_name(tmp_path):
    keys = {"ONSHAPE_ACCESS_KEY": "a", "ONSHAPE_SECRET_KEY": "s"}
    assert find({**keys, "ONSHAPE_AUTH": "Signature"}, tmp_path) == Credentials("a", "s", "signature")
    with pytest.raises(ConfigError, match="neither basic nor signature"):
        find({**keys, "ONSHAPE_AUTH": "oauth"}, tmp_path)


def test_a_ledgers_name_does_not_tell_the_key():
    key = Credentials("my-access", "my-secret")
    assert len(key.who) == 16
    assert key.who == Credentials("my-access", "another", "signature").who != Credentials("x", "y").who
    assert "access" not in key.who
    assert Credentials(kind="bearer", token="t").who == "bearer"


def test_neither_repr_nor_scrubbed_text_holds_the_key():
    key = Credentials("my-access", "my-secret")
    assert "my-" not in repr(key)
    header = "bXktYWNjZXNzOm15LXNlY3JldA=="
    assert key.scrub(f"my-access:my-secret Basic {header}") == "***:*** Basic ***"
    bearer = Credentials(kind="bearer", token="my-token")
    assert "my-" not in repr(bearer)
    assert bearer.scrub("Bearer my-token, and more") == "Bearer ***, and more"
