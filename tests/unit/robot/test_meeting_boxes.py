"""Boxes that meet: as by looking at every pair."""

from itertools import combinations

import numpy as np
import pytest

from linkwright.stages.robot.contact.meeting_boxes import meeting_boxes


@pytest.mark.parametrize("number", [0, 1, 2, 40])
def test_the_boxes_that_meet_are_those_of_every_pair(number):
    rng = np.random.default_rng(5)
    low = rng.uniform(size=(number, 3))
    high = low + rng.uniform(0.0, 0.4, size=(number, 3))
    every = [
        [first, other]
        for first, other in combinations(range(number), 2)
        if (low[first] <= high[other]).all() and (low[other] <= high[first]).all()
    ]
    assert meeting_boxes(low, high).tolist() == every
