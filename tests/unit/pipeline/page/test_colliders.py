"""Colliders in the report: joined with the time that they took, and shown for people."""

import base64
import json
from dataclasses import replace

import pytest

from linkwright.pipeline.caching.actions import MemoResult
from linkwright.pipeline.mesh_details import as_cached, details
from linkwright.pipeline.page.document import page
from linkwright.pipeline.secrets import Secrets
from linkwright.stages.mesh.view.views import PICTURES
from linkwright.stages.robot.model.geometry import ColliderFigures, Exclude, Geometry, Measures, Shape, Touch
from tests.support.page_reader import Reader
from tests.unit.pipeline.page.test_document import REPORT, SHOWN

NEAR = Measures(0.0153, 0.1792, "boolean", 0.00036, 0.00052, 0.00054, 0.00154)
FAR = Measures(0.25, 0.0, "sampling", 0.00304, 0.00651, 0.0, 0.0)
EVERY = (
    ColliderFigures("base", ("Foot <1>",), "ladder", "cylinder", 1, 0, True, 0.002, NEAR, 0.77, key="k1"),
    ColliderFigures("base", ("Foot <2>",), "ladder", "cylinder", 1, 0, True, 0.002, NEAR, 0.77, key="k1"),
    ColliderFigures(
        "arm", ("Sleeve <1>",), "ladder", "pieces", 16, 1496, False, 0.0025, FAR, 1.216, "cut short", key="k2"
    ),
    ColliderFigures("arm", ("Net",), "raw", "raw", 1, 90, True, None, None, None, key="k3"),
)
SHAPES = tuple(
    Shape(link, role, f"{link}.stl", None, 3, 1, 0.1, 0.0)
    for link, role in [("base", "collision")] * 2 + [("arm", "collision")] * 17 + [("arm", "visual")] * 4
)
GEOMETRY = Geometry(SHAPES, {}, colliders=EVERY)
REMEMBERED = [
    MemoResult("mesh.link", {"parts": []}, False, 9.0),
    MemoResult("mesh.collider", {"collider": "k2", "step": "improve"}, False, 29.0),
    MemoResult("mesh.collider", {"collider": "k1", "step": "make"}, True, 1.25),
    MemoResult("mesh.collider", {"collider": "k2", "step": "make"}, True, 0.5),
    MemoResult("mesh.collider", {"collider": "k3", "step": "make"}, False, 0.001),
]
TABLES = details(GEOMETRY, REMEMBERED)


def test_collider_has_its_figures_and_the_time_of_its_steps():
    first, second, sleeve, net = TABLES["colliders"]
    assert first == {
        "link": "base", "parts": ("Foot <1>",), "maker": "ladder", "rung": "cylinder", "pieces": 1,
        "vertices": 0, "meets": True, "tolerance": 2.0, "miss": 0.77, "note": "", "failed": False,
        "reason": "", "extra": 0.0153, "missing": 0.1792, "by": "boolean", "protrusion_p95": 0.36,
        "protrusion_max": 0.52, "bareness_p95": 0.54, "bareness_max": 1.54, "seconds": 1.25, "cached": True,
    }  # fmt: skip
    assert (second["seconds"], second["cached"]) == (0.0, True)
    assert (sleeve["seconds"], sleeve["cached"]) == (29.5, False)
    assert (net["seconds"], net["cached"], net["tolerance"]) == (0.001, False, None)
    assert details(GEOMETRY, REMEMBERED[::-1]) == TABLES, "the order in which they were made does not matter"


def test_links_have_totals_of_colliders_and_geoms():
    assert TABLES["links"] == [
        {"link": "base", "colliders": 2, "pieces": 2, "vertices": 0, "seconds": 1.25, "geoms": 2},
        {"link": "arm", "colliders": 2, "pieces": 17, "vertices": 1586, "seconds": 29.501, "geoms": 17},
    ]
    shown = Geometry((*SHAPES, replace(SHAPES[0], link="rod")), {}, colliders=EVERY)
    rod = {"link": "rod", "colliders": 0, "pieces": 0, "vertices": 0, "seconds": 0, "geoms": 1}
    assert details(shown)["links"][-1] == rod


def test_colliders_of_a_cached_stage_are_cached():
    again = as_cached({**TABLES, "excludes": [1]})
    assert all(row["cached"] for row in again["colliders"])
    assert [row["seconds"] for row in again["colliders"]] == [1.25, 0.0, 29.5, 0.001]
    assert (again["links"], again["excludes"]) == (TABLES["links"], [1])
    assert as_cached({}) == {}
    assert not TABLES["colliders"][2]["cached"]


PIXEL = base64.b64encode(b"\x89PNG...").decode()


def shown(*links, left_out=()):
    pictures = [{"link": link, "png": PIXEL} for link in links]
    return {**SHOWN, PICTURES: json.dumps({"side": 240, "pictures": pictures, "left_out": left_out})}


def made(tables=TABLES, views=SHOWN, secrets=None):
    return page(replace(REPORT, details=tables), views, {"arm.urdf": 1}, Secrets(secrets or {}))


def test_colliders_that_miss_are_first_and_marked():
    read = Reader(made())
    assert "Colliders: 2 of 3 within the tolerance" in read.text
    assert "misses" not in read.folded
    for words in ("Sleeve <1>", "16 convex pieces", "cut short", "3.04 / 6.51", "25.0 % / 0.0 %", "sampling"):
        assert any(words in said for said in read.said), words
        assert words not in read.folded
    for words in ("Foot <1>", "cylinder", "0.36 / 0.52", "0.54 / 1.54", "1.5 % / 17.9 %", "boolean", "Net"):
        assert words in read.folded
    assert read.said.count("misses") == 1
    assert read.text.index("misses") < read.text.index("Foot <1>")
    assert not read.lacking("2 within the tolerance", ", 1 not judged")
    assert {"29.50", "1.25, kept", "0.00, kept"} <= set(read.said)
    totals = "2 links: 19 pieces, 1,586 vertices, 19 geoms; 2 of 4 colliders made in this build"
    assert totals in read.said
    assert totals not in read.folded
    rows = "".join(read.folded)
    assert [total for total in ("all", "30.75", "29.50") if total not in rows] == []


def read_of(*colliders, **more):
    """The page with these colliders alone."""
    return Reader(made(details(replace(GEOMETRY, colliders=colliders, **more))))


LATE = "it took longer than 60 s"
PARTS = tuple(f"P{n}" for n in range(9))


@pytest.mark.parametrize(("colliders", "seen", "folded", "absent"), [
    pytest.param([replace(EVERY[0], maker="hull", rung="hull", measures=FAR, miss=2.5)],
        ["Colliders: 0 of 1 within the tolerance", "misses"], [], [], id="a hull that misses"),
    pytest.param([*EVERY[:2], replace(EVERY[3], maker="coacd", rung="hull", meets=False, note=LATE)],
        ["Colliders: 2 of 2 within the tolerance", LATE, "not judged"], [], [], id="a hull for pieces"),
    pytest.param(EVERY[3:], ["Colliders", "1 not judged"], ["the mesh itself"],
        ["within the tolerance", "Stands out"], id="nothing judged, so no figure is explained"),
    pytest.param([replace(EVERY[0], measures=replace(NEAR, extra=None), parts=PARTS)],
        ["P0, P1, P2 and 6 more"], ["no volume / 17.9 %"], [], id="no volume, and many parts together"),
])  # fmt: skip
def test_what_misses_or_was_not_judged_is_in_sight(colliders, seen, folded, absent):
    read = read_of(*colliders)
    assert read.lacking(*seen, *folded, *absent) == absent
    assert [words for words in ("misses", LATE, "not judged") if words in seen and words in read.folded] == []
    assert [words for words in folded if words not in read.folded] == []


def test_pictures_are_folded_and_have_words():
    data = made(views=shown("base", "arm <2>", left_out=["hand", "head"]))
    read = Reader(data)
    assert read.links.count(f"data:image/png;base64,{PIXEL}") == 2
    pictures = "Pictures of 2 links: on the left what is seen, on the right the collider"
    assert not read.lacking(pictures, "Too large to be drawn here: hand, head")
    assert b'alt="arm &lt;2&gt;: what is seen, and its collider" width="480" height="240"' in data
    assert {"base", "arm <2>"} <= set(read.folded)
    assert b"<img" not in made()


@pytest.mark.parametrize(("tables", "views"), [({}, SHOWN), ({"excludes": []}, shown("base"))])
def test_a_robot_without_colliders_has_no_such_section(tables, views):
    assert "Colliders" not in Reader(made(tables, views)).text


def test_page_has_colliders_of_links_that_do_not_collide():
    shapes = tuple(replace(shape, collider=0) for shape in SHAPES[1:])
    some = Exclude("base", "arm", "Always", 0.00193, ((0, 0), (0, 3)))
    whole = Exclude("arm", "hand", "Adjacent", 0.001)
    touching = Touch("base", "hand", 0.002)
    shown = details(Geometry(shapes, {}, (), True, (whole, some), (touching,), EVERY))
    assert shown["touching"] == [{"links": ["base", "hand"], "depth": 2.0}]
    first, second = shown["excludes"]
    assert (first["colliders"], first["geoms"]) == (None, ())
    words = "Sleeve <1> (2 of 17 pieces)"
    assert (second["colliders"], second["geoms"]) == ((("Foot <1>",), (words,)), ((0, 0), (0, 3)))
    said = Reader(made(shown)).said
    place = said.index("Always")
    assert said[place - 2 : place + 3] == ["base", "arm", "Always", "1.93", f"Foot <1> against {words}"]
    place = said.index("Adjacent")
    assert said[place - 2 : place + 3] == ["arm", "hand", "Adjacent", "1.00", "all"]
