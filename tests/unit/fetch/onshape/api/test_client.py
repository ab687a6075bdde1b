"""The client against a bare server: what is sent and counted, what is asked again, what a refusal says."""

import threading
from contextlib import contextmanager
from dataclasses import replace
from email.utils import formatdate
from time import monotonic, sleep, time

import pytest

from linkwright.stages.fetch.onshape.api.http_errors import Declined
from linkwright.stages.fetch.onshape.call_budget import Budget
from linkwright.stages.robot import errors
from linkwright.stages.robot.errors import Offline, ProtocolError, QuotaExhausted, RateLimited, SourceError
from tests.support.bare_server import hang_up, reply, serving
from tests.support.cases import mostly_slow
from tests.support.kept import QUICK, client_at

MASS = "/partstudios/d/D/m/M/e/STUDIO/massproperties?configuration=a%3Db%2Bc"
DEFINITION = "/assemblies/d/D/w/W/e/ROOT?configuration=default"
CONFIGURED = "/assemblies/d/D/w/W/e/ROOT?configuration=leg%3D0.25%20m"
VARIABLES = "/variables/d/D/w/W/e/E/variables"
OK = reply(200, b"{}")


@contextmanager
def client_of(*answers, patience=QUICK, **more):
    """A client of a bare server with these answers, and the list of requests."""
    with (
        serving(*answers) as (port, asked),
        client_at(f"http://127.0.0.1:{port}", patience=patience, **more) as client,
    ):
        yield client, asked


def test_the_canonical_request_is_sent_as_it_is_with_basic_auth():
    server = reply(200, b"{}", X_Api_Version="v16", On_Version="1.218.0")
    with client_of(server) as (client, asked):
        assert client.get(MASS) == b"{}"
        assert client.server_facts == {"api": "v16", "release": "1.218.0"}
    ((line, headers, _),) = asked
    assert line == f"GET /api/v16{MASS} HTTP/1.1"
    assert headers["authorization"] == "Basic dGhlLWFjY2Vzczp0aGUtc2VjcmV0"
    assert "gzip" in headers["accept-encoding"]


LATER = {"Retry_After": "450"}
IN_AN_HOUR = {"Retry_After": "a date"}


@pytest.mark.parametrize(
    ("request_", "status", "headers", "error", "times", "words"),
    [
        (DEFINITION, 401, {}, "AuthError", 1, "works only on the host where it was made"),
        (MASS, 403, {}, "AuthError", 1, "may not read the mass properties of part studio STUDIO"),
        (MASS, 403, {"Date": formatdate(0, usegmt=True)}, "AuthError", 1, "ahead of the server's"),
        (MASS, 402, {}, "QuotaExhausted", 1, "yearly quota"),
        (DEFINITION, 404, {}, "NotFound", 1, "a part studio or a drawing?"),
        (MASS, 404, {}, "NotFound", 1, "not shared with you"),
        (CONFIGURED, 404, {}, "NotFound", 1, "deleted, not shared"),
        (MASS, 429, LATER, "RateLimited", 1, "wait 450 s"),
        (MASS, 429, IN_AN_HOUR, "RateLimited", 1, "in 60 min"),
        (MASS, 429, {"Retry_After": "soon"}, "RateLimited", QUICK.refusals, "(429)"),
        (MASS, 429, {}, "RateLimited", QUICK.refusals, "(429)"),
        (MASS, 405, {}, "Declined", 1, "the form of the request"),
        (MASS, 406, {}, "Declined", 1, "(406)"),
        (MASS, 415, {}, "Declined", 1, "(415)"),
        (MASS, 418, {}, "Declined", 1, "(418)"),
        (MASS, 400, {}, "Declined", 1, "(400)"),
        (DEFINITION, 400, {}, "SourceError", 1, "perhaps a part studio or a drawing (400)"),
        (CONFIGURED, 400, {}, "SourceError", 1, "refuses the configuration 'leg=0.25 m' (400)"),
        (CONFIGURED, 400, {}, "SourceError", 1, "which is checked against the document"),
        (MASS, 304, {}, "ProtocolError", 1, "not followed"),
        (MASS, 499, {}, "ProtocolError", 3, "tried 3 times"),
        (MASS, 500, {}, "ProtocolError", 3, "failed to give"),
        (MASS, 503, {}, "ProtocolError", 3, "failed to give"),
        (MASS, 503, {"Retry_After": "5000"}, "ProtocolError", 1, "(503)"),
    ],
)
def test_a_refusal_is_explained_in_the_servers_words(request_, status, headers, error, times, words):
    body = b'{"message": "Told\\nso by the-secret.", "status": 0}'
    if headers is IN_AN_HOUR:
        headers = {"Retry_After": formatdate(time() + 3600, usegmt=True)}
    with client_of(reply(status, body, **headers)) as (client, asked), pytest.raises(SourceError) as caught:
        client.get(request_)
    assert type(caught.value) is (Declined if error == "Declined" else getattr(errors, error))
    assert words in str(caught.value)
    assert "the-secret" not in str(caught.value)
    assert "127.0.0.1" in caught.value.where
    assert len(asked) == times
    assert status == 304 or "Told so by ***." in caught.value.message


def test_a_web_page_is_never_quoted_nor_taken_for_a_reply():
    page = b"<!doctype html><html><body>Sign in</body></html>"
    with client_of(reply(502, page)) as (client, _), pytest.raises(ProtocolError) as caught:
        client.get(MASS)
    assert "html" not in caught.value.message
    with client_of(reply(200, b"  " + page)) as (client, _), pytest.raises(ProtocolError, match="a web page"):
        client.get(MASS)


@pytest.mark.parametrize("first", [reply(500), reply(502, b"<html>"), reply(499), hang_up])
def test_a_call_that_fails_unbilled_is_made_three_times(first):
    lines = []
    with client_of(first, first, OK, progress=lines.append) as (client, _):
        assert client.get(MASS) == b"{}"
        assert client.calls == 1
    assert len(lines) == 2
    assert "trying again in" in lines[0]
    with client_of(first) as (client, _), pytest.raises((ProtocolError, Offline), match="tried 3 times"):
        client.get(MASS)


def slowly(body, pause):
    """An answer that sends a body in two or more pieces."""

    def answer(handler):
        handler.send_response_only(200)
        handler.send_header("Content-Length", str(sum(map(len, body))))
        handler.end_headers()
        for piece in body:
            handler.wfile.write(piece)
            handler.wfile.flush()
            sleep(pause)

    return answer


def test_a_reply_that_drips_is_given_up():
    for answer, waits, calls in (
        (slowly([b" "] * 1000, 0.01), {"whole": 0.1, "read": 5}, 2),
        (lambda handler: sleep(0.4), {"read": 0.05}, 0),
    ):
        with client_of(answer, patience=replace(QUICK, **waits)) as (client, _):
            with pytest.raises(Offline, match="did not answer in time"):
                client.get(MASS)
            assert client.calls == calls


def test_a_closed_window_is_waited_for():
    lines, closed = [], reply(429, Retry_After="0")
    answers = *[closed] * 3, reply(200, b"{}", X_Rate_Limit_Remaining="7")
    with client_of(*answers, progress=lines.append) as (client, _):
        assert client.get(MASS) == b"{}"
        assert (client.calls, len(lines), client.left) == (1, 3, {"massproperties": 7})
        assert client.waited > 0


@pytest.mark.parametrize("refused", [reply(402), reply(429, Retry_After="5000")])
def test_the_end_of_the_quota_ends_all_calls_and_waits(refused):
    with client_of(reply(429, Retry_After="100"), refused) as (client, asked):
        caught = []

        def wait():
            try:
                client.get("/documents/d/D/w/W/waits")
            except SourceError as error:
                caught.append(error)

        thread = threading.Thread(target=wait)
        thread.start()
        while not client.waited:
            sleep(0.001)
        with pytest.raises((QuotaExhausted, RateLimited)) as first:
            client.get(MASS)
        thread.join(5)
        assert not thread.is_alive()
        with pytest.raises(type(first.value)):
            client.get(DEFINITION)
    assert type(caught[0]) is type(first.value)
    assert len(asked) == 2


@pytest.mark.parametrize("begun", [False, True], ids=["no answer yet", "within the body"])
def test_a_stop_ends_a_call_on_its_way_for_good(begun):
    over, lines = threading.Event(), []

    def slow(handler):
        if begun:
            reply(200, length=100)(handler)
        over.wait(20)

    patience = replace(QUICK, read=20.0, whole=20.0)
    with client_of(slow, patience=patience, progress=lines.append) as (client, asked):
        threading.Timer(0.3, client.stop).start()
        with pytest.raises(Offline, match="stopped"):
            client.get(MASS)
        over.set()
    assert (len(asked), lines) == (1, [])


@pytest.mark.parametrize(
    ("answer", "limit"),
    [(reply(200, b"{}", length=9), 1), (reply(302, Location=f"/api/v16{MASS}"), 2)],
    ids=["asked again", "sent elsewhere"],
)
def test_a_bound_on_calls_holds_for_what_was_not_planned(answer, limit):
    with client_of(answer, budget=Budget(limit)) as (client, _), pytest.raises(SourceError) as caught:
        client.get(MASS)
    assert (client.calls, caught.value.where) == (limit, "source.max_calls")
    assert f"source.max_calls={limit + 1} or more; what was fetched is kept" in caught.value.hint


def test_an_undo_is_posted_whatever_the_bound_on_calls():
    with client_of(OK, budget=Budget(0)) as (client, _):
        with pytest.raises(SourceError, match="max_calls is 0"):
            client.get(MASS)
        assert client.post(VARIABLES, b"[]", restoring=True) == b"{}"


def test_a_post_is_sent_again_only_if_it_cannot_have_been_done():
    with client_of(reply(429), reply(200, b"[]")) as (client, asked):
        assert client.post(VARIABLES, b"[1]") == b"[]"
        assert client.calls == 1
    sent = [(line.split()[0], headers["content-type"], body) for line, headers, body in asked]
    assert sent == [("POST", "application/json", b"[1]")] * 2


@pytest.mark.parametrize("bad", [reply(500), reply(200, b"[", length=9), hang_up, reply(302, Location="/x")])
def test_a_post_that_may_have_been_done_is_not_repeated(bad):
    with client_of(bad) as (client, asked), pytest.raises(SourceError):
        client.post(VARIABLES, b"[1]")
    assert len(asked) == 1


@pytest.mark.parametrize("bad", [reply(500), reply(499), hang_up])
def test_an_undo_is_posted_again_within_bounds(bad):
    with client_of(bad, reply(200, b"[]"), bad) as (client, asked):
        assert client.post(VARIABLES, b"[1]", restoring=True) == b"[]"
        assert len(asked) == 2
        with pytest.raises(SourceError, match="tried 3 times"):
            client.post(VARIABLES, b"[1]", restoring=True)
        assert len(asked) == 2 + 3


@pytest.mark.parametrize("status", mostly_slow([402, 429], keep=1))
def test_an_undo_is_posted_where_all_calls_were_stopped(status):
    times = []

    def post(handler):
        times.append(monotonic())
        (reply(429, Retry_After="1") if len(times) == 1 else reply(200, b"[]"))(handler)

    with client_of(reply(status, Retry_After="450"), post) as (client, _):
        for call in (client.get, client.get, lambda _: client.post(VARIABLES, b"[1]")):
            with pytest.raises((QuotaExhausted, RateLimited)):
                call(MASS)
        assert times == []
        assert client.post(VARIABLES, b"[1]", restoring=True) == b"[]"
    # Its own window is waited for all the same.
    assert times[1] - times[0] >= 1


def test_long_replies_show_how_much_has_arrived():
    lines = []
    short, long = slowly([b"1" * 25] * 2, 0), slowly([b"1" * 1_500_000] * 2, 0.3)
    with client_of(short, long, transient=lines.append) as (client, _):
        client.get("/short")
        assert lines == []
        client.get("/long")
    shown = [float(line.removesuffix(" MB received")) for line in lines]
    assert 1 <= len(shown) <= 5
    assert shown == sorted(shown)
    assert shown[0] >= 1.0
    assert shown[-1] > 1.5
