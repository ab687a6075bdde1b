"""The stage against a local Onshape: the calls it makes, what it keeps, and every kind of source."""

import io
import json
import zipfile
from pathlib import Path
from types import SimpleNamespace

import pytest
from pydantic import ValidationError

from linkwright.stages import fetch as stage
from linkwright.stages.fetch.section import FetchSections
from linkwright.stages.robot.errors import AssemblyError, ConfigError, NotFound, ProtocolError, SourceError
from tests.fake_onshape.bundle import bundle_bytes
from tests.fake_onshape.document import Document
from tests.fake_onshape.server import Fault, OnshapeServer
from tests.support.faulty import desk
from tests.support.kept import ADDRESS, Kept, fetched, onshape
from tests.support.recorded import kbot_bundle, needs_data
from tests.support.traffic import at_path


def zip_source(path):
    return SimpleNamespace(source=SimpleNamespace(kind="bundle", path=str(path)))


def test_a_cold_build_makes_one_call_and_two_a_studio():
    kept, lines = Kept(), []
    with OnshapeServer(desk(), latency_s=0.01) as server:
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


def test_a_recording_of_another_quality_is_what_there_is(tmp_path):
    fine = bundle_bytes(desk(), tessellation={"angleTolerance": 0.01, "chordTolerance": 1e-5})
    (tmp_path / "desk.zip").write_bytes(fine)
    studios = fetched(zip_source(tmp_path / "desk.zip")).bundle.studios
    assert all(studio.tessellation for studio in studios)


@pytest.mark.parametrize(
    "body", [b"", b'{"bodies": {', b"null", b"{}", b'{"bodies": 7}', b'{"message": "hello"}']
)
def test_a_reply_that_is_not_what_was_asked_for_is_not_kept(body):
    kept = Kept()
    with OnshapeServer(desk()) as server:
        server.fault = at_path(Fault(200, body), "/massproperties")
        with pytest.raises(ProtocolError) as caught:
            fetched(onshape(server.document_url()), kept, server.environ)
        # Each such reply is billed, so none is asked for more than twice.
        asked = [target for _, target, _ in server.calls]
        assert max(asked.count(target) for target in asked) == 2
        assert caught.value.where == server.url.removeprefix("http://")
    assert body not in kept.values()


def test_what_is_no_assembly_or_another_one_or_empty_is_reported():
    document, nothing = desk(), Document("Nothing")
    nothing.assembly("Nothing")
    with OnshapeServer(document) as server:
        root = document.root.element
        studio = document.studios[0].element
        with pytest.raises(SourceError, match=r"is no assembly, but perhaps a part studio or a drawing"):
            fetched(onshape(server.document_url(element=studio)), environ=server.environ)
        with pytest.raises(NotFound):
            fetched(onshape(server.document_url(element="f" * 24)), environ=server.environ)
        body = server.replies.answer(f"/assemblies/d/{document.id}/m/{document.microversion}/e/{root}").body
        server.fault = lambda *_: Fault(200, body)
        with pytest.raises(ProtocolError, match=r"where a{24} was asked for"):
            fetched(onshape(server.document_url(element="a" * 24)), environ=server.environ)
    with OnshapeServer(nothing) as server:
        with pytest.raises(AssemblyError, match="empty"):
            fetched(onshape(server.document_url()), environ=server.environ)
        assert server.count == 1


class TestBeforeTheFirstStage:
    @pytest.fixture(autouse=True)
    def _no_dotenv(self, tmp_path, monkeypatch):
        monkeypatch.chdir(tmp_path)

    def test_a_workspace_needs_a_key_and_a_pinned_address_may_not(self):
        with pytest.raises(ConfigError, match="ONSHAPE_ACCESS_KEY"):
            stage.preflight(onshape(ADDRESS), {})
        stage.preflight(onshape(ADDRESS), {"ONSHAPE_ACCESS_KEY": "a", "ONSHAPE_SECRET_KEY": "s"})
        pinned = onshape(ADDRESS.replace("/w/", "/v/"))
        stage.preflight(pinned, {})
        stage.preflight(onshape(ADDRESS, offline=True), {})
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
        assert stage.pinned(onshape(ADDRESS)) is None
        pinned = ADDRESS.replace("/w/", "/v/")
        keys = (
            onshape(pinned),
            onshape(pinned + "?configuration=x%3D1"),
            onshape(pinned, tessellation={"angle": 0.1}),
        )
        assert len({json.dumps(stage.pinned(key)) for key in keys}) == 3
        Path("a.zip").write_bytes(b"one")
        Path("b.zip").write_bytes(b"two")
        Path("c.zip").write_bytes(b"one")
        a, b, c = (stage.pinned(zip_source(name)) for name in ("a.zip", "b.zip", "c.zip"))
        assert a == c != b


class TestRecordings:
    """Zips that hold less than, or other than, a build of ours would record."""

    def edited(self, tmp_path, edit):
        out, data = io.BytesIO(), bundle_bytes(desk())
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

    def test_triangles_may_be_missing_but_masses_may_not(self, tmp_path):
        bundle = fetched(self.edited(tmp_path, self.without("/tessellatedfaces"))).bundle
        assert [studio.tessellation for studio in bundle.studios] == [None] * 3
        for edit, words in (
            (self.without("/massproperties"), "lacks the mass properties of part studio"),
            (lambda manifest: manifest["root"].update(element="0" * 24), "another assembly"),
        ):
            with pytest.raises(SourceError, match=words) as caught:
                fetched(self.edited(tmp_path, edit))
            assert caught.value.where.endswith("edited.zip")

    def test_a_definition_need_not_be_filed_under_a_request(self, tmp_path):
        bundle = fetched(self.edited(tmp_path, self.without("/assemblies/"))).bundle
        request = next(request for request in bundle.requests if request.startswith("/assemblies/"))
        assert f"/m/{bundle.root['microversion']}/" in request

    def test_a_reply_that_is_no_reply_names_the_file(self, tmp_path):
        def edit(manifest):
            masses = (request for request in manifest["requests"] if "/massproperties" in request)
            manifest["requests"] |= dict.fromkeys(masses, manifest["definition"])

        with pytest.raises(ProtocolError, match="has no bodies") as caught:
            fetched(self.edited(tmp_path, edit))
        assert caught.value.where.endswith("edited.zip")


def test_the_sample_is_a_complete_bundle_and_needs_no_network():
    keys = FetchSections.model_validate({"source": {"kind": "sample"}})
    stage.preflight(keys, {})
    outcome = fetched(keys)
    assert all(len(studio.mass) == 1 and studio.tessellation for studio in outcome.bundle.studios)
    assert (outcome.calls, outcome.saved, len(stage.pinned(keys)["sha256"])) == (0, 0, 64)


@needs_data
def test_replies_recorded_part_by_part_are_a_bundle_without_triangles(tmp_path):
    (tmp_path / "kbot.zip").write_bytes(kbot_bundle())
    bundle = fetched(zip_source(tmp_path / "kbot.zip")).bundle
    assert sum(len(studio.mass) for studio in bundle.studios) == 108
    assert all(studio.tessellation is None for studio in bundle.studios)
