"""Triangles out of replies: both envelopes, both forms of facets, colours, welding."""

import json
from base64 import b64encode

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from linkwright.stages.fetch.onshape.triangles import faces as reply_triangles
from linkwright.stages.formats.colours import NEUTRAL, colour_of
from linkwright.stages.mesh import tessellation
from linkwright.stages.robot.errors import ProtocolError
from tests.fake_onshape import outlines, solids
from tests.support.recorded import DATA, needs_data

# A unit cube, corner at the origin: each face as four corners, anticlockwise from outside.
CORNERS = [[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]
SIDES = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
TRIANGLES = [[(a, b, c), (a, c, d)] for a, b, c, d in SIDES]
HOLE = outlines.circle(0.02, at=(0.1, 0.05), segments=24)
RED, BLUE = {"color": [255, 0, 0], "opacity": 255}, {"color": [0, 0, 255], "opacity": 51}


def read(reply, parts):
    """The meshes of parts in a reply, by way of the compact form."""
    return tessellation.read(reply_triangles.compact(reply), parts)


def xyz(point):
    return dict(zip("xyz", point, strict=True))


def body(form="table", name="JHD", scale=1.0, appearance=None, faces=None):
    """A cube's record: "table" (facetPoints and indices) or "loose" (vertices in each facet)."""
    corners = [[scale * value for value in corner] for corner in CORNERS]
    record = {"id": name, "faces": [], "facetPoints": []}
    for number, side in enumerate(TRIANGLES):
        if form == "table":  # as the server does: each face brings its own copies of its corners
            used = sorted({corner for triangle in side for corner in triangle})
            first = len(record["facetPoints"])
            record["facetPoints"] += [xyz(corners[corner]) for corner in used]
            facets = [{"indices": [first + used.index(c) for c in triangle]} for triangle in side]
        else:
            facets = [{"vertices": [xyz(corners[c]) for c in triangle]} for triangle in side]
        record["faces"].append({"facets": facets} | ({"appearance": faces[number]} if faces else {}))
    return record | ({"appearance": appearance} if appearance else {})


def reply(*bodies, bare=False):
    return json.dumps(list(bodies) if bare else {"facetPoints": [], "bodies": list(bodies)}).encode()


def lists(record):
    """A record in the old way: points as lists."""
    return json.loads(json.dumps(record), object_hook=lambda d: [*d.values()] if set(d) == set("xyz") else d)


@pytest.mark.parametrize(
    "data",
    [
        reply(body("table")),
        reply(body("loose")),
        reply(lists(body("loose")), bare=True),
        reply(lists(body("table")), bare=True),
    ],
)
def test_every_form_of_a_cube_is_the_same_closed_cube(data):
    mesh = read(data, {"JHD"})["JHD"]
    assert mesh.closed
    assert mesh.volume == pytest.approx(1, abs=1e-15)
    assert mesh.surface.area() == pytest.approx(6, abs=1e-15)
    assert mesh.surface.vertices.tolist() == sorted(map(list, CORNERS))
    assert len(mesh.surface.triangles) == 12
    assert mesh.palette == (NEUTRAL,)


def test_only_the_parts_asked_for_are_read():
    data = reply(body(name="A"), body(name="B"), {"id": "C", "faces": "broken"})
    assert set(read(data, {"B", "D"})) == {"B"}


def test_a_body_without_triangles_is_absent():
    assert read(reply({"id": "A", "faces": []}, {"id": "B"}), {"A", "B"}) == {}


def test_the_order_of_faces_points_and_corners_does_not_matter():
    rng = np.random.default_rng(7)
    plain = read(reply(body("loose", faces=[RED] * 3 + [BLUE] * 3)), {"JHD"})["JHD"]
    record = body("loose", faces=[RED] * 3 + [BLUE] * 3)
    rng.shuffle(record["faces"])
    for face in record["faces"]:
        rng.shuffle(face["facets"])
        for facet in face["facets"]:
            turn = int(rng.integers(3))
            facet["vertices"] = facet["vertices"][turn:] + facet["vertices"][:turn]
    shuffled = read(reply(record), {"JHD"})["JHD"]
    assert shuffled.surface.vertices.tobytes() == plain.surface.vertices.tobytes()
    assert shuffled.surface.triangles.tolist() == plain.surface.triangles.tolist()
    assert shuffled.colours.tolist() == plain.colours.tolist()


def test_a_face_colour_wins_over_the_body_colour_and_both_over_grey():
    mesh = read(reply(body(appearance=BLUE, faces=[RED] + [None] * 5)), {"JHD"})["JHD"]
    red, blue = (1.0, 0.0, 0.0, 1.0), (0.0, 0.0, 1.0, 0.2)
    assert mesh.palette == (blue, red)
    in_red = mesh.surface.corners[mesh.colours == mesh.palette.index(red)]
    assert in_red.shape == (2, 3, 3)
    assert (in_red[:, :, 0] == 0).all()  # the first side is the one at x = 0


# Closed solids, and how thin each is at its thinnest [m].
SOLIDS = {
    "cube": (solids.box(0.1, 0.1, 0.1), 0.1),
    "foil": (solids.box(1.0, 0.5, 2e-6), 2e-6),
    "grain": (solids.box(1e-4, 2e-4, 3e-4), 1e-4),
    "pin": (solids.cylinder(0.02, 0.05, chamfer=0.001), 0.04),
    "thin tube": (solids.tube(0.02, 0.019999, 0.1), 1e-6),
    "ball": (solids.ball(0.01), 0.02),
    "plate": (solids.extrude([(0, 0), (0.2, 0), (0.2, 0.1), (0, 0.1)], 0.005, holes=[HOLE]), 0.005),
}


@settings(max_examples=60, deadline=None)
@given(name=st.sampled_from(sorted(SOLIDS)), seed=st.integers(0, 2**32 - 1))
def test_a_closed_solid_stays_closed_whatever_the_last_digits_of_its_faces_say(name, seed):
    solid, thickness = SOLIDS[name]
    rng = np.random.default_rng(seed)
    faces = []
    for face in solid.faces:  # each face brings its own copies of its corners, each a little off
        corners = solid.vertices[face.triangles]
        noisy = corners + rng.uniform(-1e-9, 1e-9, corners.shape)
        faces.append({"facets": [{"vertices": [list(map(float, c)) for c in row]} for row in noisy]})
    mesh = read(reply({"id": "A", "faces": faces}), {"A"})["A"]
    used = np.unique(solid.triangles)
    assert mesh.closed
    assert len(mesh.surface.vertices) == len(np.unique(solid.vertices[used], axis=0))
    assert len(mesh.surface.triangles) == len(solid.triangles)
    assert mesh.volume == pytest.approx(solid.properties.volume, rel=8e-9 / thickness)


def test_points_that_are_apart_are_not_welded():
    record = body("loose", scale=0.1)
    record["faces"][0]["facets"][0]["vertices"][0]["x"] += 1e-7
    assert not read(reply(record), {"JHD"})["JHD"].closed


def test_triangles_that_lose_a_corner_are_dropped_and_slivers_keep_the_surface_closed():
    record = body("loose")
    record["faces"][0]["facets"].append({"vertices": [xyz((0, 0, 0)), xyz((0, 0, 0)), xyz((0, 1, 0))]})
    mesh = read(reply(record), {"JHD"})["JHD"]
    assert (len(mesh.surface.triangles), mesh.closed) == (12, True)
    # One side meets its neighbour's edge at a point that only a triangle without area connects.
    a, m, b = xyz((0, 0, 0)), xyz((0, 0.5, 0)), xyz((0, 1, 0))
    low, high = xyz((0, 0, 1)), xyz((0, 1, 1))
    record["faces"][0]["facets"] = [
        {"vertices": [a, low, m]},
        {"vertices": [low, high, m]},
        {"vertices": [high, b, m]},
        {"vertices": [a, m, b]},
    ]
    mesh = read(reply(record), {"JHD"})["JHD"]
    assert (len(mesh.surface.triangles), mesh.closed, mesh.volume) == (14, True, pytest.approx(1))


def test_a_facet_with_more_corners_becomes_a_fan():
    record = {"id": "A", "faces": []}
    record["facetPoints"] = [xyz(corner) for corner in CORNERS]
    record["faces"] = [{"facets": [{"indices": side}]} for side in SIDES]
    mesh = read(reply(record), {"A"})["A"]
    assert (len(mesh.surface.triangles), mesh.closed, mesh.volume) == (12, True, pytest.approx(1))


def test_a_solid_that_is_inside_out_is_turned():
    record = body("loose")
    for face in record["faces"]:
        for facet in face["facets"]:
            facet["vertices"].reverse()
    assert read(reply(record), {"JHD"})["JHD"].surface.volume() == pytest.approx(1)


@pytest.mark.parametrize(
    ("change", "why"),
    [
        ({"facetPoints": [xyz((0, 0, 0))]}, "lies outside of the 1 points"),
        ({"facetPoints": [{"x": 0, "y": 0}] * 24}, "'z'"),
        ({"facetPoints": [{"x": 0, "y": 0, "z": None}] * 24}, "part JHD"),
        ({"faces": [{"facets": [7]}]}, "part JHD"),
    ],
)
def test_triangles_in_no_known_shape_are_an_error_that_names_the_part(change, why):
    with pytest.raises(ProtocolError) as caught:
        read(reply(body() | change), {"JHD"})
    assert why in str(caught.value)
    with pytest.raises(ProtocolError, match="not JSON"):
        read(b'{"bodies": [', {"JHD"})


@pytest.mark.parametrize(
    ("appearance", "colour"),
    [
        ({"color": [255, 0, 51]}, (1, 0, 0.2, 1)),
        ({"color": ["255", "0", "51"], "opacity": 0}, (1, 0, 0.2, 0)),
        ({"color": [-1, 0, 51], "opacity": 255}, (1, 0, 0.2, 1)),
        ({"color": b64encode(bytes([255, 0, 51])).decode()}, (1, 0, 0.2, 1)),
        ({"color": b64encode(bytes([255, 0, 51, 102])).decode()}, (1, 0, 0.2, 0.4)),
        ({"color": b64encode(bytes([255, 0, 51, 102])).decode(), "opacity": 204}, (1, 0, 0.2, 0.8)),
        ({"color": ["/w==", "AA==", "Mw=="]}, (1, 0, 0.2, 1)),
        ({"color": 0xFF0033}, (1, 0, 0.2, 1)),
        ({"color": 0xE6FF0033 - (1 << 32)}, (1, 0, 0.2, 0.901961)),
        ({"color": {"red": 255, "green": 0, "blue": 51}, "opacity": 255}, (1, 0, 0.2, 1)),
        ({"color": None, "rgbaColor": [255, 0, 51, 102]}, (1, 0, 0.2, 0.4)),
        ({"color": "no colour!"}, NEUTRAL),
        ({"color": [300, 0, 0]}, NEUTRAL),
        ({"color": [1, 2]}, NEUTRAL),
        ({"color": [None, 0, 0]}, NEUTRAL),
        (None, NEUTRAL),
        ({}, NEUTRAL),
    ],
)
def test_colours_are_read_in_every_encoding(appearance, colour):
    assert colour_of(appearance) == pytest.approx(colour)


@needs_data
def test_a_recorded_reply_is_read():
    data = (DATA / "star_tessellatedfaces_subset.json").read_bytes()
    mesh = read(data, {"JRH"})["JRH"]
    assert mesh.surface.vertices.shape == (4, 3)
    # The one face that was recorded is a rectangle of 203.2 mm by 22.12 mm.
    assert mesh.surface.area() == pytest.approx(0.2032 * np.hypot(0.0191595, 0.0110617), rel=1e-12)
    assert not mesh.closed
    bare = json.dumps(json.loads(data)["bodies"]).encode()
    assert read(bare, {"JRH"})["JRH"].surface.vertices.tobytes() == mesh.surface.vertices.tobytes()
