"""The stage against a local Onshape: what it asks for, keeps and refuses; and every kind of source."""

import ast
import io
import json
import zipfile
from dataclasses import replace
from pathlib import Path

import pytest
from pydantic import ValidationError

from linkwright.stages import fetch as stage
from linkwright.stages.fetch import sources
from linkwright.stages.fetch.bundle.archive import pack
from linkwright.stages.fetch.onshape.gather import digest
from linkwright.stages.fetch.section import SOURCES
from linkwright.stages.formats import triangles
from linkwright.stages.formats.meshes import body_arrays
from linkwright.stages.robot.errors import (
    AssemblyError,
    ConfigError,
    NotFound,
    Offline,
    ProtocolError,
    SourceError,
)
from tests.fake_onshape import solids
from tests.fake_onshape.bundle import bundle_bytes
from tests.fake_onshape.document import Document
from tests.fake_onshape.server import Fault, OnshapeServer
from tests.support.faulty import desk
from tests.support.kept import ADDRESS, Kept, fetched, onshape, recording
from tests.support.places import PROJECT
from tests.support.traffic import at_path, targets_of


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


@pytest.mark.parametrize(
    "body", [b"", b'{"bodies": {', b"null", b"{}", b'{"bodies": 7}', b'{"message": "hello"}']
)
def test_a_reply_that_is_not_what_was_asked_for_is_not_kept(body, kept):
    with OnshapeServer(desk()) as server:
        server.fault = at_path(Fault(200, body), "/massproperties")
        with pytest.raises(ProtocolError) as caught:
            fetched(onshape(server.document_url()), kept, server.environ)
        # Each such reply is billed, so none is asked for more than twice.
        asked = [target for _, target, _ in server.calls]
        assert max(asked.count(target) for target in asked) == 2
        assert caught.value.where == server.url.removeprefix("http://")
    assert body not in kept.values()


def test_a_wrong_or_an_empty_assembly_is_reported():
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
            stage.preflight(recording("arm.zip"), {})
        Path("folder").mkdir()
        with pytest.raises(ConfigError, match="is a folder"):
            stage.preflight(recording("folder"), {})

    def test_a_source_that_cannot_change_has_an_identity(self):
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
        a, b, c = (stage.pinned(recording(name)) for name in ("a.zip", "b.zip", "c.zip"))
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
        return recording(tmp_path / "edited.zip")

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


FETCH = PROJECT / "stages" / "fetch"


def test_a_source_has_its_keys_and_its_preset():
    assert list(SOURCES) == list(sources.SOURCES)
    presets = {path.stem for path in (PROJECT / "conf" / "source").glob("*.yaml")}
    assert presets == set(SOURCES)
    for kind, keys in SOURCES.items():
        assert keys.model_fields["kind"].default == kind
        assert sources.source_class(kind).__module__ == keys.__module__.replace(".section", ".source")


@pytest.mark.parametrize("room", ["onshape", "urdf", "mjcf", "bundle"])
def test_a_room_of_sources_imports_no_other(room):
    rooms = {"onshape", "urdf", "mjcf", "bundle"} - {room}
    for path in (FETCH / room).rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.ImportFrom | ast.Import):
                names = [getattr(node, "module", None) or "", *(alias.name for alias in node.names)]
                pieces = [name.removeprefix("linkwright.").split(".") for name in names]
                assert not [p for p in pieces if p[:2] == ["stages", "fetch"] and rooms & {*p[2:3]}], path


EMPTY = {"massproperties": [b'{"bodies":{}}'], "tessellatedfaces": [b"[]", b'{"bodies":[]}']}
CASES = [(kind, body) for kind, bodies in EMPTY.items() for body in bodies]


@pytest.fixture
def server():
    document = Document("Pair")
    studio, root = document.studio("Pair"), document.assembly("Pair")
    root.add(studio.part("One", solids.box(0.1, 0.1, 0.1), density=1000), fixed=True)
    root.add(studio.part("Two", solids.box(0.2, 0.1, 0.1), density=1000))
    with OnshapeServer(document) as server:
        yield server


def instead(server, kind, body, times=99):
    """Replies of this kind are `body`, so many `times`."""
    left = [Fault(200, body)] * times
    server.fault = lambda method, path, number: left.pop() if f"/{kind}?" in path and left else None


def build(server, kept, pin="m", **keys):
    server.reset()
    return fetched(onshape(server.document_url(pin), **keys), kept, server.environ)


@pytest.mark.parametrize(("kind", "body"), CASES)
def test_an_empty_reply_is_asked_for_twice_and_refused(server, kind, body):
    for pin in "mw":
        right, kept = build(server, Kept(), pin), Kept()
        instead(server, kind, body, times=1)
        made = build(server, kept, pin)
        assert (made.calls, made.bundle) == (4, right.bundle)
    right, kept = build(server, Kept()), Kept()
    instead(server, kind, body)
    with pytest.raises(ProtocolError, match=r"source.refresh=true is not needed") as caught:
        build(server, kept)
    assert len(targets_of(server, f"/{kind}?")) == 2
    studio = server.document.studios[0]
    for name in (*(part.id for part in studio.parts), studio.element):
        assert name in caught.value.message
    assert not any(f"/{kind}?" in request for request in kept)
    server.fault = None
    assert build(server, kept).bundle == right.bundle


@pytest.mark.parametrize("kind", EMPTY)
def test_a_reply_that_lacks_one_part_names_that_one(server, kind, kept):
    second = server.document.studios[0].parts[1]
    build(server, kept)
    request = next(request for request in kept if f"/{kind}?" in request)
    body = json.loads(server.replies.answer(*request.split("?")).body)
    if kind == "massproperties":
        del body["bodies"][second.id]
    else:
        body["bodies"] = [record for record in body["bodies"] if record["id"] != second.id]
    instead(server, kind, json.dumps(body).encode())
    with pytest.raises(ProtocolError, match=f"lack the parts {second.id};"):
        build(server, Kept())


@pytest.mark.parametrize("kind", EMPTY)
def test_an_incomplete_reply_that_was_kept_is_as_none(server, kind, kept):
    right = build(server, kept)
    request = next(request for request in kept if f"/{kind}?" in request)
    lacking = body_arrays.encode([]) if kind == "tessellatedfaces" else EMPTY[kind][0]
    kept[request] = lacking
    with pytest.raises(Offline, match="1 reply is not in the cache"):
        build(server, kept, offline=True)
    made = build(server, kept)
    assert (made.calls, made.bundle) == (1, right.bundle)
    assert kept[request] != lacking
    assert build(server, kept).calls == 0


def test_incomplete_replies_of_before_are_not_taken_over(server, kept):
    build(server, kept, "w")
    for request in list(kept):
        if "/tessellatedfaces?" in request:
            kept[request] = body_arrays.encode([])
    server.edit(server.document.edited("Pair"))
    made = build(server, kept, "w")
    body = made.bundle.body(made.bundle.studios[0].tessellation)
    assert triangles.ids_with_triangles(body) == {part.id for part in server.document.studios[0].parts}


def test_a_solid_without_volume_may_lack_triangles(server, kept):
    build(server, kept)
    first, second = server.document.studios[0].parts
    mass = next(request for request in kept if "/massproperties?" in request)
    faces = next(request for request in kept if "/tessellatedfaces?" in request)
    flat = json.loads(kept[mass])
    flat["bodies"][second.id]["volume"] = [0.0, 0.0, 0.0]
    kept[mass] = json.dumps(flat).encode()
    kept[faces] = body_arrays.encode([body_arrays.decode(kept[faces])[first.id]])
    assert build(server, kept).calls == 0


def test_a_recording_may_lack_triangles(server, tmp_path):
    bundle = build(server, Kept()).bundle
    (studio,) = bundle.studios
    empty = body_arrays.encode([])
    renamed = {studio.tessellation: digest(empty)}
    blobs = {name: bundle.blobs[name] for name in bundle.blobs if name not in renamed}
    lacking = replace(
        bundle,
        studios=(replace(studio, tessellation=digest(empty)),),
        requests={request: renamed.get(name, name) for request, name in bundle.requests.items()},
        blobs=blobs | {digest(empty): empty},
    )
    path = tmp_path / "pair.zip"
    path.write_bytes(pack(lacking))
    assert fetched(recording(path)).bundle == lacking
