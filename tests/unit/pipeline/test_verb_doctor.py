"""What `linkwright doctor` says of a computer, row by row."""

import json

import pytest

from linkwright.pipeline.doctor import access, installation, places
from linkwright.pipeline.json_documents.document import text_of
from linkwright.pipeline.verbs import doctor
from tests.fake_onshape.faults import Fault
from tests.fake_onshape.sample import sample_document
from tests.fake_onshape.server import OnshapeServer

ALLOWED = Fault(body=b'{"items": []}')


def rows(capsys, *arguments, environ=None):
    document = doctor.run([*arguments, "--json"], environ or {})
    answer = json.loads(text_of(document))
    assert answer["works"] == (document.exit_status == 0)
    return {row["subject"]: row for row in answer["examined"]}


@pytest.fixture(autouse=True)
def elsewhere(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def test_a_sound_computer_works(capsys, tmp_path):
    assert doctor.run([f"cache.dir={tmp_path / 'cache'}"], {}) == 0
    text = capsys.readouterr().out
    assert text.splitlines()[-1] == "everything that builds need works"
    assert str(tmp_path / "cache") in text
    assert not (tmp_path / "cache").exists()


def test_each_extra_has_a_row_and_a_purpose():
    extras = {
        extra for text in installation.requires("linkwright") for extra in installation._EXTRA.findall(text)
    }
    assert extras - set(installation.EXTRAS) <= {"suite", "test", "dev"}


def test_a_missing_package_is_wrong_and_a_missing_extra_a_note(monkeypatch, tmp_path):
    (tmp_path / "broken.py").write_text("raise ImportError('no libGL')")
    monkeypatch.setattr(installation, "_PROBE", "broken")
    real, other = installation.installed, {"trimesh": "absent", "usd-core": "absent", "numpy": "1.0"}
    monkeypatch.setattr(installation, "installed", lambda name: other.get(name) or real(name))
    row_of = {row.subject: row for row in installation.examine()}
    assert row_of["packages"].state == "wrong"
    assert "trimesh is not installed" in row_of["packages"].detail
    assert "numpy is 1.0, accepted is >=2.0,<3" in row_of["packages"].detail
    assert (row_of["extra usd"].state, row_of["extra usd"].hint) == (
        "note",
        "pip install 'usd-core>=26.3,<27'",
    )
    assert (row_of["mujoco"].state, row_of["mujoco"].detail) == (
        "wrong",
        "it does not run: ImportError: no libGL",
    )


@pytest.mark.parametrize(("environ", "subject", "state", "part"), [
    ({}, "key", "note", "ONSHAPE_ACCESS_KEY and ONSHAPE_SECRET_KEY not set"),
    ({"ONSHAPE_ACCESS_KEY": "a" * 24}, "key", "wrong", "ONSHAPE_SECRET_KEY not set"),
    ({"ONSHAPE_ACCESS_KEY": "a" * 24, "ONSHAPE_SECRET_KEY": "b" * 48}, "key", "ok", "0 calls counted"),
    ({"HTTPS_PROXY": "ftp://me:secret-word@there"}, "network", "wrong", "not the address of a proxy"),
    ({"HTTPS_PROXY": "http://me:secret-word@there:80"}, "network", "ok", "a proxy, from HTTPS_PROXY"),
    ({"SSL_CERT_FILE": "lost.pem"}, "network", "wrong", "lost.pem is not a file"),
])  # fmt: skip
def test_settings_of_the_access(environ, subject, state, part, capsys):
    row = rows(capsys, environ=environ)[subject]
    assert row["state"] == state
    assert part in row["detail"]
    assert not any(secret in json.dumps(row) for secret in ("secret-word", "a" * 24, "b" * 48))


@pytest.mark.parametrize(("fault", "state", "part"), [
    (ALLOWED, "ok", "the key may read documents"),
    (Fault(status=403, body=b"{}"), "wrong", ""),
    (None, "wrong", ""),
])  # fmt: skip
def test_onshape_is_asked_by_a_single_call(fault, state, part, capsys, tmp_path):
    with OnshapeServer(sample_document(), fault=lambda *_: fault) as server:
        environ = server.environ if fault else server.environ | {"ONSHAPE_SECRET_KEY": "wrong" * 10}
        url = f"source.url={server.document_url()}"
        assert rows(capsys, url, environ=environ)["onshape"]["state"] == "note"
        assert server.calls == []
        row = rows(capsys, "--online", url, f"cache.dir={tmp_path}", environ=environ)["onshape"]
        assert len(server.calls) == 1
    assert row["state"] == state
    assert part in row["detail"]
    if fault is ALLOWED:
        assert "1 call counted" in rows(capsys, f"cache.dir={tmp_path}", environ=environ)["key"]["detail"]


def test_a_folder_that_cannot_be_written_to_is_wrong(tmp_path):
    (tmp_path / "file").write_text("")
    cache, *_ = places.examine({}, tmp_path / "file" / "cache")
    assert cache.state == "wrong"
    assert "cannot be written to" in cache.detail


@pytest.mark.parametrize("system", ["linux", "darwin"])
def test_only_linux_needs_a_display_to_be_named(system):
    assert places.has_display({}, system) == (system == "darwin")
    assert places.has_display({"WAYLAND_DISPLAY": "wayland-0"}, system)


@pytest.mark.parametrize("argument", ["--offline", "key=1", "cache.dir="])
def test_another_argument_or_host_is_an_error(argument):
    with pytest.raises(doctor.ConfigError, match="there is no"):
        doctor.run([argument], {})
    with pytest.raises(doctor.ConfigError, match="no key is sent elsewhere"):
        list(access.examine({}, places.Path(), "https://example.org/documents/" + "a" * 24, online=True))
