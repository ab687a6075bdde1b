"""Triangles out of replies: both envelopes, both forms of facets, colours, welding."""

import json
import math
from base64 import b64encode

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from linkwright.stages.fetch.onshape.triangles import faces as reply_triangles
from linkwright.stages.formats.colours import colour_of
from linkwright.stages.mesh import part_mesh
from linkwright.stages.robot.errors import ProtocolError
from linkwright.stages.robot.model.geometry import NEUTRAL
from tests.fake_onshape import outlines, solids
from tests.support.recorded import DATA, needs_data

# A unit cube, corner at the origin: each face as four corners, anticlockwise from outside.
CORNERS = [[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]
SIDES = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
HOLE = outlines.circle(0.02, at=(0.1, 0.05), segments=24)
RED, BLUE = {"color": [255, 0, 0], "opacity": 255}, {"color": [0, 0, 255], "opacity": 51}


def read(reply, part="A"):
    """The mesh of a part in a reply, by way of the compact form."""
    return part_mesh.decode_meshes(reply_triangles.compact(reply), {part})[part]


def xyz(*point):
    return dict(zip("xyz", point, strict=True))


def body(form="table", name="A", scale=1.0, appearance=None, faces=None):
    """A cube's record: "table" (facetPoints and indices) or "loose" (vertices in each facet)."""
    points = [xyz(*(scale * value for value in corner)) for corner in CORNERS]
    record = {"id": name, "faces": [], "facetPoints": []}
    for number, (a, b, c, d) in enumerate(SIDES):
        triangles = (a, b, c), (a, c, d)
        if form == "table":  # as the server does: each face brings its own copies of its corners
            used = sorted({a, b, c, d})
            first = len(record["facetPoints"])
            record["facetPoints"] += [points[corner] for corner in used]
            facets = [{"indices": [first + used.index(k) for k in triangle]} for triangle in triangles]
        else:
            facets = [{"vertices": [dict(points[k]) for k in triangle]} for triangle in triangles]
        record["faces"].append({"facets": facets} | ({"appearance": faces[number]} if faces else {}))
    return record | ({"appearance": appearance} if appearance else {})


def reply(*bodies, bare=False):
    return json.dumps(list(bodies) if bare else {"facetPoints": [], "bodies": list(bodies)}).encode()


def lists(record):
    """A record in the old way: points as lists."""
    return json.loads(json.dumps(record), object_hook=lambda d: [*d.values()] if set(d) == set("xyz") else d)


def assert_closed(mesh, triangles):
    assert (len(mesh.surface.triangles), mesh.closed, mesh.volume) == (triangles, True, pytest.approx(1))


@pytest.mark.parametrize("form", ["table", "loose"])
@pytest.mark.parametrize("old", [False, True])
def test_every_form_of_a_cube_is_the_same_closed_cube(form, old):
    mesh = read(reply(lists(body(form)), bare=True) if old else reply(body(form)))
    assert_closed(mesh, 12)
    assert mesh.surface.area() == pytest.approx(6, abs=1e-15)
    assert mesh.surface.vertices.tolist() == sorted(map(list, CORNERS))
    assert mesh.palette == (NEUTRAL,)


def test_wanted_parts_alone_are_read_if_they_have_triangles():
    bodies = [body(name="A"), body(name="B"), {"id": "C", "faces": "broken"}, {"id": "E", "faces": []}]
    data = reply_triangles.compact(reply(*bodies, {"id": "F"}))
    assert set(part_mesh.decode_meshes(data, {"B", "D", "E", "F"})) == {"B"}


def test_order_of_faces_points_and_corners_does_not_matter():
    rng = np.random.default_rng(7)
    record = body("loose", faces=[RED] * 3 + [BLUE] * 3)
    plain = read(reply(record))
    rng.shuffle(record["faces"])
    for face in record["faces"]:
        rng.shuffle(face["facets"])
        for facet in face["facets"]:
            turn = int(rng.integers(3))
            facet["vertices"] = facet["vertices"][turn:] + facet["vertices"][:turn]
    shuffled = read(reply(record))
    assert shuffled.surface.vertices.tobytes() == plain.surface.vertices.tobytes()
    assert shuffled.surface.triangles.tolist() == plain.surface.triangles.tolist()
    assert shuffled.colours.tolist() == plain.colours.tolist()


def test_face_colour_wins_over_body_colour_and_that_over_grey():
    mesh = read(reply(body(appearance=BLUE, faces=[RED] + [None] * 5)))
    red, blue = (1.0, 0.0, 0.0, 1.0), (0.0, 0.0, 1.0, 0.2)
    assert mesh.palette == (blue, red)
    in_red = mesh.surface.corners[mesh.colours == mesh.palette.index(red)]
    assert in_red.shape == (2, 3, 3)
    assert (in_red[:, :, 0] == 0).all()  # the first side is at x = 0


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


@settings(max_examples=40, deadline=None)
@given(name=st.sampled_from(sorted(SOLIDS)), seed=st.integers(0, 2**32 - 1))
def test_solid_stays_closed_whatever_last_digits_its_faces_have(name, seed):
    solid, thickness = SOLIDS[name]
    rng = np.random.default_rng(seed)
    faces = []
    for face in solid.faces:  # each face brings its own copies of its corners, each a little off
        corners = solid.vertices[face.triangles]
        noisy = corners + rng.uniform(-1e-9, 1e-9, corners.shape)
        faces.append({"facets": [{"vertices": row} for row in noisy.tolist()]})
    mesh = read(reply({"id": "A", "faces": faces}))
    used = np.unique(solid.triangles)
    assert mesh.closed
    assert len(mesh.surface.vertices) == len(np.unique(solid.vertices[used], axis=0))
    assert len(mesh.surface.triangles) == len(solid.triangles)
    assert mesh.volume == pytest.approx(solid.properties.volume, rel=8e-9 / thickness)


def test_points_that_are_apart_are_not_welded():
    record = body("loose", scale=0.1)
    record["faces"][0]["facets"][0]["vertices"][0]["x"] += 1e-7
    assert not read(reply(record)).closed


def test_triangles_that_lose_a_corner_go_and_slivers_stay():
    record = body("loose")
    record["faces"][0]["facets"].append({"vertices": [xyz(0, 0, 0), xyz(0, 0, 0), xyz(0, 1, 0)]})
    assert_closed(read(reply(record)), 12)
    # A side meets its neighbour's edge at a point that only a triangle without area connects.
    a, m, b, low, high = xyz(0, 0, 0), xyz(0, 0.5, 0), xyz(0, 1, 0), xyz(0, 0, 1), xyz(0, 1, 1)
    triangles = [a, low, m], [low, high, m], [high, b, m], [a, m, b]
    record["faces"][0]["facets"] = [{"vertices": triangle} for triangle in triangles]
    assert_closed(read(reply(record)), 14)


def test_facet_becomes_a_fan_and_a_solid_inside_out_is_turned():
    points = [xyz(*corner) for corner in CORNERS]
    faces = [{"facets": [{"indices": side}]} for side in SIDES]
    assert_closed(read(reply({"id": "A", "facetPoints": points, "faces": faces})), 12)
    faces = [{"facets": [{"indices": side[::-1]}]} for side in SIDES]
    turned = read(reply({"id": "A", "facetPoints": points, "faces": faces}))
    assert turned.surface.volume() == pytest.approx(1)


@pytest.mark.parametrize(
    ("change", "why"),
    [
        ({"facetPoints": [xyz(0, 0, 0)]}, "lies outside of the 1 points"),
        ({"facetPoints": [{"x": 0, "y": 0}] * 24}, "'z'"),
        ({"facetPoints": [{"x": 0, "y": 0, "z": None}] * 24}, "part A"),
        ({"faces": [{"facets": [7]}]}, "part A"),
    ],
)
def test_triangles_in_no_form_are_an_error_that_names_the_part(change, why):
    with pytest.raises(ProtocolError) as caught:
        read(reply(body() | change))
    assert why in str(caught.value)
    with pytest.raises(ProtocolError, match="not JSON"):
        read(b'{"bodies": [')


def base64(*channels):
    return b64encode(bytes(channels)).decode()


@pytest.mark.parametrize(
    ("appearance", "colour"),
    [
        ({"color": [255, 0, 51]}, (1, 0, 0.2, 1)),
        ({"color": ["255", "0", "51"], "opacity": 0}, (1, 0, 0.2, 0)),
        ({"color": [-1, 0, 51], "opacity": 255}, (1, 0, 0.2, 1)),
        ({"color": [math.inf, 0, 51]}, NEUTRAL),
        ({"color": base64(255, 0, 51)}, (1, 0, 0.2, 1)),
        ({"color": base64(255, 0, 51, 102)}, (1, 0, 0.2, 0.4)),
        ({"color": base64(255, 0, 51, 102), "opacity": 204}, (1, 0, 0.2, 0.8)),
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
def test_recorded_reply_is_read():
    data = (DATA / "star_tessellatedfaces_subset.json").read_bytes()
    mesh = read(data, "JRH")
    assert mesh.surface.vertices.shape == (4, 3)
    # The recorded face is a rectangle of 203.2 mm by 22.12 mm.
    assert mesh.surface.area() == pytest.approx(0.2032 * np.hypot(0.0191595, 0.0110617), rel=1e-12)
    assert not mesh.closed
    bare = json.dumps(json.loads(data)["bodies"]).encode()
    assert read(bare, "JRH").surface.vertices.tobytes() == mesh.surface.vertices.tobytes()
