"""The server's windows: what is waited for, and how it says so."""

from threading import Event, Thread
from time import monotonic

import pytest

from linkwright.stages.fetch.onshape.api.rate_limits import Windows, left, retry_after


def test_a_closed_window_holds_back_its_own_kind_until_it_opens():
    windows = Windows(10, Event())
    assert windows.close("massproperties", 0.4)
    start = monotonic()
    windows.wait("elements")
    assert monotonic() - start < 0.3
    windows.wait("massproperties")
    assert monotonic() - start >= 0.4


def test_waits_at_the_same_time_count_once_and_their_sum_has_a_bound():
    windows = Windows(10, Event())
    assert all(windows.close(kind, 6) for kind in ("a", "b", "a"))
    assert windows.waited == pytest.approx(6, abs=0.1)
    assert windows.close("a", 9)
    assert windows.waited == pytest.approx(9, abs=0.1)
    assert not windows.close("b", 11)
    assert not Windows(0, Event()).close("a", 0.001)
    assert windows.waited == pytest.approx(9, abs=0.1)


def test_a_stop_ends_a_wait():
    stopped = Event()
    windows = Windows(1000, stopped)
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


def test_what_is_left_is_a_number_or_unknown():
    texts = [{"X-Rate-Limit-Remaining": "399"}, {"X-Rate-Limit-Remaining": "many"}, {}]
    assert [left(headers) for headers in texts] == [399, None, None]
