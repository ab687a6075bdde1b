"""The stage against a local Onshape: the calls it makes, what it keeps, and every kind of source."""

import io
import json
import zipfile
from pathlib import Path
from types import SimpleNamespace

import pytest
from pydantic import ValidationError

from linkwright.stages import fetch as stage
from linkwright.stages.fetch.bundle.archive import pack
from linkwright.stages.fetch.section import FetchSections
from linkwright.stages.robot.errors import AssemblyError, ConfigError, NotFound, ProtocolError, SourceError
from tests.fake_onshape import solids
from tests.fake_onshape.bundle import bundle_bytes
from tests.fake_onshape.document import Document
from tests.fake_onshape.server import Fault, OnshapeServer
from tests.support.kept import Kept, fetched, onshape
from tests.support.recorded import kbot_bundle, needs_data


def two_studios():
    """Three part studios (one in a linked document), four parts, a suppressed instance."""
    document = Document("Desk")
    wood, steel = document.studio("Wood"), document.studio("Steel")
    bolts = document.library("Bolts").studio("Bolts")
    desk = document.assembly("Desk")
    desk.add(wood.part("Top", solids.box(1, 0.5, 0.02), density=700), fixed=True)
    desk.add(wood.part("Leg", solids.box(0.05, 0.05, 0.7), density=700))
    desk.add(steel.part("Plate", solids.box(0.1, 0.1, 0.005), density=7800))
    desk.add(bolts.part("M5", solids.cylinder(0.0025, 0.02), density=7800))
    unused = document.studio("Unused").part("Old", solids.box(1, 1, 1))
    desk.add(unused, suppressed=True)
    return document


def zip_source(path):
    return SimpleNamespace(source=SimpleNamespace(kind="bundle", path=str(path)))


def test_a_cold_build_makes_one_call_and_two_a_studio_and_then_only_what_can_change():
    kept, lines = Kept(), []
    with OnshapeServer(two_studios(), latency_s=0.01) as server:
        keys = onshape(server.document_url())
        cold = fetched(keys, kept, server.environ, lines)
        assert (cold.calls, cold.saved, server.count) == (7, 0, 7)
        assert 2 <= server.most_at_once <= 4
        assert "3 part studios: 6 calls, 0 kept" in lines
        again = fetched(keys, kept, server.environ)
        assert (again.calls, again.saved, server.count) == (1, 7, 8)
        assert again.bundle == cold.bundle
        assert len(kept) == 7
        assert all("/w/" not in request for request in kept)


@pytest.mark.parametrize("kind", ["v", "m"])
def test_a_pinned_address_costs_nothing_again_and_needs_no_key(kind):
    kept = Kept()
    with OnshapeServer(two_studios()) as server:
        keys = onshape(server.document_url(kind))
        assert fetched(keys, kept, server.environ).calls == 7
        again = fetched(keys, kept)
        assert (again.calls, again.saved, server.count) == (0, 7, 7)


def test_the_bundle_of_a_server_is_the_bundle_of_its_recording(tmp_path):
    document = two_studios()
    with OnshapeServer(document) as server:
        live = fetched(onshape(server.document_url()), environ=server.environ).bundle
    (tmp_path / "desk.zip").write_bytes(bundle_bytes(document))
    replayed = fetched(zip_source(tmp_path / "desk.zip"))
    assert replayed.bundle == live
    assert (replayed.calls, replayed.saved) == (0, 0)
    (tmp_path / "packed.zip").write_bytes(pack(live))
    assert fetched(zip_source(tmp_path / "packed.zip")).bundle == live


def test_a_recording_of_another_quality_is_what_there_is(tmp_path):
    fine = bundle_bytes(two_studios(), tessellation={"angleTolerance": 0.01, "chordTolerance": 1e-5})
    (tmp_path / "desk.zip").write_bytes(fine)
    studios = fetched(zip_source(tmp_path / "desk.zip")).bundle.studios
    assert all(studio.tessellation for studio in studios)


@pytest.mark.parametrize("broken", range(7))
def test_what_arrived_before_a_failure_is_kept_and_not_paid_for_again(broken):
    kept = Kept()
    with OnshapeServer(two_studios()) as server:
        keys = onshape(server.document_url("m"))
        server.fault = lambda method, path, number: (
            Fault(406, b'{"message": "Request not acceptable."}')
            if number == broken or "/gltf" in path
            else None
        )
        with pytest.raises(ProtocolError, match="Request not acceptable"):
            fetched(keys, kept, server.environ)
        paid = server.count
        assert len(kept) == paid
        server.fault = None
        again = fetched(keys, kept, server.environ)
        assert (again.calls, again.saved) == (7 - paid, paid)


@pytest.mark.parametrize(
    "body", [b"", b'{"bodies": {', b"null", b"{}", b'{"bodies": 7}', b'{"message": "hello"}']
)
def test_a_reply_that_is_not_what_was_asked_for_is_not_kept(body):
    kept = Kept()
    with OnshapeServer(two_studios()) as server:
        server.fault = lambda method, path, number: Fault(200, body) if "/massproperties" in path else None
        with pytest.raises(ProtocolError) as caught:
            fetched(onshape(server.document_url()), kept, server.environ)
        # Each such reply is billed, so none is asked for more than twice.
        asked = [target for _, target, _ in server.calls]
        assert max(asked.count(target) for target in asked) == 2
        assert caught.value.where == server.url.removeprefix("http://")
    assert body not in kept.values()


def test_a_part_studio_instead_of_an_assembly_is_reported():
    document = two_studios()
    with OnshapeServer(document) as server:
        keys = onshape(server.document_url(element=document.studios[0].element))
        with pytest.raises(SourceError, match=r"not be an assembly \(a part studio or a drawing\?\)"):
            fetched(keys, environ=server.environ)
        with pytest.raises(NotFound):
            fetched(onshape(server.document_url(element="f" * 24)), environ=server.environ)


def test_an_empty_assembly_is_reported_after_one_call():
    document = Document("Nothing")
    document.assembly("Nothing")
    with OnshapeServer(document) as server:
        with pytest.raises(AssemblyError, match="empty"):
            fetched(onshape(server.document_url()), environ=server.environ)
        assert server.count == 1


def test_a_definition_of_another_assembly_is_refused():
    other = Document("Other")
    other.assembly("Other").add(other.studio("S").part("P", solids.box(1, 1, 1)))
    with OnshapeServer(other) as server:
        body = server.replies.answer(
            f"/assemblies/d/{other.id}/m/{other.microversion}/e/{other.root.element}"
        ).body
        server.fault = lambda *_: Fault(200, body)
        url = server.document_url(element="a" * 24)
        with pytest.raises(ProtocolError, match=r"where a{24} was asked for"):
            fetched(onshape(url), environ=server.environ)


def test_no_secret_shows_in_progress_or_errors():
    lines = []
    with OnshapeServer(two_studios(), keys=("acc-ess", "sec-ret")) as server:
        wrong = {"ONSHAPE_ACCESS_KEY": "wrong-one", "ONSHAPE_SECRET_KEY": "wrong-two"}
        with pytest.raises(SourceError) as caught:
            fetched(onshape(server.document_url()), environ=wrong, lines=lines)
        fetched(onshape(server.document_url()), environ=server.environ, lines=lines)
    text = " ".join(lines) + repr(caught.value)
    assert lines
    assert not any(secret in text for secret in ("wrong-one", "wrong-two", "acc-ess", "sec-ret"))


class TestBeforeTheFirstStage:
    URL = f"https://cad.onshape.com/documents/{'a' * 24}/w/{'b' * 24}/e/{'c' * 24}"

    @pytest.fixture(autouse=True)
    def _no_dotenv(self, tmp_path, monkeypatch):
        monkeypatch.chdir(tmp_path)

    def test_a_workspace_needs_a_key_and_a_pinned_address_may_not(self):
        with pytest.raises(ConfigError, match="ONSHAPE_ACCESS_KEY"):
            stage.preflight(onshape(self.URL), {})
        stage.preflight(onshape(self.URL), {"ONSHAPE_ACCESS_KEY": "a", "ONSHAPE_SECRET_KEY": "s"})
        pinned = onshape(self.URL.replace("/w/", "/v/"))
        stage.preflight(pinned, {})
        stage.preflight(onshape(self.URL, offline=True), {})
        with pytest.raises(ConfigError, match="ONSHAPE_ACCESS_KEY"):
            fetched(pinned)

    def test_a_malformed_address_and_a_missing_file_are_reported(self):
        with pytest.raises(ValidationError, match="24 hex"):
            onshape("https://cad.onshape.com/x")
        with pytest.raises(ConfigError, match=r"arm\.zip does not exist"):
            stage.preflight(zip_source("arm.zip"), {})
        Path("folder").mkdir()
        with pytest.raises(ConfigError, match="is a folder"):
            stage.preflight(zip_source("folder"), {})

    def test_what_can_change_has_no_identity_and_what_cannot_has_one(self):
        assert stage.pinned(onshape(self.URL)) is None
        version = onshape(self.URL.replace("/w/", "/v/"))
        other = onshape(self.URL.replace("/w/", "/v/") + "?configuration=x%3D1")
        finer = onshape(self.URL.replace("/w/", "/v/"), tessellation={"angle": 0.1})
        identities = [json.dumps(stage.pinned(keys)) for keys in (version, other, finer)]
        assert len(set(identities)) == 3
        Path("a.zip").write_bytes(b"one")
        Path("b.zip").write_bytes(b"two")
        Path("c.zip").write_bytes(b"one")
        a, b, c = (stage.pinned(zip_source(name)) for name in ("a.zip", "b.zip", "c.zip"))
        assert a == c != b


class TestRecordings:
    """Zips that hold less than, or other than, a build of ours would record."""

    def edited(self, tmp_path, edit):
        out, data = io.BytesIO(), bundle_bytes(two_studios())
        with zipfile.ZipFile(io.BytesIO(data)) as old, zipfile.ZipFile(out, "w") as new:
            for name in old.namelist():
                body = old.read(name)
                if name == "manifest.json":
                    manifest = json.loads(body)
                    edit(manifest)
                    body = json.dumps(manifest).encode()
                new.writestr(name, body)
        (tmp_path / "edited.zip").write_bytes(out.getvalue())
        return zip_source(tmp_path / "edited.zip")

    @staticmethod
    def without(word):
        def edit(manifest):
            manifest["requests"] = {r: d for r, d in manifest["requests"].items() if word not in r}

        return edit

    def test_missing_triangles_are_none(self, tmp_path):
        bundle = fetched(self.edited(tmp_path, self.without("/tessellatedfaces"))).bundle
        assert [studio.tessellation for studio in bundle.studios] == [None] * 3

    def test_missing_mass_is_an_error_that_names_the_studio(self, tmp_path):
        with pytest.raises(SourceError, match="lacks the mass properties of part studio") as caught:
            fetched(self.edited(tmp_path, self.without("/massproperties")))
        assert caught.value.where.endswith("edited.zip")

    def test_a_definition_that_is_not_the_named_one_is_refused(self, tmp_path):
        with pytest.raises(SourceError, match="another assembly"):
            fetched(self.edited(tmp_path, lambda manifest: manifest["root"].update(element="0" * 24)))

    def test_a_definition_need_not_be_filed_under_a_request(self, tmp_path):
        bundle = fetched(self.edited(tmp_path, self.without("/assemblies/"))).bundle
        request = next(request for request in bundle.requests if request.startswith("/assemblies/"))
        assert f"/m/{bundle.root['microversion']}/" in request

    def test_a_reply_that_is_no_reply_names_the_file(self, tmp_path):
        def edit(manifest):
            manifest["requests"] = {
                r: manifest["definition"] if "/massproperties" in r else d
                for r, d in manifest["requests"].items()
            }

        with pytest.raises(ProtocolError, match="has no bodies") as caught:
            fetched(self.edited(tmp_path, edit))
        assert caught.value.where.endswith("edited.zip")


def test_the_sample_is_a_complete_bundle_and_needs_no_network():
    keys = FetchSections.model_validate({"source": {"kind": "sample"}})
    stage.preflight(keys, {})
    found = fetched(keys)
    assert (found.calls, found.saved) == (0, 0)
    assert found.bundle.studios
    assert all(len(studio.mass) == 1 and studio.tessellation for studio in found.bundle.studios)
    assert len(stage.pinned(keys)["sha256"]) == 64


@needs_data
def test_replies_recorded_part_by_part_are_a_bundle_without_triangles(tmp_path):
    (tmp_path / "kbot.zip").write_bytes(kbot_bundle())
    bundle = fetched(zip_source(tmp_path / "kbot.zip")).bundle
    assert sum(len(studio.mass) for studio in bundle.studios) == 108
    assert all(studio.tessellation is None for studio in bundle.studios)
