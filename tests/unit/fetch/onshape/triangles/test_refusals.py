"""Tessellated faces that were refused are asked for again: a fault that passes changes no byte for good."""

from time import time

import pytest

from linkwright.stages.fetch.source import SweepState
from tests.fake_onshape.faults import Fault
from tests.fake_onshape.server import OnshapeServer
from tests.support.kept import Kept, fetched, onshape
from tests.support.reported import codes
from tests.support.traffic import at_path, rack

PASSING = [Fault(402), Fault(401), Fault(silent=True), Fault(500), Fault(200, b'{"bodies": [')]


@pytest.fixture
def server():
    with OnshapeServer(rack()) as running:
        yield running


def build(server, kept, pin="m", **more):
    """Returns what is fetched, the kinds of the requests, and the lines."""
    before = len(server.calls)
    lines = []
    keys = {name: more.pop(name) for name in ("offline", "refresh", "max_calls") if name in more}
    environ = more.pop("environ", server.environ)
    outcome = fetched(onshape(server.document_url(pin), **keys), kept, environ, lines, **more)
    asked = [target.partition("?")[0].rpartition("/")[2] for _, target, _ in server.calls[before:]]
    return outcome, [kind for kind in asked if kind in ("tessellatedfaces", "gltf")], lines


@pytest.mark.parametrize(("fault", "pin"), [(Fault(400), "m"), (Fault(404), "v"), (Fault(406), "w")])
def test_a_refusal_that_passes_leaves_no_trace(server, kept, fault, pin):
    right = build(server, Kept(), pin)[0]
    server.fault = at_path(fault, "/tessellatedfaces")
    first, asked, _ = build(server, kept, pin)
    assert asked == ["tessellatedfaces", "gltf"]
    assert codes(first) == ["I-TESSELLATION"]
    assert "the next build asks" in first.diagnostics[0].hint
    assert not first.lasts
    server.fault = None
    again, asked, lines = build(server, kept, pin)
    assert asked == ["tessellatedfaces"]
    calls = 1 + (pin == "w")
    assert (again.calls, again.bundle, codes(again), again.lasts) == (calls, right.bundle, [], True)
    assert "1 part studio: 1 call, 2 kept" in lines
    later, asked, _ = build(server, kept, pin)
    assert (later.bundle, asked) == (right.bundle, [])


@pytest.mark.parametrize(("fault", "pin"), [(Fault(400), "m"), (Fault(406), "w")])
def test_a_second_refusal_settles_it_until_a_refresh(server, kept, fault, pin):
    server.fault = at_path(fault, "/tessellatedfaces")
    first, _, _ = build(server, kept, pin)
    again, asked, _ = build(server, kept, pin)
    assert asked == ["tessellatedfaces"]
    assert (again.bundle, again.lasts) == (first.bundle, True)
    assert "source.refresh=true" in again.diagnostics[0].hint
    later, asked, lines = build(server, kept, pin)
    assert (later.bundle, asked, later.lasts) == (first.bundle, [], True)
    assert "1 part studio: 0 calls, 2 kept" in lines
    # A refusal during a refresh begins the count anew, as it does where an earlier version kept none.
    assert build(server, kept, pin, refresh=True)[1] == ["tessellatedfaces", "gltf"]
    for _ in range(2):
        assert [build(server, kept, pin)[1] for _ in range(2)] == [["tessellatedfaces"], []]
        kept.facts = {name: fact for name, fact in kept.facts.items() if not name.endswith("#faces")}
    assert [build(server, kept, pin)[1] for _ in range(2)] == [["tessellatedfaces"], []]
    server.fault = None
    assert build(server, kept, pin)[1] == []
    fresh, asked, _ = build(server, kept, pin, refresh=True)
    assert asked == ["tessellatedfaces"]
    assert codes(fresh) == []
    assert build(server, kept, pin)[0].bundle == fresh.bundle


def test_a_build_offline_or_without_a_key_settles_nothing(server, kept):
    server.fault = at_path(Fault(400), "/tessellatedfaces")
    first = build(server, kept)[0]
    server.fault = None
    for more in ({"offline": True}, {"environ": {}}):
        again, asked, lines = build(server, kept, **more)
        assert (again.bundle, asked, again.calls) == (first.bundle, [], 0)
        assert "1 part studio: 0 calls, 2 kept" in lines
        assert "the next build asks" in again.diagnostics[0].hint
    assert codes(build(server, kept)[0]) == []


def test_a_budget_without_room_for_it_postpones_the_call(server, kept):
    server.fault = at_path(Fault(400), "/tessellatedfaces")
    first = build(server, kept, "w")[0]
    server.fault = None
    again, asked, _ = build(server, kept, "w", max_calls=1)
    assert (again.bundle, asked) == (first.bundle, [])
    assert codes(build(server, kept, "w", max_calls=2)[0]) == []


@pytest.mark.parametrize("fault", PASSING, ids=["402", "401", "silent", "500", "cut"])
def test_a_failure_that_is_no_refusal_settles_nothing(server, kept, fault):
    right = build(server, Kept())[0]
    server.fault = at_path(Fault(400), "/tessellatedfaces")
    first = build(server, kept)[0]
    server.fault = at_path(fault, "/tessellatedfaces")
    again = build(server, kept)[0]
    assert again.bundle == first.bundle
    assert codes(again) == ["I-TESSELLATION"]
    assert "asking again failed" in again.diagnostics[0].message
    server.fault = None
    assert build(server, kept)[0].bundle == right.bundle


def test_an_edit_elsewhere_keeps_a_studios_count(kept):
    document = rack(studios=6)
    with OnshapeServer(document) as server:
        right = build(server, Kept(), "m")[0]
        server.fault = at_path(Fault(400), "/tessellatedfaces", document.studios[1].element)
        build(server, separate := Kept())
        server.fault = None
        again, asked, lines = build(server, separate)
        assert (again.bundle, asked) == (right.bundle, ["tessellatedfaces"]), (
            "only the refused is asked again"
        )
        assert "6 part studios: 1 call, 12 kept" in lines
        server.fault = at_path(Fault(400), "/tessellatedfaces")
        assert build(server, kept, "w")[1].count("gltf") == 6
        server.edit(server.document.edited("Rack"))
        again, asked, _ = build(server, kept, "w")
        assert asked == ["tessellatedfaces"] * 6, "asked once more, at the new microversion"
        assert again.lasts
        server.edit(server.document.edited("Rack"))
        last, asked, lines = build(server, kept, "w")
        assert (asked, last.lasts) == ([], True)
        assert any(line.startswith("6 part studios: ") for line in lines)
        right = build(server, Kept(), "w")[0]
        assert len(last.bundle.studios) == len(right.bundle.studios) == 6


def test_the_jobs_of_a_sweep_count_as_one_build(server, kept):
    server.fault = at_path(Fault(400), "/tessellatedfaces")
    first, second = SweepState(time()), [["tessellatedfaces", "gltf"], [], ["tessellatedfaces"], []]
    assert [build(server, kept, sweep=first)[1] for _ in range(2)] == second[:2]
    assert [build(server, kept, sweep=SweepState(time()))[1] for _ in range(2)] == second[2:]


@pytest.mark.parametrize("again", [["some"], ["whole"], ["some", "whole"]])
def test_both_ways_to_ask_for_parts_are_tried_again(kept, again):
    document = rack(2, 20)

    def refuse(*ways):
        def fault(method, target, number):
            way = "some" if "partId=" in target else "whole"
            return Fault(400) if "/tessellatedfaces" in target and way in ways else None

        return fault

    with OnshapeServer(document) as server:
        server.fault = refuse("some", "whole")
        assert build(server, kept)[1] == ["tessellatedfaces", "tessellatedfaces", "gltf"]
        server.fault = refuse(*{"some", "whole"}.difference(again))
        outcome, asked, _ = build(server, kept)
        assert codes(outcome) == []
        assert len(asked) == (1 if "some" in again else 2)
        assert build(server, kept)[1] == []
