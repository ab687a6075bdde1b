"""Tessellated faces that were refused are asked for again: a fault that passes changes no byte for good."""

import pytest

from tests.fake_onshape import solids
from tests.fake_onshape.document import Document
from tests.fake_onshape.faults import Fault
from tests.fake_onshape.frames import frame
from tests.fake_onshape.server import OnshapeServer
from tests.support.kept import Kept, fetched, onshape

REFUSALS = [Fault(400), Fault(404), Fault(406)]
PASSING = [Fault(402), Fault(401), Fault(silent=True), Fault(500), Fault(200, b'{"bodies": [')]


def rack(used=2, unused=0, studios=1):
    """An assembly that uses some parts of part studios that hold more."""
    document = Document("Rack")
    boxes = [document.studio(f"Boxes {number}") for number in range(studios)]
    whole = document.assembly("Rack")
    for far, studio in enumerate(boxes):
        for number in range(used + unused):
            block = solids.box(0.01 + 0.001 * number, 0.02, 0.03 + 0.001 * far)
            part = studio.part(f"Box {far} {number}", block, density=1000)
            if number < used:
                whole.add(part, fixed=True, pose=frame((number, far, 0)))
    return document


@pytest.fixture
def kept():
    return Kept()


@pytest.fixture
def server():
    with OnshapeServer(rack()) as running:
        yield running


def refusing(fault, *words):
    """A hook that puts a fault in place of replies whose targets hold any of the words."""
    return lambda method, target, number: fault if any(word in target for word in words) else None


def build(server, kept, pin="m", **more):
    """What is fetched, the kinds of what was asked, and the lines."""
    before = len(server.calls)
    lines = []
    keys = {name: more.pop(name) for name in ("offline", "refresh", "max_calls") if name in more}
    environ = more.pop("environ", server.environ)
    found = fetched(onshape(server.document_url(pin), **keys), kept, environ, lines, **more)
    asked = [target.partition("?")[0].rpartition("/")[2] for _, target, _ in server.calls[before:]]
    return found, [kind for kind in asked if kind in ("tessellatedfaces", "gltf")], lines


def codes(found):
    return [problem.code for problem in found.diagnostics]


@pytest.mark.parametrize("fault", REFUSALS, ids=["400", "404", "406"])
@pytest.mark.parametrize("pin", ["m", "v", "w"])
def test_a_refusal_that_passes_leaves_no_trace(server, kept, fault, pin):
    right = build(server, Kept(), pin)[0]
    server.fault = refusing(fault, "/tessellatedfaces")
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


@pytest.mark.parametrize("fault", REFUSALS, ids=["400", "404", "406"])
@pytest.mark.parametrize("pin", ["m", "w"])
def test_a_second_refusal_settles_it_until_a_refresh(server, kept, fault, pin):
    server.fault = refusing(fault, "/tessellatedfaces")
    first, _, _ = build(server, kept, pin)
    again, asked, _ = build(server, kept, pin)
    assert asked == ["tessellatedfaces"]
    assert (again.bundle, again.lasts) == (first.bundle, True)
    assert "source.refresh=true" in again.diagnostics[0].hint
    for _ in range(2):
        later, asked, lines = build(server, kept, pin)
        assert (later.bundle, asked, later.lasts) == (first.bundle, [], True)
        assert "1 part studio: 0 calls, 2 kept" in lines
    server.fault = None
    assert build(server, kept, pin)[1] == []
    fresh, asked, _ = build(server, kept, pin, refresh=True)
    assert asked == ["tessellatedfaces"]
    assert codes(fresh) == []
    assert build(server, kept, pin)[0].bundle == fresh.bundle


def test_a_refusal_during_a_refresh_begins_the_count_anew(server, kept):
    server.fault = refusing(Fault(400), "/tessellatedfaces")
    for _ in range(2):
        build(server, kept)
    assert build(server, kept, refresh=True)[1] == ["tessellatedfaces", "gltf"]
    assert build(server, kept)[1] == ["tessellatedfaces"]
    assert build(server, kept)[1] == []


def test_offline_and_without_a_key_nothing_is_asked_and_nothing_is_settled(server, kept):
    server.fault = refusing(Fault(400), "/tessellatedfaces")
    first = build(server, kept)[0]
    server.fault = None
    for more in ({"offline": True}, {"environ": {}}):
        again, asked, lines = build(server, kept, **more)
        assert (again.bundle, asked, again.calls) == (first.bundle, [], 0)
        assert "1 part studio: 0 calls, 2 kept" in lines
        assert "the next build asks" in again.diagnostics[0].hint
    assert codes(build(server, kept)[0]) == []


def test_a_budget_without_room_for_it_postpones_the_call(server, kept):
    server.fault = refusing(Fault(400), "/tessellatedfaces")
    first = build(server, kept, "w")[0]
    server.fault = None
    again, asked, _ = build(server, kept, "w", max_calls=1)
    assert (again.bundle, asked) == (first.bundle, [])
    assert codes(build(server, kept, "w", max_calls=2)[0]) == []


@pytest.mark.parametrize("fault", PASSING, ids=["402", "401", "silent", "500", "cut"])
def test_a_failure_that_is_no_refusal_neither_ends_the_build_nor_settles_it(server, kept, fault):
    right = build(server, Kept())[0]
    server.fault = refusing(Fault(400), "/tessellatedfaces")
    first = build(server, kept)[0]
    server.fault = refusing(fault, "/tessellatedfaces")
    again = build(server, kept)[0]
    assert again.bundle == first.bundle
    assert codes(again) == ["I-TESSELLATION"]
    assert "asking again failed" in again.diagnostics[0].message
    server.fault = None
    assert build(server, kept)[0].bundle == right.bundle


def test_what_an_earlier_version_kept_without_a_count_is_asked_for_once_more(server, kept):
    server.fault = refusing(Fault(400), "/tessellatedfaces")
    build(server, kept)
    kept.facts = {subject: fact for subject, fact in kept.facts.items() if not subject.endswith("#faces")}
    assert build(server, kept)[1] == ["tessellatedfaces"]
    assert build(server, kept)[1] == []


def test_an_edit_elsewhere_keeps_the_count_of_an_unchanged_part_studio(kept):
    document = rack(studios=6)
    with OnshapeServer(document) as server:
        server.fault = refusing(Fault(400), "/tessellatedfaces")
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


def test_of_several_part_studios_only_the_refused_are_asked_again(kept):
    document = rack(studios=3)
    element = document.studios[1].element
    with OnshapeServer(document) as server:
        right = build(server, Kept())[0]
        server.fault = lambda method, target, number: (
            Fault(400) if "/tessellatedfaces" in target and element in target else None
        )
        build(server, kept)
        server.fault = None
        again, asked, lines = build(server, kept)
        assert (again.bundle, asked) == (right.bundle, ["tessellatedfaces"])
        assert "3 part studios: 1 call, 6 kept" in lines


def test_the_jobs_of_a_sweep_count_as_one_build(server, kept):
    import time

    server.fault = refusing(Fault(400), "/tessellatedfaces")
    began = time.time()
    assert build(server, kept, began=began)[1] == ["tessellatedfaces", "gltf"]
    assert build(server, kept, began=began)[1] == []
    began = time.time()
    assert build(server, kept, began=began)[1] == ["tessellatedfaces"]
    assert build(server, kept, began=time.time())[1] == []


@pytest.mark.parametrize("again", [["some"], ["whole"], ["some", "whole"]])
def test_where_some_parts_are_asked_for_both_ways_to_ask_are_tried_again(kept, again):
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
        found, asked, _ = build(server, kept)
        assert codes(found) == []
        assert len(asked) == (1 if "some" in again else 2)
        assert build(server, kept)[1] == []
