"""What a build costs after the document stayed, changed, or changed unseen."""

import json

import pytest

from linkwright.stages import fetch as stage
from linkwright.stages.fetch.source import Calls
from linkwright.stages.robot.errors import ConfigError, Offline, ProtocolError, QuotaExhausted, SourceError
from tests.fake_onshape import solids
from tests.fake_onshape.document import Document
from tests.fake_onshape.server import Fault, OnshapeServer
from tests.support.kept import ADDRESS, Kept, fetched, onshape
from tests.support.traffic import asked_kinds, at_call, at_path

COLD = 1 + 2 * 5
MASS = ("/assemblies/", "/massproperties")


def cupboard():
    """Four studios of its own and a linked one, ten instances; a hinge without material, one hidden."""
    document = Document("Cupboard")
    bolts = document.library("Bolts").studio("Bolts")
    root = document.assembly("Cupboard")
    for index, name in enumerate(("Wood", "Steel", "Glass", "Copy of wood")):
        studio = document.studio(name)
        part = studio.part(f"{name} part", solids.box(0.1 + index / 50, 0.2, 0.02), density=500 * index + 700)
        root.add(part, fixed=index == 0)
        root.add(part, hidden=index == 2)
    root.add(document.studios[0].part("Hinge", solids.box(0.01, 0.01, 0.01)))
    root.add(bolts.part("M5", solids.cylinder(0.0025, 0.02), density=7800))
    return document


def resized(document, name, *tabs):
    """The document after an edit of a part's size, which tells only of changes in `tabs`."""
    after = document.edited(*tabs)
    after.part(name).solid = solids.box(0.3, 0.31, 0.02 * len(after.microversion[:3]))
    return after


def edit(server, name):
    """Edits the size of the part of a part studio."""
    server.edit(resized(server.document, f"{name} part", name))


def edit_unseen(server):
    """An edit that changes two studios, one of which does not tell."""
    edit(server, "Wood")
    server.document.part("Copy of wood part").solid = solids.box(0.3, 0.3, 0.3)


@pytest.fixture
def server():
    with OnshapeServer(cupboard()) as server:
        yield server


@pytest.fixture
def built(server, kept):
    """The workspace was built before."""
    return build(server, kept)


def build(server, kept, lines=None, **keys):
    """A build of the workspace; asserts that what it says it spent is what the server counted."""
    server.reset()
    made = fetched(onshape(server.document_url(), **keys), kept, server.environ, lines)
    assert made.calls == server.count
    return made


def build_fails(server, kept, error=SourceError, match=None, **keys):
    with pytest.raises(error, match=match) as caught:
        build(server, kept, **keys)
    return caught.value


def same_as_cold(server, bundle):
    """Whether a bundle leads to the geometry and masses that a first build would find."""
    cold = fetched(onshape(server.document_url()), Kept(), server.environ).bundle
    assert sorted(cold.requests) == sorted(bundle.requests)
    return all(
        strip(bundle.blobs[digest]) == strip(cold.blobs[cold.requests[request]])
        for request, digest in bundle.requests.items()
    )


def strip(body):
    """A reply without the microversion that it was asked at."""
    if body[:1] not in b"[{":
        return body
    data = json.loads(body)
    data.pop("microversionId", None)
    return data


def test_the_title_of_an_assembly_costs_no_call(server, kept):
    assert [build(server, kept).title for _ in range(2)] == ["", ""]
    edit(server, "Steel")
    titles = [build(server, kept, offline=offline).title for offline in (False, False, True)]
    assert titles == ["Cupboard"] * 3
    server.document.root.name = "Wardrobe"
    edit(server, "Glass")
    assert build(server, kept).title == "Wardrobe"


def test_an_unchanged_workspace_costs_one_call(server, kept, built):
    assert (built.calls, built.saved) == (COLD, 0)
    again = build(server, kept, max_calls=1)
    assert (again.calls, again.saved) == (1, COLD)
    assert asked_kinds(server) == {"currentmicroversion": 1}
    assert again.bundle == built.bundle


def test_an_edit_of_a_part_costs_seven_calls_and_then_six(server, kept, built):
    lines = []
    edit(server, "Steel")
    first = build(server, kept, lines)
    assert asked_kinds(server) == {
        "currentmicroversion": 1, "definition": 1, "elements": 2, "massproperties": 2, "tessellatedfaces": 1,
    }  # fmt: skip
    assert (first.calls, first.diagnostics) == (7, ())
    assert lines[0] == "asking whether the document changed"
    assert "5 part studios: 3 calls, 8 kept" in lines
    assert same_as_cold(server, first.bundle)
    # The new microversion needs no call and no key.
    pinned = fetched(onshape(server.document_url("m")), kept)
    assert (pinned.calls, pinned.saved, pinned.bundle) == (0, COLD, first.bundle)
    edit(server, "Glass")
    second = build(server, kept)
    assert second.calls == 6
    assert same_as_cold(server, second.bundle)
    assert build(server, kept).calls == 1


def test_an_edit_of_the_assembly_alone_costs_five_calls(server, kept, built):
    server.edit(server.document.edited("Cupboard"))
    assert build(server, kept).calls == 5
    assert "tessellatedfaces" not in asked_kinds(server)


def test_two_edits_between_builds_are_one(server, kept, built):
    edit(server, "Steel")
    edit(server, "Glass")
    made = build(server, kept)
    assert made.calls == 5 + 2 * 2
    assert same_as_cold(server, made.bundle)


def test_a_single_studio_is_asked_for_without_its_tabs(kept):
    document = Document("One")
    part = document.studio("S").part("P", solids.box(0.1, 0.1, 0.1), density=1000)
    document.assembly("One").add(part)
    with OnshapeServer(document) as server:
        assert build(server, kept).calls == 3
        server.edit(resized(document, "P", "S"))
        assert build(server, kept).calls == 4
        assert "elements" not in asked_kinds(server)


class TestVerify:
    def test_an_unseen_change_is_found_by_the_assemblys_mass(self, server, kept, built):
        edit_unseen(server)
        lines = []
        made = build(server, kept, lines)
        # Three studios of this document kept their microversion; the linked one cannot have changed.
        assert (made.calls, made.diagnostics) == (7 + 2 * 3, ())
        assert any("changed through one" in line for line in lines)
        assert same_as_cold(server, made.bundle)
        assert build(server, kept).calls == 1

    def test_an_unseen_change_is_not_found_without_verify(self, server, kept, built):
        edit_unseen(server)
        made = build(server, kept, verify=False)
        assert made.calls == 6
        assert not same_as_cold(server, made.bundle)
        assert build(server, kept, verify=False).calls == 1
        made = build(server, kept)
        assert made.calls == 1 + 1 + 2 * 3
        assert same_as_cold(server, made.bundle)
        assert build(server, kept).calls == 1

    def test_an_unexplained_mass_is_reported_each_time(self, server, kept, built):
        edit(server, "Steel")
        server.fault = at_path(Fault(200, b'{"mass": [123.5, 123.4, 123.6], "hasMass": true}'), *MASS)
        first, again = build(server, kept), build(server, kept)
        assert (first.calls, again.calls) == (7 + 2 * 3, 1)
        for made in (first, again, fetched(onshape(server.document_url("m")), kept)):
            (diagnostic,) = made.diagnostics
            assert diagnostic.code == "W-VERIFY"
            assert "123.5 kg" in diagnostic.message
            assert f"{server.document.truth.total_mass():.6g}" in diagnostic.message
            assert server.document.root.element in diagnostic.where

    def test_a_lasting_difference_is_asked_for_once(self, server, kept, built):
        def overridden(method, path, number):
            total = server.document.truth.total_mass() + 1
            return at_path(Fault(200, b'{"mass": [%r]}' % total), *MASS)(method, path, number)

        edit(server, "Steel")
        server.fault = overridden
        assert build(server, kept).calls == 7 + 2 * 3
        for name in ("Glass", "Wood"):
            edit(server, name)
            made = build(server, kept)
            assert made.calls == 6
            assert same_as_cold(server, made.bundle)
            (diagnostic,) = made.diagnostics
            assert diagnostic.code == "W-VERIFY"
            assert "the difference was the same" in diagnostic.message
            assert build(server, kept).calls == 1
        edit(server, "Steel")
        server.document.part("Copy of wood part").solid = solids.box(0.3, 0.3, 0.3)
        made = build(server, kept)
        assert made.calls == 6 + 2 * 3
        assert same_as_cold(server, made.bundle)

    @pytest.mark.parametrize(
        ("fault", "billed"),
        [
            *((Fault(status), 0) for status in (404, 400, 406, 500)),
            *((Fault(200, body), 1) for body in (b"{}", b'{"mass": ["much"')),
        ],
    )
    def test_a_mass_that_cannot_be_had_leaves_the_robot_unchecked(self, server, kept, built, fault, billed):
        edit_unseen(server)
        server.fault = at_path(fault, *MASS)
        for calls in (6, 1):
            made = build(server, kept)
            assert made.calls == calls + billed
            (diagnostic,) = made.diagnostics
            assert (diagnostic.code, diagnostic.where[:9]) == ("W-VERIFY", "assembly ")
            assert "could not be compared, so a cached part studio may be outdated" in diagnostic.message
        server.fault = None
        made = build(server, kept)
        assert (made.calls, made.diagnostics) == (1 + 1 + 2 * 3, ())
        assert same_as_cold(server, made.bundle)

    def test_an_end_before_the_mass_files_nothing_as_checked(self, server, kept, built):
        edit_unseen(server)
        server.fault = at_path(Fault(403), *MASS)
        build_fails(server, kept)
        server.fault = None
        made = build(server, kept)
        assert asked_kinds(server)["currentmicroversion"] == 1
        assert "elements" not in asked_kinds(server)
        assert made.calls == 1 + 1 + 2 * 3
        assert same_as_cold(server, made.bundle)

    @pytest.mark.parametrize("broken", range(7))
    def test_an_end_amid_stale_studios_mixes_no_states(self, server, kept, built, broken):
        edit_unseen(server)
        server.fault = at_call(Fault(403), 6 + broken)
        build_fails(server, kept)
        server.fault = None
        assert same_as_cold(server, build(server, kept).bundle)


class TestRefresh:
    def test_a_refresh_asks_for_everything_and_its_replies_stay(self, server, kept, built):
        # Metadata can change where no microversion does.
        server.document.part("Steel part").density = 9000
        server.replies = type(server.replies)(server.document)
        assert build(server, kept).bundle.blobs == built.bundle.blobs
        fresh = build(server, kept, refresh=True)
        assert (fresh.calls, fresh.saved) == (COLD, 0)
        again = build(server, kept)
        assert (again.calls, again.bundle) == (1, fresh.bundle)
        assert same_as_cold(server, again.bundle)

    def test_a_refresh_also_asks_for_what_is_pinned(self, server, kept):
        keys = onshape(server.document_url("v"), refresh=True)
        assert [fetched(keys, kept, server.environ).calls for _ in range(2)] == [COLD] * 2
        assert stage.force(keys)
        assert not stage.force(onshape(server.document_url("v")))

    def test_a_refresh_cannot_be_offline(self):
        with pytest.raises(ConfigError, match="offline allows no call"):
            stage.preflight(onshape(ADDRESS, refresh=True, offline=True), {})


class TestOffline:
    def test_the_last_complete_state_is_built_without_call_or_key(self, server, kept, built):
        lines = []
        edit(server, "Steel")
        for fault in (None, at_path(Fault(403), "/partstudios/")):
            if fault:  # a later state that was begun, and not finished
                server.fault = fault
                build_fails(server, kept)
            server.reset()
            made = fetched(onshape(server.document_url(), offline=True), kept, lines=lines)
            assert (made.calls, made.saved, len(server.calls)) == (0, COLD, 0)
            assert made.bundle == built.bundle
        assert lines == ["5 part studios: 0 calls, 10 kept"] * 2

    def test_a_workspace_that_was_never_built_is_reported(self, server, kept):
        lines = []
        error = build_fails(
            server, kept, Offline, "no cached state of the workspace", offline=True, lines=lines
        )
        assert "source.offline=false" in error.hint
        with pytest.raises(Offline, match="1 reply is not in the cache: the definition of assembly"):
            fetched(onshape(server.document_url("v"), offline=True), kept, lines=lines)
        assert server.calls == lines == []

    def test_missing_replies_are_named(self, server, kept, built):
        error = build_fails(server, kept, Offline, offline=True, tessellation={"angle": 0.01})
        assert "5 replies are not in the cache: the triangles of part studio" in error.message
        assert "and 2 more" in error.message
        assert error.hint.startswith("build once with source.offline=false (5 calls)")


class TestMostCalls:
    def test_a_build_that_needs_more_ends_before_it_spends_them(self, server, kept):
        error = build_fails(server, kept, max_calls=COLD - 1)
        assert (server.count, error.where) == (1, "source.max_calls")
        assert error.message == "this build made 1 call and needs 10 more, but source.max_calls is 10"
        assert f"source.max_calls={COLD}" in error.hint
        # The definition is kept; whether it is still the right one costs a question.
        assert build(server, kept, max_calls=COLD).calls == COLD

    def test_the_check_after_an_edit_counts_as_well(self, server, kept, built):
        edit(server, "Steel")
        build_fails(
            server, kept, match="made 1 call and needs 1 more, but source.max_calls is 1", max_calls=1
        )
        build_fails(
            server, kept, match="made 4 calls and needs 3 more, but source.max_calls is 6", max_calls=6
        )
        assert server.count == 4
        assert build(server, kept, max_calls=6).calls == 1 + 3


def test_a_failed_fetch_reports_what_it_spent(server, kept):
    spent = Calls()
    server.fault = at_call(Fault(403), 5)
    with pytest.raises(SourceError):
        fetched(onshape(server.document_url()), kept, server.environ, calls=spent)
    assert spent.made == server.count > 0
    assert spent.remaining["assembly definition"] < 1000


def test_the_plan_is_reported_behind_the_definition(server, kept):
    lines = []
    build(server, kept, lines)
    assert lines == ["asking for the assembly definition", "5 part studios: 10 calls, 0 kept"]


def test_a_tab_without_a_microversion_counts_as_changed(server, kept, built):
    server.edit(server.document.edited("Cupboard"))
    tabs = server.replies._elements
    server.replies._elements = lambda *asked: [{**tab, "microversionId": None} for tab in tabs(*asked)]
    made = build(server, kept)
    assert made.calls == 1 + 1 + 2 + 2 * 4
    assert same_as_cold(server, made.bundle)


@pytest.mark.parametrize("body", [b"[", b"{}", b"[1]", b'{"microversion": 7}'])
def test_a_wrong_answer_about_the_document_is_refused(server, kept, built, body):
    edit(server, "Steel")
    server.fault = at_path(Fault(200, body), "/documents/")
    build_fails(server, kept, ProtocolError)
    assert body not in kept.values()


@pytest.mark.parametrize("body", [b"[]", b'[{"id": "another", "microversionId": "m"}]'])
def test_tabs_without_the_assembly_are_asked_for_once_more(server, kept, built, body):
    edit(server, "Steel")
    server.fault = at_path(Fault(200, body), "/elements")
    lacking = f"lacks {server.document.root.element}, the tab of the assembly"
    build_fails(server, kept, ProtocolError, lacking)
    targets = [target for _, target, _ in server.calls if "/elements" in target]
    assert max(map(targets.count, targets)) == 2
    assert body not in kept.values()
    server.fault = None
    assert same_as_cold(server, build(server, kept).bundle)


def test_a_used_up_quota_leaves_the_last_complete_state(server, kept, built):
    edit(server, "Steel")
    server.fault = at_call(Fault(402), 2)
    for stale in (False, True):
        made = build(server, kept, stale=stale)
        assert (made.bundle, made.stale) == (built.bundle, not stale)
        (diagnostic,) = made.diagnostics
        assert diagnostic.code == "W-QUOTA"
        assert ("source.stale=true" in diagnostic.hint) != stale
    server.fault = lambda *_: Fault(402)
    build_fails(server, Kept(), QuotaExhausted)
