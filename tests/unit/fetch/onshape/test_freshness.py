"""What a build costs after the document stayed, changed, or changed unseen."""

import json

import pytest

from linkwright.stages import fetch as stage
from linkwright.stages.fetch.source import Calls
from linkwright.stages.robot.errors import ConfigError, Offline, ProtocolError, QuotaExhausted, SourceError
from tests.fake_onshape import solids
from tests.fake_onshape.document import Document
from tests.fake_onshape.server import Fault, OnshapeServer
from tests.support.kept import Kept, fetched, onshape

COLD = 1 + 2 * 5


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


def test_the_assembly_is_called_as_a_reply_calls_it_and_no_call_is_made_to_know(server, kept):
    assert build(server, kept).title == ""
    assert build(server, kept).title == ""
    server.edit(resized(server.document, "Steel part", "Steel"))
    assert build(server, kept).title == "Cupboard"
    assert build(server, kept).title == "Cupboard"
    assert build(server, kept, offline=True).title == "Cupboard"
    server.document.root.name = "Wardrobe"
    server.edit(resized(server.document, "Glass part", "Glass"))
    assert build(server, kept).title == "Wardrobe"


@pytest.fixture
def kept():
    return Kept()


@pytest.fixture
def server():
    with OnshapeServer(cupboard()) as server:
        yield server


def build(server, kept, lines=None, **keys):
    """A build of the workspace; asserts that what it says it spent is what the server counted."""
    server.reset()
    made = fetched(onshape(server.document_url(), **keys), kept, server.environ, lines)
    assert made.calls == server.count
    return made


def endpoints(server):
    """How often each kind of request was made: by the last piece of its path."""
    lasts = [path.partition("?")[0].rsplit("/", 2) for _, path, _ in server.calls]
    names = ["definition" if kind == "e" else last for _, kind, last in lasts]
    return {name: names.count(name) for name in names}


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


def test_an_unchanged_workspace_costs_the_question_whether_it_changed(server, kept):
    cold = build(server, kept)
    assert (cold.calls, cold.saved) == (COLD, 0)
    again = build(server, kept)
    assert (again.calls, again.saved) == (1, COLD)
    assert endpoints(server) == {"currentmicroversion": 1}
    assert again.bundle == cold.bundle


def test_after_an_edit_of_one_part_seven_calls_the_first_time_and_six_afterwards(server, kept):
    build(server, kept)
    server.edit(resized(server.document, "Steel part", "Steel"))
    first = build(server, kept)
    assert endpoints(server) == {
        "currentmicroversion": 1, "definition": 1, "elements": 2, "massproperties": 2, "tessellatedfaces": 1,
    }  # fmt: skip
    assert first.calls == 7
    assert first.diagnostics == ()
    assert same_as_cold(server, first.bundle)
    server.edit(resized(server.document, "Glass part", "Glass"))
    second = build(server, kept)
    assert second.calls == 6
    assert same_as_cold(server, second.bundle)
    assert build(server, kept).calls == 1


def test_after_an_edit_the_new_microversion_needs_no_call_and_no_key(server, kept):
    build(server, kept)
    server.edit(resized(server.document, "Steel part", "Steel"))
    bundle = build(server, kept).bundle
    pinned = fetched(onshape(server.document_url("m")), kept)
    assert (pinned.calls, pinned.saved) == (0, COLD)
    assert pinned.bundle == bundle


def test_an_edit_of_the_assembly_alone_costs_five_calls(server, kept):
    build(server, kept)
    server.edit(server.document.edited("Cupboard"))
    assert build(server, kept).calls == 5
    assert "tessellatedfaces" not in endpoints(server)


def test_two_edits_between_builds_are_one(server, kept):
    build(server, kept)
    server.edit(resized(server.document, "Steel part", "Steel"))
    server.edit(resized(server.document, "Glass part", "Glass"))
    made = build(server, kept)
    assert made.calls == 5 + 2 * 2
    assert same_as_cold(server, made.bundle)


def test_with_one_studio_asking_again_costs_less_than_asking_what_changed(kept):
    document = Document("One")
    part = document.studio("S").part("P", solids.box(0.1, 0.1, 0.1), density=1000)
    document.assembly("One").add(part)
    with OnshapeServer(document) as server:
        assert build(server, kept).calls == 3
        server.edit(resized(document, "P", "S"))
        assert build(server, kept).calls == 4
        assert "elements" not in endpoints(server)


def test_two_hundred_parts_in_four_studios_cost_no_more(kept):
    document = Document("Many")
    root = document.assembly("Many")
    for name in "ABCD":
        studio = document.studio(name)
        for number in range(50):
            root.add(studio.part(f"{name}{number}", solids.box(0.1, 0.1, 0.001 * (number + 1)), density=1000))
    with OnshapeServer(document) as server:
        assert build(server, kept).calls == 9
        assert build(server, kept).calls == 1
        server.edit(resized(document, "B7", "B"))
        made = build(server, kept)
        assert made.calls == 7
        assert same_as_cold(server, made.bundle)
        server.edit(resized(server.document, "C9", "C"))
        assert build(server, kept).calls == 6


class TestVerify:
    def derived(self, server):
        """An edit that changes two studios, one of which does not tell."""
        after = resized(server.document, "Wood part", "Wood")
        after.part("Copy of wood part").solid = solids.box(0.3, 0.3, 0.3)
        return after

    def test_a_studio_that_changed_unseen_is_found_by_the_mass_of_the_assembly(self, server, kept):
        build(server, kept)
        server.edit(self.derived(server))
        lines = []
        made = build(server, kept, lines)
        # Three studios of this document kept their microversion; the linked one cannot have changed.
        assert made.calls == 7 + 2 * 3
        assert any("changed through one" in line for line in lines)
        assert made.diagnostics == ()
        assert same_as_cold(server, made.bundle)
        assert build(server, kept).calls == 1

    def test_without_verify_it_is_not_found_until_verify_is_on(self, server, kept):
        build(server, kept)
        server.edit(self.derived(server))
        made = build(server, kept, verify=False)
        assert made.calls == 6
        assert not same_as_cold(server, made.bundle)
        assert build(server, kept, verify=False).calls == 1
        made = build(server, kept)
        assert made.calls == 1 + 1 + 2 * 3
        assert same_as_cold(server, made.bundle)
        assert build(server, kept).calls == 1

    def test_a_mass_that_nothing_explains_is_reported_each_time_and_asked_for_once(self, server, kept):
        build(server, kept)
        server.edit(resized(server.document, "Steel part", "Steel"))
        server.fault = lambda method, path, number: (
            Fault(200, b'{"mass": [123.5, 123.4, 123.6], "hasMass": true}')
            if "/assemblies/" in path and "/massproperties" in path
            else None
        )
        first = build(server, kept)
        assert first.calls == 7 + 2 * 3
        again = build(server, kept)
        assert again.calls == 1
        pinned = fetched(onshape(server.document_url("m")), kept)
        for made in (first, again, pinned):
            (found,) = made.diagnostics
            assert found.code == "W-VERIFY"
            assert "123.5 kg" in found.message
            assert f"{server.document.truth.total_mass():.6g}" in found.message
            assert server.document.root.element in found.where

    def test_a_difference_that_lasts_is_asked_for_once_and_then_only_reported(self, server, kept):
        build(server, kept)

        def overridden(method, path, number):
            if "/assemblies/" not in path or "/massproperties" not in path:
                return None
            return Fault(200, b'{"mass": [%r]}' % (server.document.truth.total_mass() + 1))

        server.edit(resized(server.document, "Steel part", "Steel"))
        server.fault = overridden
        assert build(server, kept).calls == 7 + 2 * 3
        for name in ("Glass", "Wood"):
            server.edit(resized(server.document, f"{name} part", name))
            made = build(server, kept)
            assert made.calls == 6
            assert same_as_cold(server, made.bundle)
            (found,) = made.diagnostics
            assert found.code == "W-VERIFY"
            assert "the difference was the same" in found.message
            assert build(server, kept).calls == 1
        after = resized(server.document, "Steel part", "Steel")
        after.part("Copy of wood part").solid = solids.box(0.3, 0.3, 0.3)
        server.edit(after)
        made = build(server, kept)
        assert made.calls == 6 + 2 * 3
        assert same_as_cold(server, made.bundle)

    @pytest.mark.parametrize(
        ("fault", "billed"),
        [
            (Fault(404), 0),
            (Fault(400), 0),
            (Fault(406), 0),
            (Fault(500), 0),
            (Fault(200, b"{}"), 1),
            (Fault(200, b'{"mass": ["much"'), 1),
        ],
    )
    def test_a_mass_that_cannot_be_had_leaves_the_robot_unchecked(self, server, kept, fault, billed):
        build(server, kept)
        server.edit(self.derived(server))
        server.fault = lambda method, path, number: (
            fault if "/assemblies/" in path and "/massproperties" in path else None
        )
        for calls in (6, 1):
            made = build(server, kept)
            assert made.calls == calls + billed
            (found,) = made.diagnostics
            assert (found.code, found.where) == ("W-VERIFY", f"assembly {server.document.root.element}")
            assert "could not be compared, so a cached part studio may be outdated: the " in found.message
        server.fault = None
        made = build(server, kept)
        assert made.calls == 1 + 1 + 2 * 3
        assert made.diagnostics == ()
        assert same_as_cold(server, made.bundle)

    def test_ending_between_the_replies_and_the_mass_files_nothing_as_checked(self, server, kept):
        build(server, kept)
        server.edit(self.derived(server))
        server.fault = lambda method, path, number: (
            Fault(403) if "/assemblies/" in path and "/massproperties" in path else None
        )
        with pytest.raises(SourceError):
            build(server, kept)
        server.fault = None
        made = build(server, kept)
        assert endpoints(server)["currentmicroversion"] == 1
        assert "elements" not in endpoints(server)
        assert made.calls == 1 + 1 + 2 * 3
        assert same_as_cold(server, made.bundle)

    @pytest.mark.parametrize("broken", range(7))
    def test_ending_while_stale_studios_are_asked_for_mixes_no_states(self, server, kept, broken):
        build(server, kept)
        server.edit(self.derived(server))
        server.fault = lambda method, path, number: Fault(403) if number == 6 + broken else None
        with pytest.raises(SourceError):
            build(server, kept)
        server.fault = None
        assert same_as_cold(server, build(server, kept).bundle)


class TestRefresh:
    def test_it_asks_for_everything_and_what_it_gets_stays(self, server, kept):
        build(server, kept)
        # Metadata can change where no microversion does.
        server.document.part("Steel part").density = 9000
        server.replies = type(server.replies)(server.document)
        assert build(server, kept).bundle.blobs == build(server, kept).bundle.blobs
        fresh = build(server, kept, refresh=True)
        assert (fresh.calls, fresh.saved) == (COLD, 0)
        again = build(server, kept)
        assert again.calls == 1
        assert again.bundle == fresh.bundle
        assert same_as_cold(server, again.bundle)

    def test_it_also_asks_for_what_is_pinned(self, server, kept):
        keys = onshape(server.document_url("v"), refresh=True)
        for _ in range(2):
            assert fetched(keys, kept, server.environ).calls == COLD
        assert stage.force(keys)
        assert not stage.force(onshape(server.document_url("v")))

    def test_it_cannot_be_offline(self):
        keys = onshape(f"https://cad.onshape.com/documents/{'a' * 24}/w/{'b' * 24}/e/{'c' * 24}",
                       refresh=True, offline=True)  # fmt: skip
        with pytest.raises(ConfigError, match="offline allows no call"):
            stage.preflight(keys, {})


class TestOffline:
    def test_the_last_state_is_built_without_call_or_key(self, server, kept):
        cold = build(server, kept)
        server.edit(resized(server.document, "Steel part", "Steel"))
        server.reset()
        made = fetched(onshape(server.document_url(), offline=True), kept)
        assert (made.calls, made.saved, len(server.calls)) == (0, COLD, 0)
        assert made.bundle == cold.bundle

    def test_the_last_complete_state_is_built_where_a_later_one_was_not_finished(self, server, kept):
        cold = build(server, kept)
        server.edit(resized(server.document, "Steel part", "Steel"))
        server.fault = lambda method, path, number: Fault(403) if "/partstudios/" in path else None
        with pytest.raises(SourceError):
            build(server, kept)
        assert fetched(onshape(server.document_url(), offline=True), kept).bundle == cold.bundle

    def test_what_was_never_built_says_so(self, server, kept):
        with pytest.raises(Offline, match="no cached state of the workspace") as caught:
            fetched(onshape(server.document_url(), offline=True), kept)
        assert "source.offline=false" in caught.value.hint
        with pytest.raises(Offline, match="1 reply is not in the cache: the definition of assembly"):
            fetched(onshape(server.document_url("v"), offline=True), kept)
        assert server.calls == []

    def test_what_is_missing_is_named(self, server, kept):
        build(server, kept)
        keys = onshape(server.document_url(), offline=True, tessellation={"angle": 0.01})
        with pytest.raises(Offline) as caught:
            fetched(keys, kept)
        assert "5 replies are not in the cache: the triangles of part studio" in caught.value.message
        assert "and 2 more" in caught.value.message
        assert caught.value.hint.startswith("build once with source.offline=false (5 calls)")


class TestMostCalls:
    def test_a_build_that_needs_more_ends_before_it_spends_them(self, server, kept):
        with pytest.raises(SourceError) as caught:
            build(server, kept, max_calls=COLD - 1)
        assert server.count == 1
        assert caught.value.where == "source.max_calls"
        assert caught.value.message == "this build made 1 call and needs 10 more, but source.max_calls is 10"
        assert f"source.max_calls={COLD}" in caught.value.hint
        # The definition is kept; whether it is still the right one costs a question.
        assert build(server, kept, max_calls=COLD).calls == COLD

    def test_the_check_after_an_edit_counts_as_well(self, server, kept):
        build(server, kept)
        server.edit(resized(server.document, "Steel part", "Steel"))
        with pytest.raises(SourceError, match=r"made 4 calls and needs 3 more, but source.max_calls is 6"):
            build(server, kept, max_calls=6)
        assert server.count == 4
        assert build(server, kept, max_calls=6).calls == 1 + 3

    def test_one_call_is_enough_where_nothing_changed(self, server, kept):
        build(server, kept)
        assert build(server, kept, max_calls=1).calls == 1
        server.edit(resized(server.document, "Steel part", "Steel"))
        with pytest.raises(SourceError, match=r"made 1 call and needs 1 more, but source.max_calls is 1"):
            build(server, kept, max_calls=1)


def test_what_a_failed_fetch_spent_is_reported(server, kept):
    spent = Calls()
    server.fault = lambda method, path, number: Fault(403) if number == 5 else None
    with pytest.raises(SourceError):
        fetched(onshape(server.document_url()), kept, server.environ, calls=spent)
    assert spent.made == server.count > 0
    assert spent.remaining["assembly definition"] < 1000


def test_the_plan_is_reported_before_the_first_call_beyond_the_definition(server, kept):
    lines = []
    build(server, kept, lines)
    assert lines == ["asking for the assembly definition", "5 part studios: 10 calls, 0 kept"]
    lines.clear()
    server.edit(resized(server.document, "Steel part", "Steel"))
    build(server, kept, lines)
    assert lines[0] == "asking whether the document changed"
    assert "5 part studios: 3 calls, 8 kept" in lines


def test_offline_nothing_is_asked_and_nothing_says_so(server, kept):
    lines = []
    with pytest.raises(Offline):
        build(server, kept, lines, offline=True)
    assert lines == []
    build(server, kept)
    server.edit(resized(server.document, "Steel part", "Steel"))
    made = build(server, kept, lines, offline=True)
    assert (made.calls, lines) == (0, ["5 part studios: 0 calls, 10 kept"])


def test_an_element_that_does_not_tell_its_microversion_counts_as_changed(server, kept):
    build(server, kept)
    server.edit(server.document.edited("Cupboard"))
    after = server.replies
    tabs = after._elements
    after._elements = lambda *asked: [{**tab, "microversionId": None} for tab in tabs(*asked)]
    made = build(server, kept)
    assert made.calls == 1 + 1 + 2 + 2 * 4
    assert same_as_cold(server, made.bundle)


@pytest.mark.parametrize("body", [b"[", b"{}", b"[1]", b'{"microversion": 7}'])
def test_a_wrong_answer_about_the_document_is_refused(server, kept, body):
    build(server, kept)
    server.edit(resized(server.document, "Steel part", "Steel"))
    server.fault = lambda method, path, number: Fault(200, body) if "/documents/" in path else None
    with pytest.raises(ProtocolError):
        build(server, kept)
    assert body not in kept.values()


@pytest.mark.parametrize("body", [b"[]", b'[{"id": "another", "microversionId": "m"}]'])
def test_tabs_without_the_assembly_s_own_are_asked_for_once_more_and_not_kept(server, kept, body):
    build(server, kept)
    server.edit(resized(server.document, "Steel part", "Steel"))
    asked = []

    def elements(method, path, number):
        if path.partition("?")[0].endswith("/elements"):
            asked.append(path)
            return Fault(200, body)
        return None

    server.fault = elements
    with pytest.raises(ProtocolError, match=f"lacks {server.document.root.element}, the tab of the assembly"):
        build(server, kept)
    assert max(map(asked.count, asked)) == 2
    assert body not in kept.values()
    server.fault = None
    assert same_as_cold(server, build(server, kept).bundle)


def test_a_used_up_quota_leaves_the_last_complete_state_and_says_so(server, kept):
    cold = build(server, kept)
    server.edit(resized(server.document, "Steel part", "Steel"))
    server.fault = lambda method, path, number: Fault(402) if number == 2 else None
    made = build(server, kept)
    assert made.bundle == cold.bundle
    assert made.stale
    (found,) = made.diagnostics
    assert found.code == "W-QUOTA"
    assert "source.stale=true" in found.hint
    wanted = build(server, kept, stale=True)
    assert (wanted.bundle, wanted.stale) == (cold.bundle, False)
    assert [found.code for found in wanted.diagnostics] == ["W-QUOTA"]
    assert "source.stale" not in wanted.diagnostics[0].hint
    server.fault = lambda *_: Fault(402)
    with pytest.raises(QuotaExhausted):
        build(server, Kept())
