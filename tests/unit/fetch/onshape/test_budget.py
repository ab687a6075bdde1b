"""The bound on what one build may spend: a call has its place before it is made."""

import pytest

from linkwright.stages.fetch.onshape.call_budget import Budget
from linkwright.stages.robot.errors import SourceError


def test_calls_on_their_way_cannot_overdraw_together():
    budget = Budget(2)
    with budget.slot(), budget.slot():
        with pytest.raises(SourceError, match="max_calls is 2"), budget.slot():
            pass
        assert budget.made == 0


def test_what_came_to_nothing_gives_its_place_back():
    budget = Budget(1)
    with pytest.raises(OSError), budget.slot():
        raise OSError
    with budget.slot() as slot:
        slot.charge(0)
    with budget.slot() as slot:
        slot.charge(1)
    assert budget.made == 1
    with pytest.raises(SourceError, match="made 1 call and needs 1 more"), budget.slot():
        pass


def test_a_call_counts_once_from_when_it_is_billed():
    """While its body still arrives it holds no place beside the call that it came to."""
    for limit in (2, None):
        budget = Budget(limit)
        with budget.slot() as first:
            first.charge(1)
            with budget.slot() as second:
                second.charge(1)
            first.charge(1)
        assert budget.made == 2
