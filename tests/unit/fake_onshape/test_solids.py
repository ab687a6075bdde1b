"""The solids that the local Onshape serves: closed, and their mass properties exact."""

import numpy as np
import pytest

from tests.fake_onshape import outlines, solids
from tests.fake_onshape.frames import frame

SHAPES = {
    "box": solids.box(0.1, 0.2, 0.3),
    "plate": solids.extrude(
        outlines.rounded_rectangle(0.2, 0.1, 0.02),
        0.01,
        0.001,
        [outlines.circle(0.005, (x, y), 12) for x in (-0.08, 0.08) for y in (-0.03, 0.03)],
    ),
    "bent": solids.extrude(outlines.stroke([(0, 0), (0.018, 0.028), (0.004, 0.062)], 0.0065), 0.01, 0.001),
    "gear": solids.extrude(outlines.gear(14, 0.014), 0.006, 0, [outlines.circle(0.004)]),
    "link": solids.extrude(outlines.hull(outlines.circle(0.02), outlines.circle(0.01, (0.1, 0))), 0.006),
    "cylinder": solids.cylinder(0.1, 0.2, 0.01),
    "tube": solids.tube(0.1, 0.05, 0.2, 0.01),
    "ball": solids.ball(0.1),
}


@pytest.mark.parametrize("name", SHAPES)
def test_every_edge_is_shared_by_two_triangles_in_opposite_directions(name):
    solid = SHAPES[name]
    corners = solid.triangles
    directed = [(int(a), int(b)) for t in corners for a, b in zip(t, np.roll(t, -1), strict=True)]
    assert len(directed) == len(set(directed))
    assert {(b, a) for a, b in directed} == set(directed)
    assert solid.properties.volume > 0


def test_a_box_has_the_closed_form_mass_properties():
    x, y, z = 0.12, 0.34, 0.05
    properties = solids.box(x, y, z, at=(1.0, -2.0, 3.0)).properties
    assert properties.volume == pytest.approx(x * y * z, rel=1e-13)
    assert properties.area == pytest.approx(2 * (x * y + y * z + z * x), rel=1e-13)
    assert properties.centroid == pytest.approx([1, -2, 3], abs=1e-13)
    expected = x * y * z / 12 * np.diag([y * y + z * z, x * x + z * z, x * x + y * y])
    assert properties.inertia == pytest.approx(expected, abs=1e-15)


def test_a_part_of_two_shells_weighs_as_much_as_both():
    box, tube = SHAPES["box"], SHAPES["tube"].moved(frame((1, 0, 0)))
    both = (box + tube).properties
    assert both.volume == pytest.approx(box.properties.volume + tube.properties.volume, rel=1e-12)
    assert both.area == pytest.approx(box.properties.area + tube.properties.area, rel=1e-12)


def test_an_outline_that_crosses_itself_is_refused():
    with pytest.raises(ValueError, match="crosses itself"):
        outlines.triangulate(np.array([(0, 0), (2, 2), (2, 0), (0, 2), (1, 3)], float))
