"""The solids that the local Onshape serves have exact mass properties."""

import numpy as np
import pytest

from tests.fake_onshape import outlines, solids
from tests.fake_onshape.frames import frame


def test_a_box_has_the_closed_form_mass_properties():
    x, y, z = 0.12, 0.34, 0.05
    properties = solids.box(x, y, z, at=(1.0, -2.0, 3.0)).properties
    assert properties.volume == pytest.approx(x * y * z, rel=1e-13)
    assert properties.area == pytest.approx(2 * (x * y + y * z + z * x), rel=1e-13)
    assert properties.centroid == pytest.approx([1, -2, 3], abs=1e-13)
    expected = x * y * z / 12 * np.diag([y * y + z * z, x * x + z * z, x * x + y * y])
    assert properties.inertia == pytest.approx(expected, abs=1e-15)


def test_a_part_of_two_shells_weighs_as_much_as_both():
    box, tube = solids.box(0.1, 0.2, 0.3), solids.tube(0.1, 0.05, 0.2, 0.01).moved(frame((1, 0, 0)))
    both = (box + tube).properties
    assert both.volume == pytest.approx(box.properties.volume + tube.properties.volume, rel=1e-12)
    assert both.area == pytest.approx(box.properties.area + tube.properties.area, rel=1e-12)


def test_an_outline_that_crosses_itself_is_refused():
    with pytest.raises(ValueError, match="crosses itself"):
        outlines.triangulate(np.array([(0, 0), (2, 2), (2, 0), (0, 2), (1, 3)], float))
