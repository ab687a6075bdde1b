"""What bounds calls: the server's windows, and the number that one build may make."""

from threading import Event, Thread
from time import monotonic, sleep

import pytest

from linkwright.stages.fetch.onshape.api.http_errors import rate_limited
from linkwright.stages.fetch.onshape.api.rate_limits import RateLimits, remaining_calls, retry_after
from linkwright.stages.fetch.onshape.call_budget import Budget, allow
from linkwright.stages.robot.errors import SourceError


def test_a_closed_window_holds_back_its_own_kind_until_it_opens():
    stopped, waits, start = Event(), [], monotonic()
    stopped.wait = lambda seconds: waits.append(seconds) or sleep(seconds)
    windows = RateLimits(10, stopped)
    assert windows.close("massproperties", 0.2)
    windows.wait("elements")
    assert waits == []
    windows.wait("massproperties")
    assert monotonic() - start >= 0.2


def test_concurrent_waits_count_once_and_have_a_bound():
    windows = RateLimits(10, Event())
    assert all(windows.close(kind, 6) for kind in ("a", "b", "a"))
    assert windows.waited == pytest.approx(6, abs=0.1)
    assert windows.close("a", 9)
    assert windows.waited == pytest.approx(9, abs=0.1)
    assert not windows.close("b", 11)
    assert not RateLimits(0, Event()).close("a", 0.001)
    assert windows.waited == pytest.approx(9, abs=0.1)


def test_a_stop_ends_a_wait():
    stopped = Event()
    windows = RateLimits(1000, stopped)
    windows.close("a", 900)
    thread = Thread(target=windows.wait, args=("a",), daemon=True)
    thread.start()
    stopped.set()
    thread.join(5)
    assert not thread.is_alive()


def test_a_wait_is_seconds_or_a_date_or_unknown():
    date, noon = "Wed, 21 Oct 2026 07:28:00 GMT", 1792567680.0 - 1000
    for headers, seconds in (
        ({"Retry-After": "450"}, 450),
        ({"Retry-After": " 0 "}, 0),
        ({"Retry-After": date, "Date": "Wed, 21 Oct 2026 07:27:00 GMT"}, 60),
        ({"Retry-After": date, "Date": "Wed, 21 Oct 2026 07:29:00 GMT"}, 0),
        ({"Retry-After": date}, 1000),
        *(({"Retry-After": text}, None) for text in ("soon", "-5", "²", "9" * 30)),
        ({}, None),
    ):
        assert retry_after(headers, now=lambda: noon) == seconds, headers


def test_the_calls_left_are_a_number_or_unknown():
    texts = [{"X-Rate-Limit-Remaining": "399"}, {"X-Rate-Limit-Remaining": "many"}, {}]
    assert [remaining_calls(headers) for headers in texts] == [399, None, None]


def test_calls_on_their_way_cannot_overdraw_together():
    budget = Budget(2)
    with budget.slot(), budget.slot():
        with pytest.raises(SourceError, match="max_calls is 2"), budget.slot():
            pass
        assert budget.made == 0


def test_a_call_that_failed_gives_its_place_back():
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


def test_as_many_calls_as_allowed_may_be_made_and_no_more():
    allow(3, 2, 5)
    allow(0, 5, 5)
    with pytest.raises(SourceError, match=r"this build needs 6 calls, but source.max_calls is 5") as caught:
        allow(6, 0, 5)
    assert caught.value.hint == "set source.max_calls=6 or more"
    with pytest.raises(SourceError, match=r"made 1 call and needs 5 more, but source.max_calls is 5"):
        allow(5, 1, 5)


def test_no_wait_is_advised_that_is_allowed_already():
    facts = {"waited": 8.0, "max_wait": 120.0}
    hints = [rate_limited("x", "", "h", requested=seconds, **facts).hint for seconds in (0.0, 450.0)]
    assert ["source.max_wait" in hint for hint in hints] == [False, True]
